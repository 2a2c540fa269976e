"""Best-first search of the paper's graph, whatever the motion's degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from gm_ompl import limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.feasibility_graph import FeasibilityGraph
from gm_ompl.graph.heuristic import Heuristic, NoHeuristic, TravelHeuristic
from gm_ompl.graph.planar_heuristic import PlanarHeuristic, suits
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.goals import valid_goals
from gm_ompl.holds.sets import LIFTED
from gm_ompl.holds.watch import Stop
from gm_ompl.planners.astar import BestFirstSearch, Told
from gm_ompl.planners.outcome import Log, result_of, without_search
from gm_ompl.planners.planner import Budget, Report, SearchResult, Status
from gm_ompl.planners.trace import Expansion, Trace, tracer
from gm_ompl.problem import Problem

MakeHeuristic: TypeAlias = Callable[[Judge, tuple[int, ...], Stop], Heuristic]
"""From judge, the goal's valid nodes (at least one) and what may break it off."""


def _heuristic(name: str, problem: Problem) -> MakeHeuristic:
    """Return what bounds the cost to the goal, by the name of a planner's parameter."""
    if name == "none":
        return lambda judge, *_: NoHeuristic(judge.problem)
    if name == "lanes" and suits(problem):
        return PlanarHeuristic
    return lambda judge, goals, _: TravelHeuristic(judge, goals)


def solve_on_lattice(
    problem: Problem, judge: Judge, budget: Budget, report: Report, heuristic: str
) -> SearchResult:
    """Search the manipulation-feasibility graph of ``problem`` for a plan of least cost.

    Args:
        problem: what to plan.
        judge: answers about it.
        budget: what the search may spend.
        report: called now and then with its progress.
        heuristic: lanes, travel or none.

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
        make = _heuristic(heuristic, problem)
        bound = make(judge, valid, log.meter.spent) if valid else NoHeuristic(problem)
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
