"""The paper's planner: A* on the manipulation-feasibility graph, and Dijkstra's algorithm."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import ClassVar, final

import numpy as np

from gm_ompl.errors import InputError, LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.holds.tables import claim_tables
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.lane_parts import PartTask, part_search
from gm_ompl.planners.outcome import PROVEN, Log, without_search
from gm_ompl.planners.parameters import Parameter
from gm_ompl.planners.planner import (
    Budget,
    Planner,
    PlannerSpecs,
    Report,
    SearchResult,
    Status,
    silent,
)
from gm_ompl.problem import Problem


def has_lanes(problem: Problem, judge: Judge) -> bool:
    """Whether the search over lanes applies: a path or free motion, and cuts from the back end."""
    return (
        problem.motion.dimension < 2
        and problem.motion.periods in ((), (None,))
        and problem.fingers.count > 0
        and isinstance(judge.backend, KernelBackend)
    )


def solve_on_lanes(problem: Problem, judge: Judge, budget: Budget, report: Report) -> SearchResult:
    """Search for a plan of least cost; see ``Planner.solve``.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    log = Log(budget.start(), judge, report)
    if isinstance(problem.motion, FreeMotion):
        from gm_ompl.planners.free_search import FreeSearch

        return FreeSearch(problem, judge, log, report).run()
    try:
        claim_tables(problem, problem.lattice.size, "a lattice")
        return part_search(PartTask(problem, judge, log, report)).run()
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, log.meter)
    except LimitError as stopped:
        return without_search(Status.BUDGET, 0.0, log.meter, str(stopped))


class LatticePlanner(Planner):
    """A best-first search by the heuristic that its settings name; without one by none."""

    specs: ClassVar[PlannerSpecs] = PlannerSpecs(optimal=True, randomised=False, free=True)

    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,  # noqa: ARG002
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan of least cost on the problem's lattice; see ``Planner.solve``."""
        heuristic = self.settings.get("heuristic", "none")
        if problem.fingers.anywhere is not None:
            if heuristic != "lanes" or not has_lanes(problem, judge):
                raise InputError(
                    "fingers.placements.continuous needs astar's heuristic lanes, its default"
                )
            from gm_ompl.planners.anywhere import solve_anywhere

            return solve_anywhere(problem, judge, budget.start(), report)
        if heuristic == "lanes" and has_lanes(problem, judge):
            return bounded(judge, lambda: solve_on_lanes(problem, judge, budget, report))
        from gm_ompl.planners.lattice_search import solve_on_lattice

        return bounded(
            judge, lambda: solve_on_lattice(problem, judge, budget, report, str(heuristic))
        )


@final
class AStar(LatticePlanner):
    """A* (Sec. 4.4): over lanes and hubs where that applies, else with the heuristic (11)."""

    name: ClassVar[str] = "astar"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(
        optimal=True, randomised=False, free=True, anywhere_on_paths=True
    )
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter(
            "heuristic",
            str,
            "lanes",
            "What bounds the cost to the goal: lanes (one degree of freedom; in the plane the "
            "object's own way; elsewhere as travel), travel (the heuristic (11) on the paper's "
            "graph) or none.",
            choices=("lanes", "travel", "none"),
        ),
    )


@final
class Dijkstra(LatticePlanner):
    """A* without heuristic."""

    name: ClassVar[str] = "dijkstra"


def bounded(judge: Judge, search: Callable[[], SearchResult]) -> SearchResult:
    """Return what ``search`` finds, claiming no more than the decisions it asked for allow."""
    deciders, result = (judge.backend, judge.reach), search()
    if not any(decider.undecided for decider in deciders):
        return result
    if not result.optimal and result.status is not Status.INFEASIBLE:
        return dataclasses.replace(result, lower_bound=0.0)
    for decider in deciders:
        decider.forget()
        decider.optimistic = True
    try:
        bound = search().lower_bound
    finally:
        for decider in deciders:
            decider.optimistic = False
            decider.forget()
    if result.status is Status.INFEASIBLE and bound < math.inf:
        return dataclasses.replace(result, status=Status.BUDGET, lower_bound=bound)
    optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
    return dataclasses.replace(result, lower_bound=bound, optimal=optimal)
