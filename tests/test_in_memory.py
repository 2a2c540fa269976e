"""Scenarios made and changed in Python: mappings, numpy's numbers, wrong types named."""

from __future__ import annotations

import copy
import decimal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gm_ompl

TREE: dict[str, Any] = {
    "object": {"shape": {"box": [5, 10, 5]}, "mass": 1},
    "friction": {"environment": 0.5, "finger": 0.7},
    "fingers": {
        "count": 2, "radius": 1, "max_normal_force": 10,
        "placements": {"grid": [2, 3], "faces": ["-x", "+z"]},
    },
    "motion": {"start": {"position": [0, 0, "rest"]}, "path": [{"slide": {"by": [15, 0, 0]}}]},
    "lattice": {"segments": 4},
}  # fmt: skip
NUMPY: dict[str, Any] = {
    "object": {"shape": {"box": np.array([5.0, 10.0, 5.0])}, "mass": np.float32(1)},
    "friction": {"environment": np.float64(0.5), "finger": np.array([0.7, 0.7])},
    "fingers": {
        "count": np.int64(2), "radius": np.int32(1), "max_normal_force": (10, np.int8(10)),
        "placements": {"grid": np.array([2, 3]), "faces": ("-x", "+z")},
    },
    "environment": {"floor": np.bool_(True)},
    "motion": {
        "start": {"position": (np.float32(0), 0, "rest")},
        "path": ({"slide": {"by": np.array([15, 0, 0])}},),
    },
    "lattice": {"segments": np.uint8(4)},
}  # fmt: skip


@pytest.fixture(scope="module")
def cost() -> float:
    found = gm_ompl.plan(TREE)
    assert found.cost is not None
    return found.cost


def test_a_mapping_plans_like_the_file(cost: float, tmp_path: Path) -> None:
    """Numbers of numpy's or Python's, tuples or lists, or written as YAML: one cost."""
    assert gm_ompl.plan(NUMPY).cost == cost
    scenario = gm_ompl.load(TREE)
    file = tmp_path / "written.json"
    gm_ompl.plan(scenario).save(file)
    assert gm_ompl.check(gm_ompl.Plan.load(file)).holds
    assert gm_ompl.load(scenario.resolved()).resolved() == scenario.resolved()
    assert gm_ompl.setup(TREE) is not None


def test_the_mapping_is_left_alone() -> None:
    """Loading, changing and planning write nothing into what the caller holds."""
    tree = copy.deepcopy(TREE)
    gm_ompl.load(tree, {"object.mass": 2}).with_({"fingers.count": 1})
    assert tree == TREE


def test_with_changes_one_value() -> None:
    """By key, by text or by several texts; the scenario before stays what it was."""
    first = gm_ompl.load(TREE)
    for changes in (
        {"fingers.radius": np.float32(0.5)},
        "fingers.radius=0.5",
        ["fingers.radius=0.5"],
    ):
        second = first.with_(changes)
        assert second.problem.fingers.radius.tolist() == [0.5, 0.5]
        assert first.problem.fingers.radius.tolist() == [1, 1]
    higher = first.with_({"object.shape.box.2": 8})
    assert higher.problem.motion.pose((0.0,)).position[2] == 4.0
    listed = first.with_({"motion.path.0.slide.by": np.array([3.0, 0, 0])})
    assert listed.problem.motion.pose((1.0,)).position[0] == 3.0


def test_one_override_is_one_override() -> None:
    """A text is taken whole, not letter by letter; several are several."""
    assert gm_ompl.load("paper/slide", "object.mass=3").problem.mass == 3
    assert gm_ompl.load("paper/slide", ["object.mass=3", "gravity=1"]).problem.mass == 3
    assert gm_ompl.load("paper/slide", {"object.mass": 3}).problem.mass == 3


def test_numpy_numbers_are_seeds_and_limits(cost: float) -> None:
    """Whatever holds a whole or positive number will do, and plan files hold Python's."""
    limits: dict[str, Any] = {
        "seed": np.int64(4), "max_iterations": np.float64(1e6), "time_limit": np.float32(500),
        "memory_limit": np.int32(100_000),
    }  # fmt: skip
    found = gm_ompl.plan(TREE, **limits)
    assert found.cost == cost
    assert type(found.seed) is int
    found = gm_ompl.plan(
        TREE,
        "HybridRRT",
        max_iterations=1,
        parameters={"placement_bias": np.float32(0.25), "batch": np.int64(64)},
    )
    assert (found.parameters["placement_bias"], found.parameters["batch"]) == (0.25, 64)


