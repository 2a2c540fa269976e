"""Where the object stands: rest, rotations, the contact tolerance, warnings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.solids import box
from tests.verify.resting import hull_in_resting_poses, notched_bar_in_resting_poses

CRATE: dict[str, Any] = {
    "object": {"shape": {"box": [0.05, 0.08, 0.04]}, "mass": 0.2},
    "friction": {"environment": 0.4, "finger": 0.8},
    "fingers": {
        "count": 2, "radius": 0.008, "max_normal_force": 5, "placements": {"grid": [3, 3]},
    },
    "motion": {"start": {"position": [0, 0, 0.02]}, "path": [{"slide": {"by": [0.1, 0, 0]}}]},
    "lattice": {"segments": 6},
    "mechanics": {"z_min": 0.05},
    "cost": {"regrasp": 1, "stability": 0.0005},
}  # fmt: skip
D = math.sqrt(0.05**2 + 0.08**2 + 0.04**2)
HAND = (("-x", (0, 1)), ("-x", (2, 1)))


def crate(changes: dict[str, Any] | None = None) -> gm_ompl.Scenario:
    return gm_ompl.load(CRATE, changes or {})


def start_of(scenario: gm_ompl.Scenario) -> Pose:
    return scenario.problem.motion.pose(scenario.problem.start)


@pytest.mark.parametrize("seed", range(2))
def test_rest_is_the_exact_height(seed: int) -> None:
    """A hull and a bar with a notch, on each side they can lie on: as high as scipy says."""
    for found, wanted, size in (
        *hull_in_resting_poses(seed),
        *notched_bar_in_resting_poses(seed),
    ):
        assert abs(found - wanted) <= 1e-12 * size


def test_rest_stands_on_what_lies_below() -> None:
    """On a step, beside one, on a ramp; the number found is what a plan file keeps."""
    step = {"box": {"min": [-1, -1, 0], "max": [1, 1, 0.3]}}
    rest = {"motion.start.position.2": "rest"}
    on_step = crate({**rest, "environment.obstacles.step": step})
    assert start_of(on_step).position[2] == pytest.approx(0.32, abs=1e-15)
    assert on_step.resolved()["motion"]["start"]["position"][2] == pytest.approx(0.32, abs=1e-15)
    beside = {"box": {"min": [0.025, -1, 0], "max": [1, 1, 0.3]}}
    back = {"motion.path": [{"slide": {"by": [-0.1, 0, 0]}}]}
    flush = crate({**rest, **back, "environment.obstacles.step": beside})
    assert start_of(flush).position[2] == 0.02
    ramp = {"hull": [[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 2], [1, 1, 2]]}
    on_ramp = crate({**rest, **back, "environment.obstacles.ramp": ramp})
    assert start_of(on_ramp).position[2] == pytest.approx(1 + 0.025 + 0.02, abs=1e-12)


@pytest.mark.parametrize(
    "rotation",
    [
        {"axis": [0, 0, 2], "angle": "30 deg"},
        {"quaternion": [math.cos(math.pi / 12), 0, 0, math.sin(math.pi / 12)]},
        {"yaw": "30 deg"},
    ],
)
def test_three_ways_to_write_a_rotation(rotation: dict[str, Any]) -> None:
    """Each means what ``yaw: 30 deg`` means, on a path, in the plane and for an obstacle."""
    plain = start_of(crate({"motion.start.yaw": "30 deg"}))
    turned = start_of(crate({"motion.start.rotation": rotation}))
    assert np.abs(turned.rotation - plain.rotation).max() <= 1e-15
    planar = gm_ompl.load("planar/turn", {"motion.start.rotation": rotation})
    assert planar.problem.start[2] == pytest.approx(math.pi / 6, abs=1e-15)
    block = {"box": {"min": [1, 2, 0], "max": [5, 3, 1]}}
    obstacle = {**block, "rotation": rotation}
    (fixed,) = crate({"environment.obstacles.block": obstacle}).problem.environment.obstacles
    middle = Pose.from_yaw([3, 2.5, 0.5], math.pi / 6)
    wanted = middle.apply(np.array(box([-2, -0.5, -0.5], [2, 0.5, 0.5]).vertices))
    assert np.abs(fixed.body.vertices - wanted).max() <= 1e-14


def test_a_turned_obstacle_is_a_turned_obstacle() -> None:
    """Its hull, turned by hand, gives the same optimal cost."""
    wall = {"box": {"min": [-0.1, -0.3, 0], "max": [-0.05, 0.3, 0.3]}}
    rotation = {"axis": [0, 0, 1], "angle": "20 deg"}
    about = Pose.from_yaw([-0.075, 0, 0.15], math.radians(20))
    corners = np.array(box([-0.025, -0.3, -0.15], [0.025, 0.3, 0.15]).vertices)
    by_hand = {"hull": about.apply(corners).tolist()}
    one = gm_ompl.plan(crate({"environment.obstacles.wall": {**wall, "rotation": rotation}}))
    two = gm_ompl.plan(crate({"environment.obstacles.wall": by_hand}))
    assert one.cost == pytest.approx(two.cost, rel=1e-9)


def test_planar_motion_of_a_lying_object() -> None:
    """A box stood on its side by a rotation plans as the box whose sides are swapped."""
    lying = {
        "object.shape.box": [6, 2, 3],
        "motion.start": {
            "position": [0, 0, "rest"], "rotation": {"axis": [1, 0, 0], "angle": "90 deg"},
        },
        "fingers.placements": {"grid": [2, 1], "faces": ["+x", "-x", "+z", "-z"]},
    }  # fmt: skip
    swapped = {"fingers.placements": {"grid": [2, 1], "faces": ["+x", "-x", "+y", "-y"]}}
    coarse = {"lattice.steps.yaw": "30 deg"}
    first, second = (
        gm_ompl.load("planar/turn", {**coarse, **changes}) for changes in (lying, swapped)
    )
    costs = [gm_ompl.plan(scenario).cost for scenario in (first, second)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-9)
    assert gm_ompl.check(gm_ompl.plan(first)).holds


def test_goals_rest_and_turn_too() -> None:
    """A planar goal at rest is at the start's height; its rotation gives the yaw."""
    tilt = {"axis": [1, 0, 0], "angle": "90 deg"}
    turned = rotation_about([0, 0, 1], 2.0) @ rotation_about([1, 0, 0], math.pi / 2)
    quaternion = Pose(turned, np.zeros(3)).quaternion().tolist()
    goal = {"position": [2, 0, "rest"], "rotation": {"quaternion": quaternion}}
    start = {"position": [0, 0, "rest"], "rotation": tilt}
    found = gm_ompl.load("planar/turn", {"motion.start": start, "motion.goal": goal})
    assert found.problem.goal.low[2] == pytest.approx(2.0, abs=1e-12)
    assert found.resolved()["motion"]["goal"]["position"] == [2.0, 0.0, 1.5]
    with pytest.raises(gm_ompl.ScenarioError, match=r"goal\.rotation: tilts .* by 90 deg"):
        gm_ompl.load("planar/turn", {"motion.goal": {"position": [2, 0, 1], "rotation": tilt}})
    step = {"box": {"min": [3, -1, 0], "max": [4, 1, 0.5]}}
    changes = {"environment.obstacles.step": step, "motion.goal": {"position": [2, 0, "rest"]}}
    with pytest.raises(gm_ompl.ScenarioError, match=r"finds 1\.5, but the start's height is 1\.0"):
        gm_ompl.load("planar/turn", changes)


