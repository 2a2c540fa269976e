"""The check of plans with free motion that claim no optimality: any screw the scenario allows."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.checking.check import check, check_against
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import CheckReport
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.check.tampering import Draft, put

OFF = "motion.goal.position=[-0.6, 0, 0.5]"
"""A place between those of the lattice."""


@cache
def planned() -> Plan:
    """A plan to a place that the lattice lacks."""
    plan = gm_ompl.plan(load("tasks/reorient", [OFF]), "HybridRRTConnect", max_iterations=50)
    assert plan.steps
    return plan


@cache
def recheck() -> Recheck:
    """What is known of the scene: its answers are kept from plan to plan."""
    return Recheck(Scenario.from_resolved(planned().scenario).problem)


def judged(draft: Draft) -> CheckReport:
    """Judge a tampered plan."""
    return check_against(Plan.model_validate_json(json.dumps(draft)), recheck())


def test_it_holds_off_the_lattice() -> None:
    """Slides of any length and turns from any place hold."""
    report = check(planned())
    assert report.holds, report.table()


def test_optimality_is_claimed_of_lattice_arcs_alone() -> None:
    """The same plan, said to be optimal on the lattice, is refused: its arcs are none of these."""
    draft = copy.deepcopy(planned().to_dict())
    draft.update(optimal=True, lower_bound=draft["cost"])
    assert "arc" in {violation.topic for violation in judged(draft).violations}


def _slide(draft: Draft) -> int:
    """The number of the first step that slides."""
    return next(k for k, s in enumerate(draft["steps"]) if "translation" in s.get("arc", {}))


def _turn(draft: Draft) -> int:
    return next(k for k, s in enumerate(draft["steps"]) if "rotation" in s.get("arc", {}))


def _lifted(draft: Draft) -> int:
    """Slide along z, which is not listed."""
    k = _slide(draft)
    draft["steps"][k]["arc"]["translation"] = [0.0, 0.0, 0.1]
    return k


def _tilted(draft: Draft) -> int:
    """Turn about another direction."""
    k = _turn(draft)
    axis = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    draft["steps"][k]["arc"]["rotation"]["axis"] = axis.tolist()
    return k


def _nowhere(draft: Draft) -> int:
    k = _slide(draft)
    draft["steps"][k]["arc"]["translation"] = [0.0, 0.0, 0.0]
    return k


def _coarser(draft: Draft) -> int:
    """Judge a stride in fewer segments."""
    k = _turn(draft)
    draft["steps"][k]["segments"] = draft["steps"][k]["segments"][:1]
    return k


def _finer(draft: Draft) -> int:
    k = _turn(draft)
    draft["steps"][k]["segments"] = draft["steps"][k]["segments"] * 2
    return k


def _longer(draft: Draft) -> int:
    """End elsewhere than where the next step begins."""
    k = _slide(draft)
    by = draft["steps"][k]["arc"]["translation"]
    draft["steps"][k]["arc"]["translation"] = [1.01 * value for value in by]
    return k


def _out(draft: Draft) -> int:
    k = _slide(draft)
    draft["steps"][k]["arc"]["translation"] = [-4.0, 0.0, 0.0]
    return k


@pytest.mark.parametrize(("tamper", "topic"), [
    (_lifted, "arc"), (_tilted, "arc"), (_nowhere, "arc"), (_coarser, "segments"),
    (_finer, "segments"), (_longer, "pose"), (_out, "region"),
])  # fmt: skip
def test_what_is_tampered_with_is_refused(tamper: Callable[[Draft], int], topic: str) -> None:
    """The step and what is wrong with it are named."""
    draft: dict[str, Any] = copy.deepcopy(planned().to_dict())
    step = tamper(draft)
    found = {(violation.step, violation.topic) for violation in judged(draft).violations}
    assert (step, topic) in found, found


def test_the_goal_is_judged() -> None:
    """Without its last arcs the plan does not arrive."""
    draft = copy.deepcopy(planned().to_dict())
    del draft["steps"][-1]
    put("cost", sum(step["cost"] for step in draft["steps"]))(draft)
    assert {violation.topic for violation in judged(draft).violations} == {"goal"}
