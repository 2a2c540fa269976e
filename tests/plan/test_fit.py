"""Plans whose steps cannot be those of their scenario are neither shown nor played."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.main import app
from gm_ompl.errors import MisfitError
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan

Draft = dict[str, Any]


@pytest.fixture(scope="module")
def regrasp() -> Draft:
    """A plan with both kinds of step."""
    few = ["lattice.segments=4", "fingers.placements.grid=[3, 3]"]
    plan = gm_ompl.plan(gm_ompl.load("paper/regrasp", few)).to_dict()
    assert {step["kind"] for step in plan["steps"]} == {"displacement", "regrasp"}
    return plan


def _of(kind: str, change: Callable[[Draft], object]) -> Callable[[Draft], object]:
    """Return the change of the first step of a kind."""
    return lambda d: change(next(step for step in d["steps"] if step["kind"] == kind))


MISFITS: dict[str, tuple[Callable[[Draft], object], str]] = {
    "a placement short": (_of("displacement", lambda s: s["placements"].pop()), "placements: 1 "),
    "a placement too many": (
        _of("regrasp", lambda s: s["placements"].append(s["to"])), "placements: 3 given",
    ),
    "a mode short": (_of("displacement", lambda s: s["segments"][0]["modes"].pop()), ".modes: 1 "),
    "an f_com too many": (
        _of("displacement", lambda s: s["segments"][1]["f_com"].append(1.0)), "[1].f_com: 3 ",
    ),
    "modes of a regrasp": (_of("regrasp", lambda s: s["modes"].pop()), "modes: 1 given"),
    "no segments": (_of("displacement", lambda s: s["segments"].clear()), "at least one"),
    "no such finger": (_of("regrasp", lambda s: s.update(finger=2)), "finger: 2: "),
    "a coordinate too many": (_of("displacement", lambda s: s["to"].append(0.0)), "1 numbers (s)"),
    "a coordinate far off": (_of("displacement", lambda s: s.update(to=[1e9])), "to[0]: 1e+09"),
    "a regrasp far off": (_of("regrasp", lambda s: s.update(at=[-7.0])), "at[0]: -7"),
    "a long quaternion": (
        _of("displacement", lambda s: s["pose_to"].update(quaternion=[2, 0, 0, 0])), "length 1",
    ),
    "a long normal": (
        _of("displacement", lambda s: s["placements"][0].update(normal=[0, 0, 9])), "has 9",
    ),
    "a force beyond all": (
        _of("displacement", lambda s: s["segments"][0].update(z=1e300)), "z: 1e+300",
    ),
    "fewer fingers": (
        lambda d: d["scenario"]["fingers"].update(
            count=1, radius=[1.0], clearance=[0.5], max_normal_force=[10.0], soft=[0.0],
            start=["any"], goal=["any"],
        ) or d["scenario"]["friction"].update(finger=[0.7]),
        "has 1 fingers",
    ),
    "a cost beyond all": (lambda d: d.update(cost=1e300), "cost: 1e+300"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISFITS)
def test_a_misfit_is_refused_with_its_place(regrasp: Draft, name: str, tmp_path: Path) -> None:
    """Every verb that shows or plays says file, line, key and value; check finds it, too."""
    change, words = MISFITS[name]
    draft = copy.deepcopy(regrasp)
    change(draft)
    with pytest.raises(MisfitError):
        problem_of(Plan.model_validate_json(json.dumps(draft)))
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(draft, indent=1))
    for verb, *rest in (
        ("plot", "--show", "search", "-o", "x.svg"), ("view", "--html", "x.html"),
        ("export", "-o", "x.csv"), ("execute",),
    ):  # fmt: skip
        command = [str(tmp_path / part) if part.startswith("x.") else part for part in rest]
        result = CliRunner().invoke(app, [verb, str(file), *command])
        assert result.exit_code == 2, result.stderr
        assert result.stderr.startswith(f"gm-ompl: {file}:")
        assert words in result.stderr
        assert "gm-ompl check" in result.stderr
    assert CliRunner().invoke(app, ["check", str(file)]).exit_code == 5
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


def test_what_a_planner_makes_fits(regrasp: Draft) -> None:
    """A plan as it was saved is shown."""
    assert problem_of(Plan.model_validate_json(json.dumps(regrasp))).fingers.count == 2


def test_a_wrong_scenario_in_a_plan_is_told_with_the_file(regrasp: Draft, tmp_path: Path) -> None:
    """Every verb names the plan's file, the key and the value."""
    draft = copy.deepcopy(regrasp)
    draft["scenario"]["object"]["mass"] = -1.0
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(draft))
    for verb in (["check"], ["execute"], ["export", "-o", str(tmp_path / "x.csv")]):
        result = CliRunner().invoke(app, [verb[0], str(file), *verb[1:]])
        assert result.exit_code == 2
        assert f"{file}: scenario in the plan: object.mass: value -1.0" in result.stderr
