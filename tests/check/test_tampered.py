"""A plan that was tampered with is refused, with the step and the reason."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from gm_ompl.checking import check
from gm_ompl.errors import InputError, PlanError
from gm_ompl.planfile.model import Plan
from tests.check.tampering import CASES, Draft, put, total


@pytest.mark.parametrize("name", CASES)
def test_tampering_is_refused(draft: Draft, name: str) -> None:
    """The report names the step that was tampered with and the reason."""
    case = CASES[name]
    case.tamper(draft)
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert not report.holds
    found = [v for v in report.violations if (v.step, v.topic) == (case.step, case.topic)]
    assert found, report.table()
    assert any(case.words in violation.message for violation in found), report.table()


ONE_STEP = [
    "pose: position, a hair",
    "z: up",
    "z: down",
    "f_com: changed",
    "cost of an arc",
    "placement: point",
    "z: of the rest",
]


@pytest.mark.parametrize("name", ONE_STEP)
def test_only_the_tampered_step_is_blamed(draft: Draft, name: str) -> None:
    """A small change in one step is no violation of another."""
    case = CASES[name]
    case.tamper(draft)
    total(draft)
    report = check(Plan.model_validate_json(json.dumps(draft)))
    assert {violation.step for violation in report.violations} == {case.step}
    assert [step.step for step in report.steps if not step.holds] == [case.step]


FORMAT = {
    "unknown status": put("status", "certain"),
    "extra key": put("proof", "trust me"),
    "extra key in a step": put("steps.0.proof", "trust me"),
    "NaN": put("steps.0.segments.0.z", math.nan),
    "f_com missing": lambda d: d["steps"][0]["segments"][0].pop("f_com"),
    "unknown mode": put("steps.0.segments.0.modes.0", "velocity"),
    "unknown kind": put("steps.0.kind", "teleport"),
    "other format": put("format", "gm-ompl-plan/0"),
    "cell of three": put("steps.0.placements.0.cell", [1, 2, 3]),
    "cost as text": put("cost", "106"),
}


@pytest.mark.parametrize("name", FORMAT)
def test_what_is_no_plan_file_is_bad_input(draft: Draft, tmp_path: Path, name: str) -> None:
    """Tampering with the format itself is a PlanError that names the key."""
    FORMAT[name](draft)
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(draft), encoding="utf-8")
    with pytest.raises(PlanError, match=r"plan\.json:1: \w+"):
        check(file)


def test_a_broken_scenario_is_bad_input(draft: Draft) -> None:
    """A scenario that means nothing is an InputError, not a verdict."""
    draft["scenario"]["object"]["mass"] = -1
    with pytest.raises(InputError, match="mass"):
        check(Plan.model_validate_json(json.dumps(draft)))
