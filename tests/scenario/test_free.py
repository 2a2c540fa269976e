"""Free motion as a scenario writes it: start, goal, what is open, defaults, resolved form."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gm_ompl
from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import FreeMotion
from gm_ompl.scenario.document import dump, parse
from gm_ompl.scenario.scenario import Scenario

LoadChanged = Callable[..., Scenario]

D = 3.0
"""The diagonal of the text's box, 2 x 2 x 1."""


def motion_of(scenario: Scenario) -> FreeMotion:
    """The scenario's motion, which is free."""
    motion = scenario.problem.motion
    assert isinstance(motion, FreeMotion)
    return motion


def rotation_of(motion: FreeMotion) -> Array:
    """How the object must be turned at the goal, which says so."""
    assert motion.goal.rotation is not None
    return motion.goal.rotation


def test_everything_that_the_file_says(load_changed: LoadChanged) -> None:
    """Start, goal, region, axes and steps come out as written, angles in rad."""
    scenario = load_changed("free")
    motion = motion_of(scenario)
    assert motion.start.position.tolist() == [0, 0, 0.5]
    assert motion.start.rotation.tolist() == np.eye(3).tolist()
    assert motion.region.tolist() == [[-4, 0, 0], [8, 0, 4]]
    assert motion.goal.low.tolist() == motion.goal.high.tolist() == [5, 0, 1.5]
    assert rotation_of(motion).tolist() == [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    assert motion.goal.distance == 0.1
    assert motion.goal.angle == pytest.approx(math.radians(1), rel=1e-15)
    steps = motion.steps
    assert (steps.translation, steps.translate, steps.depth) == (0.5, (0, 2), None)
    assert steps.rotation == pytest.approx(math.pi / 12, rel=1e-15)
    assert steps.rotate is not None
    assert steps.rotate.tolist() == [[0, 1, 0]]
    problem = scenario.problem
    assert (problem.start, problem.lattice.axes, problem.goal.low) == ((), (), ())


def test_what_is_left_out_has_its_default(load_changed: LoadChanged) -> None:
    """All axes, any rotation, no bound on arcs; a goal upright, to 1e-3 D and 0.5 deg."""
    scenario = load_changed(
        "free", ", translate: [x, z], rotate: [y]", "", "motion.goal={position: [1, 0, rest]}"
    )
    motion = motion_of(scenario)
    assert (motion.steps.translate, motion.steps.rotate) == ((0, 1, 2), None)
    assert motion.goal.distance == 1e-3 * D
    assert motion.goal.angle == math.radians(0.5)
    assert motion.goal.low.tolist() == [1, 0, 0.5]
    assert rotation_of(motion).tolist() == np.eye(3).tolist()


@pytest.mark.parametrize(
    ("words", "turn"),
    [
        ("yaw: 30 deg", Rotation.from_euler("z", 30, degrees=True)),
        ("rotation: {yaw: 30 deg}", Rotation.from_euler("z", 30, degrees=True)),
        ("rotation: {axis: [0, 2, 0], angle: -90 deg}", Rotation.from_rotvec([0, -math.pi / 2, 0])),
        ("rotation: {quaternion: [1, 2, 3, 4]}", Rotation.from_quat([2, 3, 4, 1])),
    ],
)  # fmt: skip
def test_a_goal_is_turned_as_scipy_turns(
    words: str, turn: Rotation, load_changed: LoadChanged
) -> None:
    """Whatever the start's rotation, a goal's is from the shape's own axes."""
    goal = f"motion.goal={{position: [1, 0, 2], {words}}}"
    scenario = load_changed("free", "[0, 0, rest]", "[0, 0, rest], yaw: 90 deg", goal)
    np.testing.assert_allclose(rotation_of(motion_of(scenario)), turn.as_matrix(), atol=1e-15)


def test_ranges_left_out_are_the_regions(load_changed: LoadChanged) -> None:
    """A goal on the step, anywhere, its x axis down, whatever the heading."""
    goal = motion_of(load_changed("free", "", "", "motion.goal={x: [3, 8], up: -x}")).goal
    assert goal.low.tolist() == [3, 0, 0]
    assert goal.high.tolist() == [8, 0, 4]
    turned = Rotation.from_euler("ZY", [70, 90], degrees=True).as_matrix()
    assert goal.contains(Pose(turned, np.array([5.0, 0.0, 1.5])))
    assert not goal.contains(Pose(turned.T, np.array([5.0, 0.0, 1.5])))
    assert not goal.contains(Pose(turned, np.array([2.0, 0.0, 1.5])))


def test_any_rotation(load_changed: LoadChanged) -> None:
    """``rotation: any`` asks for the place alone, ``within`` still holds there."""
    goal = motion_of(load_changed("free", "", "", "motion.goal.rotation=any")).goal
    turn = Rotation.from_rotvec([1, 2, 3]).as_matrix()
    assert goal.contains(Pose(turn, np.array([5.09, 0.0, 1.5])))
    assert not goal.contains(Pose(turn, np.array([5.11, 0.0, 1.5])))


def test_no_rotations_and_a_bound(load_changed: LoadChanged) -> None:
    """``rotate: []`` is none at all; with ``depth`` a step need not divide a full turn."""
    steps = motion_of(load_changed("free", "rotate: [y]", "rotate: []")).steps
    assert steps.rotate is not None
    assert steps.rotate.shape == (0, 3)
    change = "lattice={steps: {translation: 1, rotation: 7 deg}, depth: 5}"
    assert motion_of(load_changed("free", "", "", change)).steps.depth == 5


def test_start_is_brought_onto_its_contacts(load_changed: LoadChanged) -> None:
    """A start that misses the floor by less than the tolerance stands on it exactly."""
    motion = motion_of(load_changed("free", "[0, 0, rest]", "[0, 0, 0.500002]"))
    assert motion.start.position[2] == pytest.approx(0.5, abs=1e-12)


def test_what_within_makes_up_for(load_changed: LoadChanged) -> None:
    """A goal may penetrate the step by what ``within`` allows: poses near it do not."""
    load_changed("free", "[5, 0, 1.5]", "[5, 0, 1.41]")
    with pytest.raises(gm_ompl.ScenarioError, match="penetrates obstacle 'step'"):
        load_changed("free", "[5, 0, 1.5]", "[5, 0, 1.3]")


def test_warnings(load_changed: LoadChanged) -> None:
    """What nearly stands is told, start and goal; a goal in the air is what fingers are for."""

    def kinds(old: str, new: str) -> list[tuple[str, str]]:
        return [(w.key, w.kind) for w in load_changed("free", old, new).warnings]

    assert kinds("", "") == kinds("[5, 0, 1.5]", "[5, 0, 3]") == []
    assert kinds("[0, 0, rest]", "[0, 0, 0.501]") == [("motion.start", "floats")]
    assert kinds("[0, 0, rest]", "[0, 0, 2]") == [("motion.start", "touches nothing")]
    assert kinds("[5, 0, 1.5]", "[5, 0, 1.501]") == [("motion.goal", "floats")]


GOALS = [
    "{position: [5, 0, rest], rotation: {axis: [0, 1, 1], angle: 77 deg}}",
    "{position: [1, 0, rest]}",
    "{position: [1, 0, 1], yaw: 33 deg, within: {rotation: 3 deg}}",
    "{position: [5, 0, 1.5], rotation: any}",
    "{x: [0.1, 0.7], up: -z}",
    "{rotation: {quaternion: [1, 2, 3, 4]}}",
]


def content(value: Any) -> Any:
    """Everything in a motion as plain values, bit by bit."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if hasattr(value, "__dict__"):
        return {key: content(part) for key, part in vars(value).items()}
    return value


@pytest.mark.parametrize("goal", GOALS)
def test_resolved_and_loaded_again_it_is_the_identical_motion(
    goal: str, load_changed: LoadChanged
) -> None:
    """Heights, ranges and ``within`` are filled in; as YAML the same bits come out again."""
    scenario = load_changed("free", "", "", f"motion.goal={goal}")
    resolved = scenario.resolved()
    text = dump(resolved)
    assert "rest" not in text
    assert set(resolved["motion"]["goal"]["within"]) == {"position", "rotation"}
    again = Scenario.from_resolved(dict(parse(text, "resolved").tree))  # type: ignore[call-overload]
    assert content(motion_of(again)) == content(motion_of(scenario))
    assert again.resolved() == resolved


def test_a_mapping_with_numpys_numbers(texts: dict[str, str]) -> None:
    """In Python arrays and tuples stand for lists; the motion is that of the file."""
    tree: Any = parse(texts["free"], "free").tree
    motion = tree["motion"]
    motion["free"]["region"] = {"x": np.array([-4, 8]), "y": (0, 0), "z": np.array([0.0, 4.0])}
    motion["free"]["translate"] = ("x", "z")
    motion["goal"]["position"] = np.array([5, 0, 1.5])
    motion["goal"]["within"]["position"] = np.float64(0.1)
    tree["lattice"]["depth"] = np.int64(9)
    made = motion_of(gm_ompl.load(tree))
    assert made.goal.low.tolist() == [5, 0, 1.5]
    assert made.region.tolist() == [[-4, 0, 0], [8, 0, 4]]
    assert made.steps.depth == 9