@pytest.mark.parametrize("relative", [1e-6, -1e-6, 9e-6, 3e-7])
def test_a_start_within_the_tolerance_plans_as_the_exact_one(relative: float) -> None:
    """Too high or too low by less than 1e-5 D: the same cost and the same z, to 1e-9."""
    exact = gm_ompl.plan(crate())
    off = gm_ompl.plan(crate({"motion.start.position.2": 0.02 + relative * D}))
    assert off.status == "solved"
    assert off.cost == pytest.approx(exact.cost, rel=1e-9)
    assert gm_ompl.check(off).holds


def test_a_tilt_of_30_nm_leaves_z_alone() -> None:
    """One corner 30 nm high, by a tilt of the pose or in the shape itself: z stays what it is."""
    exact = gm_ompl.judge(crate(), [0.5], [1], HAND)
    turn = {"axis": [0.7, 1, 0], "angle": f"{30e-9 / 0.1!r} rad"}
    tilted = gm_ompl.judge(crate({"motion.start.rotation": turn}), [0.5], [1], HAND)
    assert exact.decision is not None
    assert tilted.decision is not None
    assert tilted.decision.z == pytest.approx(exact.decision.z, rel=1e-9)
    corners = np.array(box([-0.025, -0.04, -0.02], [0.025, 0.04, 0.02]).vertices)
    corners[0, 2] += 30e-9
    shape = {"hull": corners}
    bent = crate({"object.shape": shape, "motion.start.position.2": "rest"})
    table = bent.problem.fingers.placements
    square = crate().problem.fingers.placements
    rows = []
    for face, cell in HAND:
        row = square.find(face, cell)
        assert row is not None
        rows.append(int(np.abs(table.points - square.points[row]).sum(axis=1).argmin()))
    uneven = gm_ompl.judge(bent, [0.5], [1], rows)
    assert uneven.decision is not None
    assert uneven.decision.z == pytest.approx(exact.decision.z, rel=1e-5)


