"""A* for one degree of freedom: the search over lanes and hubs as a planner uses it."""

from __future__ import annotations

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.extraction import extract_moves
from gm_ompl.graph.feasibility_graph import FeasibilityGraph
from gm_ompl.graph.goals import GoalNodes, start_node
from gm_ompl.graph.heuristic import NoHeuristic
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.graph.sets import LIFTED
from gm_ompl.graph.watch import Stopped
from gm_ompl.moves import Move
from gm_ompl.planners.lane_search import LaneSearch
from gm_ompl.planners.lane_sources import start_sets
from gm_ompl.planners.outcome import Log, result_of, without_search
from gm_ompl.planners.planner import Budget, Report, SearchResult, Status
from gm_ompl.planners.trace import tracer
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
