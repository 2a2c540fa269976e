"""Judges a saved plan anew, from its scenario alone."""

from __future__ import annotations

import os
from collections.abc import Sequence

from gm_ompl.checking.by_coordinates import ByCoordinates
from gm_ompl.checking.free_arcs import FreeArcs
from gm_ompl.checking.joints import JointCheck
from gm_ompl.checking.junctions import Junctions
from gm_ompl.checking.kinematics import AnyStep, Kinematics
from gm_ompl.checking.recheck import Recheck, Tolerances
from gm_ompl.checking.report import CheckReport, Findings, StepReport
from gm_ompl.checking.steps import check_displacement, check_regrasp
from gm_ompl.checking.ways import check_landing, check_leaving
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planfile.model import DisplacementStep, PlacementRecord, Plan, RegraspStep, Spot
from gm_ompl.planfile.points import with_points
from gm_ompl.problem import Placements
from gm_ompl.scenario.scenario import Scenario

Spots = tuple[Spot, ...]


def placements_after(step: AnyStep) -> tuple[PlacementRecord, ...]:
    """Return the placements, per physical finger, after ``step``."""
    if isinstance(step, DisplacementStep) or step.finger >= len(step.placements):
        return step.placements
    return (*step.placements[: step.finger], step.to, *step.placements[step.finger + 1 :])


def _spots(placements: Sequence[PlacementRecord]) -> Spots:
    return tuple(record.spot for record in placements)


def check_continuity(
    recheck: Recheck, last: AnyStep | None, step: AnyStep, found: Findings
) -> None:
    """Judge whether the hand is at ``step`` where ``last`` left it (or as given, where None)."""
    if last is None:
        _check_given(recheck, "start", recheck.problem.fingers.start, step.placements, found)
        _check_coming(recheck, step, found)
        return
    have, want = step.placements, placements_after(last)
    found.check(
        "continuity",
        _spots(have) == _spots(want),
        f"placements are {_show(have)}; after the last step they are {_show(want)}",
    )


def _rows(recheck: Recheck, records: Sequence[PlacementRecord]) -> Placements | None:
    """Return the rows of a whole hand's placements; None where one is in no table."""
    table = recheck.problem.fingers.placements
    rows = [record.row(table) for record in records]
    known = tuple(row for row in rows if row is not None)
    return known if len(known) == recheck.problem.fingers.count == len(rows) else None


def _check_coming(recheck: Recheck, step: AnyStep, found: Findings) -> None:
    """Judge whether the fingers can come to where the first step has them."""
    problem, rows = recheck.problem, _rows(recheck, step.placements)
    if problem.fingers.transit and rows is not None:
        check_landing(recheck, problem.motion.pose(problem.start), rows, found)


def _check_end(recheck: Recheck, step: AnyStep, pose: Pose | None, found: Findings) -> None:
    """Judge where the fingers are after the last step, and whether they can leave."""
    hand, after = recheck.problem.fingers, placements_after(step)
    _check_given(recheck, "goal", hand.goal, after, found)
    rows = _rows(recheck, after)
    if hand.transit and hand.leave and pose is not None and rows is not None:
        check_leaving(recheck, pose, rows, found)


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
                record.row(table) == row,
                f"finger {finger} is at {record.words}; the scenario puts it "
                f"at {table.labels[int(table.face[row])]}:{table.cell[row].tolist()}",
            )


def check_totals(recheck: Recheck, kinematics: Kinematics, plan: Plan, found: Findings) -> None:
    """Judge status, cost, number of regraspings, bound and the claim of optimality."""
    if not plan.has_plan:
        _check_no_plan(plan, found)
        return
    if not plan.steps:
        kinematics.at_once(found)
        _check_unmoved(recheck, found)
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


def _check_unmoved(recheck: Recheck, found: Findings) -> None:
    """Judge "solved" without a step: the fingers must start where they must end."""
    problem = recheck.problem
    for finger, (start, goal) in enumerate(
        zip(problem.fingers.start, problem.fingers.goal, strict=True)
    ):
        found.check(
            "goal",
            start is None or goal is None or start == goal,
            f"there are no steps, and finger {finger} does not start where it must end",
        )


def _show(placements: Sequence[PlacementRecord]) -> str:
    return "[" + ", ".join(record.words for record in placements) + "]"


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

    The planner's name, its parameters, the seed and the statistics are not judged; where these
    state failing junctions, so many are noted instead of held against the plan.

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
    problem = with_points(
        Scenario.from_resolved(plan.scenario, "scenario in the plan").problem, plan
    )
    return check_against(plan, Recheck(problem, tolerances))


def check_against(plan: Plan, recheck: Recheck) -> CheckReport:
    """Judge a plan by a problem, which ``check`` makes from the scenario inside the plan."""
    kinematics, whole = _kinematics(recheck, plan), Findings(None)
    check_totals(recheck, kinematics, plan, whole)
    reports: list[StepReport] = []
    junctions = Junctions(recheck, _stated(plan))
    joints = _joints(recheck, plan, whole)
    violations = list(whole.violations)
    last: AnyStep | None = None
    for number, step in enumerate(plan.steps):
        found = Findings(number)
        kinematics.continuity(last, step, found)
        check_continuity(recheck, last, step, found)
        place = kinematics.place(step)
        if isinstance(step, DisplacementStep):
            arc = kinematics.displacement(step, found)
            pose = None if arc is None else arc.end
            check_displacement(recheck, step, arc, found)
            junctions.displacement(step, arc, found)
            if joints is not None:
                joints.displacement(number, step, arc, found)
        else:
            pose = kinematics.rest(step, found)
            check_regrasp(recheck, step, pose, found)
            junctions.regrasp(step, pose, found)
            if joints is not None:
                joints.regrasp(number, step, pose, placements_after(step), found)
        if number == len(plan.steps) - 1:
            kinematics.goal(step, found)
            _check_end(recheck, step, pose, found)
            if joints is not None and pose is not None:
                joints.retreat(pose, placements_after(step), found)
        reports.append(found.report(step.kind, place))
        violations += found.violations
        last = step
    notes = [_NO_STEPS] if not plan.has_plan else [_NOT_PROVEN] if plan.optimal else []
    notes += junctions.notes()
    return CheckReport(plan.status, tuple(reports), tuple(violations), tuple(notes))


def _joints(recheck: Recheck, plan: Plan, found: Findings) -> JointCheck | None:
    """Return what judges the joint paths; None where there is no hand, or none can be judged."""
    problem, record = recheck.problem, plan.hand
    if problem.hand is None or not plan.steps:
        found.check("joints", record is None, "joint paths are given; there is nothing they are of")
        return None
    if not found.check("joints", record is not None, "the scenario has a hand, the plan no paths"):
        return None
    assert record is not None
    joints = JointCheck(problem, record)
    if not joints.whole(len(plan.steps), found):
        return None
    joints.approach(problem.motion.pose(problem.start), plan.steps[0].placements, found)
    return joints


def _kinematics(recheck: Recheck, plan: Plan) -> Kinematics:
    motion = recheck.problem.motion
    if isinstance(motion, FreeMotion):
        return FreeArcs(recheck, motion, plan.optimal)
    return ByCoordinates(recheck)


def _stated(plan: Plan) -> int | None:
    """Return how many failing junctions the plan states; None where it says it does not know."""
    stated = (plan.statistics.model_extra or {}).get("failing_junctions", 0)
    return stated if stated is None or isinstance(stated, int) else 0
