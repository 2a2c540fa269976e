"""The paper's planner: A* on the manipulation-feasibility graph, and Dijkstra's algorithm."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import ClassVar, TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.errors import InputError, LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.feasibility_graph import FeasibilityGraph
from gm_ompl.graph.heuristic import Heuristic, NoHeuristic, TravelHeuristic
from gm_ompl.graph.planar_heuristic import PlanarHeuristic, suits
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.goals import valid_goals
from gm_ompl.holds.sets import LIFTED
from gm_ompl.holds.tables import claim_tables
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.astar import BestFirstSearch, Told
from gm_ompl.planners.lane_parts import Part, part_search
from gm_ompl.planners.outcome import PROVEN, Log, result_of, without_search
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
from gm_ompl.planners.trace import Expansion, Trace, tracer
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
        return part_search(Part(problem, judge, log, report)).run()
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, log.meter)
    except LimitError as stopped:
        return without_search(Status.BUDGET, 0.0, log.meter, str(stopped))


MakeHeuristic: TypeAlias = Callable[[Judge, tuple[int, ...], Stop], Heuristic]
"""From judge, the goal's valid nodes (at least one) and what may break it off."""


def solve_on_lattice(
    problem: Problem, judge: Judge, budget: Budget, report: Report, heuristic: MakeHeuristic
) -> SearchResult:
    """Search the manipulation-feasibility graph of ``problem`` for a plan of least cost.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    log = Log(budget.start(), judge, report)
    objects = problem.object_graph
    try:
        valid = valid_goals(judge, log.meter.spent)
        if valid == ():
            # No set of placements fits the goal: nothing to search.
            return without_search(Status.INFEASIBLE, math.inf, log.meter)
        bound = heuristic(judge, valid, log.meter.spent) if valid else NoHeuristic(problem)
        graph = FeasibilityGraph(judge, bound)
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, log.meter)
    except LimitError as stopped:
        return without_search(Status.BUDGET, 0.0, log.meter, str(stopped))

    told = _told(problem, graph, tracer(report))
    search = BestFirstSearch(graph, log, told)
    status = search.run()
    with limits.lifted():
        nodes, legs = graph.legs(search.path())
        moves = moves_of(judge, objects.way(nodes), legs) if legs else ()
    statistics = log.statistics(search.expanded, search.generated, placement_sets=len(graph.sets))
    return result_of(status, search.cost, search.bound, moves, statistics)


def _told(problem: Problem, graph: FeasibilityGraph, trace: Trace | None) -> Told | None:
    """Return what turns the search's node numbers into expansions for ``trace``."""
    if trace is None:
        return None

    def tell(node: int, cost: float, bound: float, again: bool) -> None:
        config, placements = graph.parts(node)
        q = problem.object_graph.coordinates(config)
        why = "hub" if LIFTED in placements else "set of placements"
        trace(Expansion(q, placements, cost, bound, f"{why}, again" if again else why))

    return tell


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
        make: MakeHeuristic = lambda judge, goals, _: TravelHeuristic(judge, goals)  # noqa: E731
        if heuristic == "none":
            make = lambda judge, *_: NoHeuristic(judge.problem)  # noqa: E731
        elif heuristic == "lanes" and suits(problem):
            make = PlanarHeuristic
        return bounded(judge, lambda: solve_on_lattice(problem, judge, budget, report, make))


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
