"""Judges a saved plan anew, from its scenario alone."""

from __future__ import annotations

import os
from collections.abc import Sequence

from gm_ompl.checking.coordinates import gap, in_goal
from gm_ompl.checking.recheck import Recheck, Tolerances
from gm_ompl.checking.report import CheckReport, Findings, StepReport
from gm_ompl.checking.steps import check_displacement, check_regrasp
from gm_ompl.checking.ways import check_landing, check_leaving
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planfile.model import DisplacementStep, PlacementRecord, Plan, RegraspStep
from gm_ompl.problem import Placements
from gm_ompl.scenario.scenario import Scenario

AnyStep = DisplacementStep | RegraspStep
Spots = tuple[tuple[str, tuple[int, int]], ...]


def tail(step: AnyStep) -> Coordinates:
    """Return the coordinates where ``step`` starts."""
    return step.from_ if isinstance(step, DisplacementStep) else step.at


def head(step: AnyStep) -> Coordinates:
    """Return the coordinates where ``step`` ends."""
    return step.to if isinstance(step, DisplacementStep) else step.at


def placements_after(step: AnyStep) -> tuple[PlacementRecord, ...]:
    """Return the placements, per physical finger, after ``step``."""
    if isinstance(step, DisplacementStep) or step.finger >= len(step.placements):
        return step.placements
    return (*step.placements[: step.finger], step.to, *step.placements[step.finger + 1 :])


def _spots(placements: Sequence[PlacementRecord]) -> Spots:
    return tuple((record.face, record.cell) for record in placements)


def check_continuity(
    recheck: Recheck, last: AnyStep | None, step: AnyStep, found: Findings
) -> None:
    """Judge whether ``step`` starts where ``last`` ended (or at the start, where None)."""
    if last is None:
        _check_start(recheck, step, found)
        return
    off = gap(recheck.problem, tail(step), head(last))
    found.check(
        "continuity",
        off <= recheck.tolerances.coordinate,
        f"starts at {list(tail(step))}; the last step ended at {list(head(last))}",
    )
    have, want = _spots(step.placements), _spots(placements_after(last))
    found.check(
        "continuity",
        have == want,
        f"placements are {_show(have)}; after the last step they are {_show(want)}",
    )
    if isinstance(step, DisplacementStep) and isinstance(last, DisplacementStep):
        here, there = step.pose_from.position, last.pose_to.position
        off = max(abs(u - v) for u, v in zip(here, there, strict=True))
        allowed = 2 * recheck.tolerances.length * max(recheck.diagonal, *map(abs, there))
        found.check(
            "continuity",
            off <= allowed,
            f"pose_from is {off:.3g} away from the last step's pose_to (allowed {allowed:.3g})",
        )


def _check_start(recheck: Recheck, step: AnyStep, found: Findings) -> None:
    problem = recheck.problem
    off = gap(problem, tail(step), problem.start)
    found.check(
        "start",
        off <= recheck.tolerances.coordinate,
        f"the first step starts at {list(tail(step))}; the scenario's start is "
        f"{list(problem.start)}",
    )
    _check_given(recheck, "start", problem.fingers.start, step.placements, found)
    rows = _rows(recheck, step.placements)
    if problem.fingers.transit and rows is not None:
        check_landing(recheck, problem.motion.pose(problem.start), rows, found)


def _rows(recheck: Recheck, records: Sequence[PlacementRecord]) -> Placements | None:
    """Return the rows of a whole hand's placements; None where one is in no table."""
    table = recheck.problem.fingers.placements
    rows = [table.find(record.face, record.cell) for record in records]
    known = tuple(row for row in rows if row is not None)
    return known if len(known) == recheck.problem.fingers.count == len(rows) else None


def check_goal(recheck: Recheck, step: AnyStep, found: Findings) -> None:
    """Judge whether the last step ends in the goal."""
    problem, end = recheck.problem, head(step)
    inside = len(end) == problem.motion.dimension and in_goal(
        problem, end, recheck.tolerances.coordinate
    )
    low, high = list(problem.goal.low), list(problem.goal.high)
    found.check("goal", inside, f"the last step ends at {list(end)}; the goal is {low} to {high}")
    _check_given(recheck, "goal", problem.fingers.goal, placements_after(step), found)
    rows = _rows(recheck, placements_after(step))
    if problem.fingers.transit and problem.fingers.leave and inside and rows is not None:
        check_leaving(recheck, problem.motion.pose(end), rows, found)