def test_judge_takes_numpy() -> None:
    """Coordinates, directions, rows and cells may be arrays."""
    rows = gm_ompl.judge(TREE, np.array([0.5]), np.array([1]), np.array([0, 2]))
    cells = gm_ompl.judge(TREE, [0.5], [1.0], [("-x", np.array([0, 0])), ("-x", (0, 2))])
    assert rows.finding == cells.finding


API: Any = gm_ompl
"""The package without its types: what is handed over below is wrong."""

BAD: dict[str, tuple[Callable[[], object], str]] = {
    # Rotations.
    "no rotation": (lambda: _turned({}), r"motion\.start\.rotation.*must be one of \{axis"),
    "half a rotation": (lambda: _turned({"axis": [0, 0, 1]}), "must be one of"),
    "two rotations": (lambda: _turned({"yaw": "1 deg", "quaternion": [1, 0, 0, 0]}), "must be one"),
    "no axis": (lambda: _turned({"axis": [0, 0, 0], "angle": "1 deg"}), "must not be all zeros"),
    "no quaternion": (lambda: _turned({"quaternion": [0, 0, 0, 0]}), "must not be all zeros"),
    "short quaternion": (lambda: _turned({"quaternion": [1, 0, 0]}), "at least 4 entries, has 3"),
    "long axis": (lambda: _turned({"axis": [1, 0, 0, 0], "angle": "1 deg"}), "at most 3 entries"),
    "no unit": (lambda: _turned({"yaw": 30}), r"yaw: value 30: must be an angle with its unit"),
    "not finite": (lambda: _turned({"quaternion": [np.nan, 0, 0, 1]}), "finite number"),
    "no mapping": (lambda: _turned("30 deg"), "must be a mapping of keys"),
    "roll": (lambda: _turned({"roll": "30 deg"}), r"unknown key \(keys here: axis, angle"),
    "yaw twice": (
        lambda: _changed({
            "motion.start": {"position": [0, 0, 3], "yaw": "3 deg", "rotation": {"yaw": "3 deg"}}
        }),
        "give either yaw or rotation",
    ),
    "a tilted wall": (
        lambda: _changed({
            "environment.obstacles.wall": {
                "box": {"min": [50, 0, 0], "max": [60, 1, 1]}, "rotation": {"axis": [0, 1]},
            }
        }),
        r"obstacles\.wall\.rotation\.axis.*at least 3 entries",
    ),
    "a path's goal": (
        lambda: _changed({"motion.goal": {"position": [0, 0, "rest"]}}),
        "a path ends at its last piece",
    ),
    # Heights and tolerances.
    "x at rest": (lambda: _changed({"motion.start.position.0": "rest"}), "only the third"),
    "sleep": (lambda: _changed({"motion.start.position.2": "sleep"}), "number, or rest for"),
    "nothing below": (lambda: _changed({"environment.floor": False}), "give its height"),
    "no tolerance": (lambda: _changed({"mechanics.contact_tolerance": 0}), ">= 1e-09"),
    "wide tolerance": (lambda: _changed({"mechanics.contact_tolerance": 0.1}), "<= 0.001"),
    "thin": (lambda: _changed({"object.shape.box.2": 2e-4}), r"set mechanics\.contact_tolerance"),
    # Mappings.
    "no scenario": (lambda: API.plan(3), r"3 \(int\): must be a name, a file or a mapping"),
    "a list": (lambda: API.load([1]), r"\[1\] \(list\): must be"),
    "empty": (lambda: API.plan({}), "object: missing; add it, for example"),
    "decimal": (lambda: _changed({"object.mass": decimal.Decimal(1)}), r"\(Decimal\): must be"),
    "complex": (lambda: API.load({**TREE, "gravity": 1j}), r"gravity: value 1j \(complex\)"),
    "set": (lambda: API.load({**TREE, "name": {"a"}}), r"name: value \{'a'\} \(set\)"),
    "number for a key": (lambda: API.load({3: 4}), r"the key 3 \(int\) must be text"),
    "array for a number": (lambda: _changed({"object.mass": np.ones(2)}), r"value \[1.0, 1.0\]"),
    "nan": (lambda: _changed({"object.mass": np.float32("nan")}), "must be a finite number"),
    "part of a finger": (lambda: _changed({"fingers.count": np.float64(1.5)}), "whole number"),
    "misspelt": (lambda: API.load({**TREE, "gravty": 1}), "did you mean 'gravity'"),
    "bytes": (lambda: API.load(TREE, b"gravity=1"), r"b'gravity=1' \(bytes\): expected"),
    "a number": (lambda: API.load(TREE, 5), r"5 \(int\): expected KEY=VALUE"),
    "no value": (lambda: API.load(TREE, "gravity"), "expected KEY=VALUE, for example"),
    # Arguments.
    "text for a seed": (lambda: API.plan(TREE, seed="1"), r"seed: '1' \(str\): must be a whole"),
    "true for a seed": (lambda: API.plan(TREE, seed=True), r"seed: True \(bool\)"),
    "half a seed": (lambda: API.plan(TREE, seed=1.5), r"seed: 1\.5: must be a whole"),
    "text for a limit": (
        lambda: API.plan(TREE, time_limit="5 s"),
        r"time limit: '5 s' \(str\): must be a positive number of seconds",
    ),
    "half an iteration": (lambda: API.plan(TREE, max_iterations=0.5), "whole number >= 1"),
    "no planner": (lambda: API.plan(TREE, None), "unknown planner"),
    "no parameters": (lambda: API.plan(TREE, parameters=[1]), r"\(list\): must be a mapping"),
    # Instants.
    "beyond the goal": (
        lambda: API.judge(TREE, [1.5], [1], [0, 1]),
        r"q: \[1\.5\]: s = 1\.5 is outside the scenario's motion; must be from 0 to 1",
    ),
    "before the start": (lambda: API.judge(TREE, [-0.1], None, [0, 1]), "from 0 to 1"),
    "off the plane": (
        lambda: API.judge("planar/turn", [9, 0, 0], None, [0, 1]), "x = 9 is outside",
    ),
    "words": (lambda: API.judge(TREE, "a", None, [0, 1]), r"q: a: must be finite numbers"),
    "two of one": (lambda: API.judge(TREE, [0, 0], None, [0, 1]), r"finite numbers for \(s\)"),
    "no direction": (lambda: API.judge(TREE, [0], ["x"], [0, 1]), "direction: "),
    "no places": (lambda: API.judge(TREE, [0], None, 3), "placements: 3 .int.: must be a list"),
    "half a place": (lambda: API.judge(TREE, [0], None, [0, "-x"]), r"placements\[1\]: -x"),
    "no pose": (lambda: API.judge(TREE, pose=3), r"pose: 3 \(int\): must be a gm_ompl\.Pose"),
}  # fmt: skip