def test_the_tolerance_is_the_users() -> None:
    """At 1e-7 a start 1e-6 too high touches nothing again; a wider one takes in more."""
    high = {"motion.start.position.2": 0.02 + 1e-6 * D, "mechanics.contact_tolerance": 1e-7}
    assert [w.kind for w in crate(high).warnings] == ["floats"]
    wide = {"motion.start.position.2": 0.02 + 5e-4 * D, "mechanics.contact_tolerance": 1e-3}
    assert crate(wide).warnings == ()
    with pytest.raises(gm_ompl.ScenarioError, match=r"set mechanics\.contact_tolerance to"):
        crate({"object.shape.box.2": 3e-6, "motion.start.position.2": "rest"})


@pytest.mark.parametrize(
    ("height", "kind", "gap"),
    [
        (0.02 + 5e-4 * D, "floats", 5e-4 * D),
        (0.02 + 2e-5 * D, "floats", 2e-5 * D),
        (0.3, "touches nothing", 0.28),
        (0.02 + 9e-6 * D, None, None),
    ],
)
def test_what_floats_is_told(height: float, kind: str | None, gap: float | None) -> None:
    """``Scenario.warnings`` and Python's own carry the number; ``plan`` and ``explain`` warn."""
    scenario = crate({"motion.start.position.2": height})
    if kind is None:
        assert scenario.warnings == ()
        return
    (warning,) = scenario.warnings
    assert (warning.kind, warning.key) == (kind, "motion.start")
    assert warning.gap == pytest.approx(gap, rel=1e-6)
    assert warning.relative == pytest.approx((gap or 0.0) / D, rel=1e-6)
    with pytest.warns(gm_ompl.ScenarioWarning, match="motion.start: at the start the object"):
        gm_ompl.plan(scenario, max_iterations=1)
    if kind == "touches nothing":
        with pytest.warns(gm_ompl.ScenarioWarning):
            gm_ompl.explain(scenario, at=0.5, time_limit=0)


def test_a_goal_in_the_air_is_told() -> None:
    """Lifted at the end, the object touches nothing there; standing still it says nothing."""
    lifted = crate({"motion.path": [{"slide": {"by": [0, 0, 0.1]}}]})
    assert [(w.key, w.kind) for w in lifted.warnings] == [("motion.path", "touches nothing")]
    assert crate().warnings == ()
    assert crate({"motion.start.position.2": 0.3, "gravity": 0}).warnings == ()