def _check_given(
    recheck: Recheck,
    topic: str,
    given: Sequence[int | None],
    placements: Sequence[PlacementRecord],
    found: Findings,
) -> None:
    table = recheck.problem.fingers.placements
    for finger, (row, record) in enumerate(zip(given, placements, strict=False)):
        if row is not None:
            found.check(
                topic,
                table.find(record.face, record.cell) == row,
                f"finger {finger} is at {record.face}:{list(record.cell)}; the scenario puts it "
                f"at {table.labels[int(table.face[row])]}:{table.cell[row].tolist()}",
            )


def check_totals(recheck: Recheck, plan: Plan, found: Findings) -> None:
    """Judge status, cost, number of regraspings, bound and the claim of optimality."""
    if not plan.has_plan:
        _check_no_plan(plan, found)
        return
    if not plan.steps:
        _check_empty(recheck, found)
    cost = sum(step.cost for step in plan.steps)
    regrasps = sum(isinstance(step, RegraspStep) for step in plan.steps)
    found.check(
        "cost",
        plan.cost is not None and abs(plan.cost - cost) <= recheck.tolerances.cost * abs(cost),
        f"cost {plan.cost} is claimed; the steps' costs add up to {cost:.12g}",
    )
    found.check(
        "regrasps",
        plan.regrasps == regrasps,
        f"{plan.regrasps} regrasps are claimed; the plan has {regrasps}",
    )
    _check_bound(recheck, plan, found)


def _check_bound(recheck: Recheck, plan: Plan, found: Findings) -> None:
    slack = 1.0 + recheck.tolerances.optimal
    if plan.cost is None:
        return
    if plan.lower_bound is not None:
        found.check(
            "lower_bound",
            plan.lower_bound <= plan.cost * slack,
            f"lower_bound {plan.lower_bound:.12g} is above the plan's cost {plan.cost:.12g}",
        )
    if plan.optimal:
        found.check(
            "optimal",
            plan.lower_bound is not None and plan.cost <= plan.lower_bound * slack,
            f"optimal is claimed; lower_bound {plan.lower_bound} does not prove it for cost "
            f"{plan.cost:.12g}",
        )


def _check_no_plan(plan: Plan, found: Findings) -> None:
    for what, value in (("cost", plan.cost), ("regrasps", plan.regrasps)):
        found.check(
            "status", value is None, f"status is {plan.status!r}; {what} {value} must be null"
        )
    found.check(
        "status",
        not plan.steps,
        f"status is {plan.status!r}, yet there are {len(plan.steps)} steps",
    )
    found.check("status", not plan.optimal, f"status is {plan.status!r}; optimal must be false")


def _check_empty(recheck: Recheck, found: Findings) -> None:
    """Judge "solved" without a step: the start must be in the goal already."""
    problem = recheck.problem
    found.check(
        "goal",
        in_goal(problem, problem.start, recheck.tolerances.coordinate),
        f"there are no steps, and the start {list(problem.start)} is not in the goal "
        f"{list(problem.goal.low)} to {list(problem.goal.high)}",
    )
    for finger, (start, goal) in enumerate(
        zip(problem.fingers.start, problem.fingers.goal, strict=True)
    ):
        found.check(
            "goal",
            start is None or goal is None or start == goal,
            f"there are no steps, and finger {finger} does not start where it must end",
        )


def _show(spots: Spots) -> str:
    return "[" + ", ".join(f"{face}:{i},{j}" for face, (i, j) in spots) + "]"


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
        if isinstance(step, DisplacementStep):
            check_displacement(recheck, step, found)
        else:
            check_regrasp(recheck, step, found)
        if number == len(plan.steps) - 1:
            check_goal(recheck, step, found)
        reports.append(found.report(step.kind, _where(step)))
        violations += found.violations
        last = step
    notes = [_NO_STEPS] if not plan.has_plan else [_NOT_PROVEN] if plan.optimal else []
    return CheckReport(plan.status, tuple(reports), tuple(violations), tuple(notes))


def _where(step: AnyStep) -> str:
    start, end = (", ".join(f"{value:.6g}" for value in q) for q in (tail(step), head(step)))
    if isinstance(step, DisplacementStep):
        return f"[{start}] to [{end}]"
    return f"[{start}], finger {step.finger} to {step.to.face}:{list(step.to.cell)}"