def _changed(changes: dict[str, Any]) -> gm_ompl.Scenario:
    return gm_ompl.load(TREE).with_(changes)


def _turned(rotation: object) -> gm_ompl.Scenario:
    return gm_ompl.load(TREE, {"motion.start.rotation": rotation})


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_told(name: str) -> None:
    """An InputError whose message holds the key, the value or its type, and what would be right."""
    call, wanted = BAD[name]
    with pytest.raises(gm_ompl.InputError, match=wanted):
        call()


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ("motion.start.rotation={axis: [0, 0, 0], angle: 3 deg}", "must not be all zeros"),
        ("motion.start.rotation={yaw: 30}", "an angle with its unit"),
        ("motion.start.position.2=resst", "a finite number, or rest"),
        ("mechanics.contact_tolerance=-1", "must be >= 1e-09"),
    ],
)
def test_the_command_ends_with_2(change: str, wanted: str) -> None:
    """One message, exit code 2."""
    done = subprocess.run(
        [sys.executable, "-m", "gm_ompl", "plan", "paper/slide", "--set", change],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert wanted in done.stderr


def test_the_command_warns() -> None:
    """``plan --json`` says on stderr that the start floats, and prints one object on stdout."""
    done = subprocess.run(
        [sys.executable, "-m", "gm_ompl", "plan", "paper/slide", "--json", "--max-iterations", "1",
         "--set", "motion.start.position.2=2.501"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "gm-ompl: warning: " in done.stderr
    assert "floats 0.001" in done.stderr
    assert done.stdout.startswith("{")


def test_every_exception_is_at_the_top() -> None:
    """Whatever this package raises on purpose can be caught by a name of ``gm_ompl``."""
    from gm_ompl import errors

    for name, value in vars(errors).items():
        if isinstance(value, type) and value.__module__ == errors.__name__:
            assert getattr(gm_ompl, name) is value
