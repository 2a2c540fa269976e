"""Knobs and handles: keys and values of the scenario's file, and nothing else."""

from __future__ import annotations

from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.exploring.handles import Handle, handles
from gm_ompl.exploring.knobs import Slider, knobs
from gm_ompl.scenario.scenario import Scenario

NAMES = (
    "paper/slide", "paper/regrasp", "planar/corner", "planar/turn", "fingers/three",
    "free/around", "free/stairs", "tasks/flip-cube", "random/free-clutter/5", "random/chain/2",
)  # fmt: skip


def written(knob: Slider, value: float) -> str:
    return f"{knob.key}={value} {knob.unit}"


@pytest.fixture(scope="module", params=NAMES)
def scenario(request: pytest.FixtureRequest) -> Scenario:
    return gm_ompl.load(request.param)


def test_knobs_stand_at_the_files_values(scenario: Scenario) -> None:
    """Set to the value that it shows, a knob changes nothing of the scenario."""
    found = knobs(scenario)
    assert len({knob.key for knob in found}) == len(found)
    keys = " ".join(knob.key for knob in found)
    for key in ("friction.environment", "friction.finger", "fingers.radius",
                "fingers.max_normal_force", "mechanics.z_min", "object.mass"):  # fmt: skip
        assert key in keys
    # A range of nothing would stand in the file.
    stated = [knob for knob in found if knob.value or knob.unit != "%"]
    same = scenario.with_([written(knob, knob.value) for knob in stated]).resolved()
    _equal(same, scenario.resolved())


def test_ranges_of_uncertainty_are_knobs() -> None:
    """They begin at what the file states in per cent, else at 0; lists are left to other hands."""
    scenario = gm_ompl.load("paper/slide")
    found = {k.key: k for k in knobs(scenario) if k.key.startswith("uncertainty.")}
    assert {knob.value for knob in found.values()} == {0.0} and len(found) == 4
    for knob in found.values():
        assert scenario.with_(written(knob, 10.0)).problem.uncertainty
        assert not scenario.with_(written(knob, 0.0)).problem.uncertainty
    stated = scenario.with_(["uncertainty={mass: 0.05, finger_friction: [0.1, 0.1]}"])
    keys = {k.key: k.value for k in knobs(stated) if k.key.startswith("uncertainty.")}
    assert keys["uncertainty.mass"] == pytest.approx(5.0 / stated.problem.mass)
    assert "uncertainty.finger_friction" not in keys


def _equal(found: Any, wanted: Any) -> None:
    """Compare, allowing for degrees that become radians."""
    if isinstance(wanted, dict):
        assert found.keys() == wanted.keys()
        for key, value in wanted.items():
            _equal(found[key], value)
    elif isinstance(wanted, list):
        assert len(found) == len(wanted)
        for one, other in zip(found, wanted, strict=True):
            _equal(one, other)
    else:
        assert found == (pytest.approx(wanted, rel=1e-9) if isinstance(wanted, float) else wanted)


def test_sliders_reach_from_end_to_end(scenario: Scenario) -> None:
    """The file's value lies within the slider; both ends are planned with, or refused in words."""
    for knob in knobs(scenario):
        assert knob.low <= knob.value <= knob.high, knob
        assert knob.low < knob.high
        assert not knob.logarithmic or knob.low > 0
        for value in (knob.low, knob.high):
            with suppress(gm_ompl.ScenarioError):  # it may not fit the rest of the scenario
                scenario.with_(written(knob, value))


def shifted(value: Any, by: Any, axis: int | None) -> Any:
    """Return what a dragged value becomes: points all of whose coordinates move, or an interval."""
    if axis is not None:
        return [one + float(by[axis]) for one in value]
    if isinstance(value[0], list):
        return [shifted(row, by, None) for row in value]
    return [one if one == "rest" else one + float(by[k]) for k, one in enumerate(value)]


def dragged(scenario: Scenario, handle: Handle, steps: Any) -> tuple[Scenario, Any]:
    """Return the scenario after a drag, and by how much something was moved."""
    by = sum(
        n * step * np.array(axis)
        for n, step, axis in zip(steps, handle.steps, handle.axes, strict=True)
    )
    words = [f"{one.key}={shifted(one.value, by, one.axis)}" for one in handle.moved]
    return scenario.with_([word.replace("'", "") for word in words]), by


def test_what_is_dragged_moves_by_that_much(scenario: Scenario) -> None:
    """A step of a handle moves the obstacle, the start or the goal by that step, exactly that.

    Heights that are found (``rest``) may change where it stands on something else.
    """
    found = handles(scenario, [])
    assert found[0].kind == "start"
    names = {handle.name for handle in found if handle.kind == "obstacle"}
    assert names == {obstacle.name for obstacle in scenario.problem.environment.obstacles}
    for handle in found:
        done = 0
        for axis, sign in product(np.eye(len(handle.axes)), (1, -1)):
            with suppress(gm_ompl.ScenarioError):  # there is something, or the region ends
                moved, by = dragged(scenario, handle, sign * axis)
                before, after = (place(s, handle) for s in (scenario, moved))
                seen = np.eye(3) if handle.kind == "obstacle" else np.array(handle.axes)
                np.testing.assert_allclose(seen @ (after - before), seen @ by, atol=1e-9)
                done += 1
        assert done, handle


def place(scenario: Scenario, handle: Handle) -> Any:
    """Return where the thing is, by the problem that is planned; its height only where given."""
    problem = scenario.problem
    if handle.kind == "obstacle":
        (body,) = (o.body for o in problem.environment.obstacles if o.name == handle.name)
        return body.vertices.mean(axis=0)
    if handle.kind == "goal" and scenario.model.motion.path is not None:
        return problem.motion.pose((1.0,)).position
    if handle.kind == "start":
        return problem.motion.pose(problem.start).position
    goal = scenario.model.motion.goal
    position = getattr(goal, "position", None)
    if position is not None:
        return np.array(position, dtype=float)
    return np.array([np.mean(getattr(goal, name) or 0.0) for name in "xyz"])


def test_names_that_no_key_can_hold_have_no_handle() -> None:
    """A dot or an equals sign would make another key of it; such an obstacle stays where it is."""
    box = {"box": {"min": [20, 20, 0], "max": [21, 21, 1]}}
    obstacles = dict.fromkeys(("a.b", "a=b", " a", "a b", "<b>"), box)
    scenario = gm_ompl.load("paper/slide").with_({"environment.obstacles": obstacles})
    names = {handle.name for handle in handles(scenario, []) if handle.kind == "obstacle"}
    assert names == {"a b", "<b>"}


def test_a_mesh_from_a_file_has_no_handle(tmp_path: Path) -> None:
    """Where an obstacle's file says where it is, nothing can be dragged."""
    mesh = tmp_path / "tetra.obj"
    mesh.write_text("v 20 0 0\nv 21 0 0\nv 20 1 0\nv 20 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    scenario = gm_ompl.load("paper/slide", {"environment.obstacles": {"t": {"mesh": str(mesh)}}})
    assert [handle.kind for handle in handles(scenario, [])] == ["start", "goal"]
