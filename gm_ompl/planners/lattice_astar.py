"""The paper's planner: A* on the manipulation-feasibility graph, and Dijkstra's algorithm."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar, TypeAlias, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.extraction import extract_moves
from gm_ompl.graph.feasibility_graph import FeasibilityGraph
from gm_ompl.graph.goals import GoalNodes, start_node
from gm_ompl.graph.heuristic import Heuristic, NoHeuristic, TravelHeuristic
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.graph.planar_heuristic import PlanarHeuristic, suits
from gm_ompl.graph.sets import LIFTED
from gm_ompl.graph.watch import Stop, Stopped
from gm_ompl.moves import Move
from gm_ompl.planners.astar import BestFirstSearch, Told
from gm_ompl.planners.lane_search import LaneSearch
from gm_ompl.planners.lane_sources import start_sets
from gm_ompl.planners.outcome import Log, result_of, without_search
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
from gm_ompl.planners.undecided import bounded
from gm_ompl.problem import Placements, Problem


def has_lanes(problem: Problem, judge: Judge) -> bool:
    """Whether the search over lanes applies: one coordinate, and a back end that leaves cuts."""
    return (
        problem.motion.dimension == 1
        and problem.lattice.periods[0] is None
        and problem.fingers.count > 0
        and isinstance(judge.backend, KernelBackend)
    )


def solve_on_lanes(problem: Problem, judge: Judge, budget: Budget, report: Report) -> SearchResult:
    """Search for a plan of least cost; see ``Planner.solve``.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    log = Log(budget.start(), judge, report)
    start, backend = start_node(problem), judge.backend
    assert isinstance(backend, KernelBackend), "has_lanes was not asked"
    try:
        graph = LaneGraph(problem, judge, backend, log.meter.spent)
        source = start_sets(problem, judge, graph, start)
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, log.meter)
    except Stopped:
        return without_search(Status.BUDGET, 0.0, log.meter)

    search = LaneSearch(graph, source, start, log, tracer(report))
    status = search.run()
    moves = _moves(problem, judge, search.path())
    statistics = log.statistics(search.expanded, search.generated, placement_sets=graph.lanes_met)
    return result_of(status, search.cost, search.bound, moves, statistics)


def _moves(
    problem: Problem, judge: Judge, legs: list[tuple[Placements, int, int]]
) -> tuple[Move, ...]:
    """Return the moves of a plan given as legs: (placements, first node, last node)."""
    if not legs:
        return ()
    graph = FeasibilityGraph(problem, judge, GoalNodes(problem), NoHeuristic(problem))
    nodes: list[int] = []
    for k, (placements, first, last) in enumerate(legs):
        if k:
            nodes.append(graph.node(first, _hub(graph, legs[k - 1][0], placements)))
        step = 1 if last >= first else -1
        nodes.extend(graph.node(c, placements) for c in range(first, last + step, step))
    return extract_moves(problem, graph, nodes)


def _hub(graph: FeasibilityGraph, before: Placements, after: Placements) -> Placements:
    """Return the hub that two sets share."""
    sets = graph.sets
    lifted = {sets.replaced(before, k, LIFTED) for k in range(len(before))}
    return next(
        hub for hub in (sets.replaced(after, k, LIFTED) for k in range(len(after))) if hub in lifted
    )


MakeHeuristic: TypeAlias = Callable[[Problem, Judge, tuple[int, ...], Stop], Heuristic]
"""From problem, judge, the goal's valid lattice nodes (at least one) and what may break it off."""


def solve_on_lattice(
    problem: Problem, judge: Judge, budget: Budget, report: Report, heuristic: MakeHeuristic
) -> SearchResult:
    """Search the manipulation-feasibility graph of ``problem`` for a plan of least cost.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    log = Log(budget.start(), judge, report)
    start_node(problem)
    goals = GoalNodes(problem)
    try:
        valid = goals.reachable(problem, judge, log.meter.spent)
        if not valid:
            # No set of placements fits the goal: nothing to search.
            return without_search(Status.INFEASIBLE, math.inf, log.meter)
        graph = FeasibilityGraph(
            problem, judge, goals, heuristic(problem, judge, valid, log.meter.spent)
        )
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, log.meter)
    except Stopped:
        return without_search(Status.BUDGET, 0.0, log.meter)

    told = _told(problem, graph, tracer(report))
    found = BestFirstSearch(graph, log, told).run()
    moves = extract_moves(problem, graph, found.path) if found.path else ()
    statistics = log.statistics(found.expanded, found.generated, placement_sets=len(graph.sets))
    return result_of(found.status, found.cost, found.lower_bound, moves, statistics)


def _told(problem: Problem, graph: FeasibilityGraph, trace: Trace | None) -> Told | None:
    """Return what turns the search's node numbers into expansions for ``trace``."""
    if trace is None:
        return None

    def tell(node: int, cost: float, bound: float, again: bool) -> None:
        config, placements = graph.parts(node)
        q = problem.lattice.coordinates(config)
        why = "hub" if LIFTED in placements else "set of placements"
        trace(Expansion(q, placements, cost, bound, f"{why}, again" if again else why))

    return tell


class LatticePlanner(Planner):
    """A best-first search by the heuristic that its settings name; without one by none."""

    specs: ClassVar[PlannerSpecs] = PlannerSpecs(directed=True, optimal=True, randomised=False)

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
        if heuristic == "lanes" and has_lanes(problem, judge):
            return bounded(judge, lambda: solve_on_lanes(problem, judge, budget, report))
        make: MakeHeuristic = _no_heuristic if heuristic == "none" else _travel
        if heuristic == "lanes" and suits(problem):
            make = PlanarHeuristic
        return bounded(judge, lambda: solve_on_lattice(problem, judge, budget, report, make))


@final
class AStar(LatticePlanner):
    """A* (Sec. 4.4): over lanes and hubs where that applies, else with the heuristic (11)."""

    name: ClassVar[str] = "astar"
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


def _no_heuristic(
    problem: Problem,
    judge: Judge,  # noqa: ARG001
    goals: tuple[int, ...],  # noqa: ARG001
    stop: Stop,  # noqa: ARG001
) -> Heuristic:
    return NoHeuristic(problem)


def _travel(
    problem: Problem,
    judge: Judge,
    goals: tuple[int, ...],
    stop: Stop,  # noqa: ARG001
) -> Heuristic:
    return TravelHeuristic(problem, judge, goals)
