"""One run, in the process that calls: what a planner found, as plain values."""

from __future__ import annotations

from typing import Any

import gm_ompl
from gm_ompl import limits
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Progress
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.task import Task


def carry_out(task: Task) -> dict[str, Any]:
    """Plan as ``task`` says and return what a record keeps of the plan.

    Raises:
        InputError: the planner cannot treat the scenario.
    """
    with limits.holding(task.limits.time_s, task.limits.memory_mb):
        return _carried_out(task)


def _carried_out(task: Task) -> dict[str, Any]:
    asked = task.limits
    scenario = Scenario.from_resolved(task.scenario)
    first: list[Progress] = []

    def watch(progress: Progress) -> None:
        if progress.cost is not None and not first:
            first.append(progress)

    plan = gm_ompl.plan(
        scenario,
        task.planner,
        time_limit=asked.time_s,
        max_iterations=asked.max_iterations,
        memory_limit=asked.memory_mb,
        seed=task.seed,
        parameters=task.parameters,
        report=watch,
    )
    found = facts(plan)
    decided = first[0].mode_decisions if first else found["mode_decisions"]
    return {
        **found,
        "first_plan_decisions": None if plan.cost is None else decided,
        "states": states(scenario.problem),
    }


def states(problem: Problem) -> float:
    """Return how many states the lattice has: nodes times one placement for each finger."""
    fingers = problem.fingers
    return float(problem.lattice.size) * float(len(fingers.placements)) ** fingers.count


def facts(plan: Plan) -> dict[str, Any]:
    """Return what a record keeps of a plan."""
    spent = plan.statistics
    costs = [(time, cost) for time, cost, _ in spent.history if cost is not None]
    first = costs[0][0] if costs else spent.time_s
    return {
        "status": plan.status,
        "cost": plan.cost,
        "optimal": plan.optimal,
        "lower_bound": plan.lower_bound,
        "first_plan_s": None if plan.cost is None else first,
        "search_s": spent.time_s,
        "regrasps": plan.regrasps,
        "least_z": plan.least_z,
        "mode_decisions": spent.mode_decisions,
        "iterations": spent.expanded,
        "history": [list(entry) for entry in spent.history],
    }
