"""Potentials: lower bounds on travel that no arc of the contact lattice outruns."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.closure import Closure
from gm_ompl.graph.kept_bounds import PlanarBounds, turning_axis
from gm_ompl.graph.potentials import potential
from gm_ompl.scenario.load import load

SETS, NODES = 8, 150

BLOCK = "environment.obstacles.block."
LEANING = (  # a plate on two steps
    "object.shape.box=[4, 1, 0.2]",
    "fingers.radius=0.1",
    "fingers.placements.grid=[3, 1]",
    f"{BLOCK}box={{min: [0, -0.75, 0], max: [1, 0.75, 1]}}",
    "environment.obstacles.upper={box: {min: [1, -0.75, 0], max: [4, 0.75, 2]}}",
    "motion.free.region={x: [-4, 6], y: [0, 0], z: [0, 6]}",
    "motion.start={position: [0.42929, 0, 1.57071], rotation: {axis: [0, 1, 0], angle: -45 deg}}",
    "motion.goal={position: [1.42929, 0, 2.57071], rotation: {axis: [0, 1, 0], angle: -45 deg}}",
)
ALOFT = (  # it turns about its middle, in chords as long as they get
    "object.shape.box=[1, 1, 0.5]",
    "motion.start.position=[0, 0, 1]",
    "motion.goal.position=[0, 0, 1]",
    "lattice.steps.rotation=45 deg",
    "fingers.placements.grid=[1, 1]",
    "cost.samples_at=ends",
)
ASIDE = "motion.free.region.y=[-1, 1]"
BESIDE = f"{BLOCK}box={{min: [-1, 1.7, 0.5], max: [1.5, 3, 1.5]}}"
PLAN = (  # seen from above
    "motion.free.region={x: [-3, 3], y: [-3, 3], z: [0, 3]}",
    "motion.free.rotate=[z]",
    "motion.start.position=[-1.7, 0, rest]",
    "motion.goal={position: [1.5, 1, rest], yaw: 90 deg}",
)
HELD = (  # between plates at its ends, one of which has but a corner of it
    ASIDE,
    "motion.free.translate=[x, y, z]",
    f"{BLOCK}box={{min: [-0.5, 1.7, 0.4], max: [3, 3, 2]}}",
    "environment.obstacles.other={box: {min: [-5, -3, 0.8], max: [-3, -1.7, 2]}}",
    "environment.obstacles.third={box: {min: [-2, -3, -1], max: [-1, -1.7, 0.5]}}",
)
L_SHAPED = (
    "object.shape={pieces: [{box: {min: [0, 0, 0], max: [3, 2, 1]}},"
    " {box: {min: [0, 0.5, 1], max: [1, 2, 3]}}]}",
    "motion.start.position=[-2.5, 0, rest]",
    "motion.goal.position=[0.5, 0, 2.4]",
    "motion.free.translate=[x, y, z]",
    ASIDE,
    f"{BLOCK}box={{min: [-1.2, 0.9166666667, 0], max: [1.5, 3, 1.5]}}",
)
PLANAR = (
    ("tasks/peg-thin-fingers", ()),
    ("tasks/corner-pivot", (ASIDE,)),
    ("tasks/corner-pivot", (ASIDE, "motion.free.translate=[x, y, z]")),
    ("tasks/corner-pivot", (BESIDE,)),
    ("tasks/corner-pivot", (BESIDE, ASIDE, "motion.free.translate=[x, y, z]")),
    ("tasks/corner-pivot", (BESIDE, "mechanics.contact_tolerance=1e-3")),
    ("tasks/corner-pivot", HELD),
    ("tasks/corner-pivot", L_SHAPED),
    ("tasks/corner-pivot", (*PLAN, "motion.free.translate=[x, y]")),
    ("tasks/corner-pivot", (*PLAN, "motion.free.translate=[x, y, z]")),
    (
        "tasks/corner-pivot",
        (
            *PLAN,
            "motion.free.translate=[x, y, z]",
            *L_SHAPED[:1],
            f"{BLOCK}box={{min: [0, -3, 0.5], max: [1, -1.5, 3]}}",
        ),
    ),
    ("tasks/corner-pivot", LEANING),
    ("tasks/ledge", ()),
    ("tasks/pick-card-soft", ALOFT),
    ("tasks/corner-pivot", ()),
    ("tasks/bookshelf", ()),
    ("tasks/pick-card", ()),
    ("free/stairs", ()),
    ("free/l-bracket", ()),
    ("free/out-of-the-corner", ()),
    ("tasks/step-over", ("object.shape.box=[1.3, 1, 0.7]", "motion.goal.position=[3, 0, 0.5]")),
)


def _place(bounds: PlanarBounds, pose: Pose) -> Array:
    """Return one row of ``places``."""
    place: Array = bounds.places(pose.rotation[None], pose.position[None])[0]
    return place


@pytest.mark.parametrize(("name", "changes"), PLANAR)
def test_no_arc_outruns_a_potential(name: str, changes: tuple[str, ...]) -> None:
    """Along every arc a bound falls by at most what the farthest fingertip travels."""
    problem, rng = load(name, changes).problem, np.random.default_rng(7)
    axis, judge = turning_axis(problem), Judge(problem, KernelBackend(problem))
    assert axis is not None
    bounds, closure, graph = PlanarBounds(judge, axis), Closure(judge), problem.object_graph
    closure.grow(np.inf, NODES)
    rows = rng.integers(0, len(problem.fingers.placements), (SETS, problem.fingers.count))
    found = bounds.potentials(rows)
    tips = [np.array([judge.centres(i)[r] for i, r in enumerate(row)]) for row in rows]
    gained = 0.0
    for tail, arcs in list(closure.leaving().items())[:NODES]:
        here = _place(bounds, graph.pose(tail))
        for arc in arcs:
            there = _place(bounds, graph.pose(arc.head))
            for own, centres in zip(found, tips, strict=True):
                fallen = potential(own, here, bounds.target) - potential(own, there, bounds.target)
                travel = float(arc.lengths(centres).sum(axis=1).max())
                assert fallen <= travel + 1e-7 * problem.body.diagonal
                gained = max(gained, fallen)
    assert gained > 0.0


TILTED = [  # its ends, by 2e-5
    [x, y + (2e-5 * (0.6 * x + 0.8 * z) if y > 0 else 0.0), z]
    for x in (-1.7, 1.7) for y in (-1.7, 1.7) for z in (-0.5, 0.5)
]  # fmt: skip
PIN = "{min: [-1.701, 1.7, 0.499], max: [-1.699, 3, 0.501]}"
LEFT = (
    (ASIDE, "motion.free.translate=[x, y]", BESIDE),  # along the block's edges at its end
    ("motion.free.translate=[z]", BESIDE),
    ("motion.free.rotate=[x, y]",),
    ("motion.free.rotate=[z]",),  # and slides on the floor, z not being listed
    (f"{BLOCK}box={PIN}", "mechanics.contact_tolerance=1e-3"),  # a lone point amid its end
    (f"object.shape={{hull: {TILTED}}}", ASIDE,
     f"{BLOCK}box={{min: [-1, 2, 0.5], max: [1.5, 3, 1.5]}}"),
    (f"{BLOCK}box={{min: [0, -3, -1], max: [1.5, 3, -0.5]}}",
     f"{BLOCK}rotation={{axis: [0, 1, 0], angle: 10 deg}}"),  # a slope
)  # fmt: skip


@pytest.mark.parametrize("changes", LEFT)
def test_what_leaves_the_plane_has_none(changes: tuple[str, ...]) -> None:
    """Motion that the plane does not show is bounded otherwise."""
    assert turning_axis(load("tasks/corner-pivot", changes).problem) is None


def test_obstacles_beside_the_object_do_not_matter() -> None:
    """What the object passes by, and what it stands out beyond, leave it in the plane."""
    for y in ("[2, 3]", "[-0.5, 0.5]", "[0, 3]"):
        low, high = y.strip("[]").split(",")
        box = f"{BLOCK}box={{min: [0, {low}, 0], max: [1.5, {high}, 1.5]}}"
        assert turning_axis(load("tasks/corner-pivot", (box,)).problem) == 1


def test_limits_hold_over_many_sets() -> None:
    """Potentials of many sets take long: the limits are looked at on the way."""
    problem = load("tasks/ledge").problem
    bounds = PlanarBounds(Judge(problem, KernelBackend(problem)), 1)
    rows = np.zeros((100_000, problem.fingers.count), dtype=np.int64)
    with limits.holding(0.0), pytest.raises(LimitError):
        bounds.potentials(rows)
