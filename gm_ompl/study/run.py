"""One run, in the process that calls: what a planner found, as plain values."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import Any

from gm_ompl import api
from gm_ompl.errors import InputError
from gm_ompl.plan.model import DisplacementStep, Plan
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.task import Task

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
WARMING = ("paper/slide", "paper/regrasp")
"""Scenarios that, made small, load the compiled code a run may need."""


def carry_out(task: Task) -> dict[str, Any]:
    """Plan as ``task`` says and return what a record keeps of the plan.

    Raises:
        InputError: the planner cannot treat the scenario.
    """
    limits = task.limits
    plan = api.plan(
        Scenario.from_resolved(task.scenario),
        task.planner,
        time_limit=limits.time_s,
        max_iterations=limits.max_iterations,
        memory_limit=limits.memory_mb,
        seed=task.seed,
        parameters=task.parameters,
    )
    return facts(plan)


def facts(plan: Plan) -> dict[str, Any]:
    """Return what a record keeps of a plan."""
    spent = plan.statistics
    costs = [(time, cost) for time, cost, _ in spent.history if cost is not None]
    first = costs[0][0] if costs else spent.time_s
    margins = [step.z for step in plan.steps if not isinstance(step, DisplacementStep)]
    margins += [
        segment.z
        for step in plan.steps
        if isinstance(step, DisplacementStep)
        for segment in step.segments
    ]
    return {
        "status": plan.status,
        "cost": plan.cost,
        "optimal": plan.optimal,
        "lower_bound": plan.lower_bound,
        "first_plan_s": None if plan.cost is None else first,
        "search_s": spent.time_s,
        "regrasps": plan.regrasps,
        "least_z": min(margins, default=None),
        "mode_decisions": spent.mode_decisions,
        "iterations": spent.expanded,
        "history": [list(entry) for entry in spent.history],
    }


def warm_up(planners: Iterable[str]) -> None:
    """Load, or compile, what these planners use, so that no run pays for it."""
    for name in WARMING:
        scenario = api.load(name, SMALL)
        for planner in planners:
            with contextlib.suppress(InputError):  # its runs will say so
                api.plan(scenario, planner, max_iterations=20, time_limit=2.0)
