"""The resolved form: saved and loaded again it is the identical problem."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from gm_ompl.errors import ScenarioError
from gm_ompl.motion.arc import Motion
from gm_ompl.problem import Problem
from gm_ompl.scenario.document import dump, parse
from gm_ompl.scenario.load import load, shipped
from gm_ompl.scenario.scenario import Scenario

NAMES = (*shipped(), *(f"random/{f}/{k}" for f in ("chain", "planar", "small") for k in range(6)))


def plain(value: Any) -> Any:
    """A problem's whole content as plain values, bit by bit, for comparison with ==."""
    if isinstance(value, np.ndarray):
        return (value.shape, value.tobytes())
    if isinstance(value, Motion):
        # Poses that are remembered are no part of what a motion is.
        return {key: plain(part) for key, part in vars(value).items() if key != "_known"}
    if is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, (tuple, list)):
        return [plain(part) for part in value]
    return value


def same(a: Problem, b: Problem) -> bool:
    return bool(plain(a) == plain(b))


@pytest.mark.parametrize("name", NAMES)
def test_saved_as_yaml_or_json_it_is_the_identical_problem(name: str, tmp_path: Path) -> None:
    """resolved -> file -> load gives the same arrays, bit for bit, and the same resolved form."""
    scenario = load(name)
    resolved = scenario.resolved()
    texts = {
        "ours.yaml": dump(resolved),
        "pyyaml.yaml": yaml.safe_dump(resolved),
        "plan.json": json.dumps(resolved),
    }
    for file_name, text in texts.items():
        file = tmp_path / file_name
        file.write_text(text, encoding="utf-8")
        again = load(file)
        assert same(again.problem, scenario.problem)
        assert again.resolved() == resolved
    direct = Scenario.from_resolved(resolved)
    assert same(direct.problem, scenario.problem)


def test_the_comparison_sees_a_difference() -> None:
    """The law above can fail: one bit in one number is a different problem."""
    scenario = load("paper/tumble")
    tree = scenario.resolved()
    tree["friction"]["finger"][1] = np.nextafter(0.7, 1)
    assert not same(Scenario.from_resolved(tree).problem, scenario.problem)


def test_hull_and_given_mass_survive(load_changed: Any, tmp_path: Path) -> None:
    """Hulls, a given centre of mass and inertia, given placements and regions resolve too."""
    hull = "{hull: [[0, 0, 0], [5, 0, 0], [0, 5, 0], [5, 5, 0], [2, 2, 9]]}"
    mass = "mass: 1\n  centre_of_mass: [2.5, 2.5, 2.25]\n  inertia: [[3,0,0],[0,3,0],[0,0,3]]"
    scenario = load_changed(
        "path", "{box: [5, 5, 10]}\n  mass: 1", f"{hull}\n  {mass}",
        "motion.start.position=[0, 0, 2.25]", "environment.obstacles={}",
        "motion.path=[{slide: {by: [3, 0, 0]}}]",
        "fingers.placements={grid: [3, 3], faces: [0, 1]}",
    )  # fmt: skip
    file = tmp_path / "again.yaml"
    file.write_text(dump(scenario.resolved()))
    assert same(load(file).problem, scenario.problem)
    region = load_changed(
        "planar", "{position: [12, 6, 2.5], yaw: 90 deg}", "{x: [11, 13], y: [5, 7], yaw: any}",
        "fingers.start=[any, {face: -x, cell: [3, 2]}]",
    )  # fmt: skip
    assert same(Scenario.from_resolved(region.resolved()).problem, region.problem)
    assert region.problem.goal.contains((12.0, 6.0, -3.0))
    assert not region.problem.goal.contains((10.0, 6.0, 0.0))
    assert region.problem.fingers.start[0] is None
    assert region.problem.fingers.start[1] is not None


def test_defaults_and_per_finger_values_are_filled_in(load_changed: Any) -> None:
    """What the file left out stands in the resolved form; one number became one per finger."""
    tree = load_changed("planar").resolved()
    assert tree["fingers"]["radius"] == [1, 1]
    assert tree["friction"]["finger"] == [0.7, 0.7]
    assert tree["fingers"]["soft"] == [0, 0]
    assert "z_floor" not in tree["cost"]  # it follows M g and z_min
    assert tree["fingers"]["start"] == ["any", "any"]
    assert tree["fingers"]["placements"] == {"grid": [7, 7], "faces": "all"}
    assert tree["mechanics"]["z_min"] == 0.5
    assert tree["environment"] == {"floor": True, "obstacles": {}}
    assert load("random/chain/1").resolved()["lattice"]["segments"][2] >= 1


@pytest.mark.parametrize("tree", [None, [], "text", {}, {"format": 1}, {"object": {1: 2}}])
def test_a_tampered_resolved_form_is_an_input_error(tree: Any) -> None:
    """What a plan file holds is checked as strictly as a scenario file."""
    with pytest.raises(ScenarioError):
        Scenario.from_resolved(tree, "plan.json")


@given(
    tree=st.dictionaries(
        st.text(min_size=1).filter(str.isprintable),
        st.recursive(
            st.text(st.characters(codec="utf-8"))
            | st.floats(allow_nan=False, allow_infinity=False)
            | st.integers(-(10**15), 10**15)
            | st.booleans()
            | st.none(),
            lambda inner: st.lists(inner, max_size=3),
            max_leaves=6,
        ),
        min_size=1,
        max_size=4,
    )
)
def test_dump_and_parse_are_inverse(tree: dict[str, Any]) -> None:
    """Any tree of text, numbers and lists is read back as written, "1e3", "yes", "~" included."""
    again = parse(dump(tree), "text").tree
    assert again == tree
    assert repr(again) == repr(tree)


@pytest.mark.parametrize("count", range(6))
def test_zero_to_five_fingers(count: int) -> None:
    """Every allowed number of fingers builds, without gravity too."""
    problem = load("paper/slide", [f"fingers.count={count}", "gravity=0"]).problem
    assert problem.fingers.count == count
    assert problem.fingers.radius.shape == (count,)
    assert problem.mechanics.gravity == 0
