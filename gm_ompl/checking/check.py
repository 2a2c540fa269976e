"""Judges a saved plan anew, from its scenario alone."""

from __future__ import annotations

import os

from gm_ompl.checking.displacement import check_displacement
from gm_ompl.checking.recheck import Recheck, Tolerances
from gm_ompl.checking.regrasp import check_regrasp
from gm_ompl.checking.report import CheckReport, Findings, StepReport
from gm_ompl.checking.whole import AnyStep, check_continuity, check_goal, check_totals, head, tail
from gm_ompl.planfile.model import DisplacementStep, Plan
from gm_ompl.scenario.scenario import Scenario

_NOT_PROVEN = (
    "that the plan is optimal on the lattice is the planner's claim: only its consistency with "
    "cost and lower_bound is judged"
)
_NO_STEPS = (
    "there is no plan to judge; that none exists on the lattice, or that none was found, is not "
    "proven here"
)


def check(plan: Plan | str | os.PathLike[str], tolerances: Tolerances | None = None) -> CheckReport:
    """Judge a plan by geometry, contact and the reference's programs alone.

    The planner's name, its parameters, the seed and the statistics are not judged.

    Args:
        plan: a plan, or the path of a plan file.
        tolerances: how far a claim may be from what holds.

    Returns:
        Per step what holds, and every violation.

    Raises:
        PlanError: the file cannot be read or is no plan.
        ScenarioError: the scenario stored in the plan cannot be used.
        SolverError: an LP solver returned no answer.
    """
    if not isinstance(plan, Plan):
        plan = Plan.load(plan)
    scenario = Scenario.from_resolved(plan.scenario, "scenario in the plan")
    recheck = Recheck(scenario.problem, tolerances)
    whole = Findings(None)
    check_totals(recheck, plan, whole)
    reports: list[StepReport] = []
    violations = list(whole.violations)
    last: AnyStep | None = None
    for number, step in enumerate(plan.steps):
        found = Findings(number)
        check_continuity(recheck, last, step, found)
        _check_step(recheck, step, found)
        if number == len(plan.steps) - 1:
            check_goal(recheck, step, found)
        reports.append(found.report(step.kind, _where(step)))
        violations += found.violations
        last = step
    notes = [_NO_STEPS] if not plan.has_plan else [_NOT_PROVEN] if plan.optimal else []
    return CheckReport(plan.status, tuple(reports), tuple(violations), tuple(notes))


def _check_step(recheck: Recheck, step: AnyStep, found: Findings) -> None:
    if isinstance(step, DisplacementStep):
        check_displacement(recheck, step, found)
    else:
        check_regrasp(recheck, step, found)


def _where(step: AnyStep) -> str:
    start, end = (", ".join(f"{value:.6g}" for value in q) for q in (tail(step), head(step)))
    if isinstance(step, DisplacementStep):
        return f"[{start}] to [{end}]"
    return f"[{start}], finger {step.finger} to {step.to.face}:{list(step.to.cell)}"
