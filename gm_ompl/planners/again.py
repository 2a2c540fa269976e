"""Searches again where the plan found stops at a junction that does not hold.

Costs know nothing of junctions (``contact.junction``). What a randomised planner found on its way,
or finds when it is asked again, may do without the one that fails; a search on the lattice would
find the same plan again.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from gm_ompl import limits
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.planner import Budget, Planner, SearchResult, Status
from gm_ompl.planners.steady import Steady, steady_moves
from gm_ompl.problem import Move

SEARCHES = 8
"""At most, the first included."""

STEADY_SECONDS = 0.5
"""What steady control may take at least, after a search that used its time up [s]."""

COUNTED = ("time_s", "expanded", "generated", "mode_decisions")
"""Statistics that add up over several searches."""


def settled(
    searcher: Planner, judge: Judge, result: SearchResult, budget: Budget, rng: np.random.Generator
) -> tuple[SearchResult, Steady]:
    """Return how searches ended, and their plan under steady control.

    A plan whose junctions hold, if only at rest, goes before a cheaper one with one that fails.

    Args:
        searcher: has searched, and may again.
        judge: of the problem.
        result: of the first search.
        budget: what all searches together may spend.
        rng: the only source of randomness.
    """
    result, steady = _chosen(judge, result)
    if not searcher.specs.randomised:
        return result, steady
    for _ in range(SEARCHES - 1):
        budget_left = left(budget, result)
        if not steady.fails or budget_left is None:
            break
        try:
            again, other = _chosen(judge, searcher.solve(judge.problem, judge, budget_left, rng))
        except LimitError:
            break
        statistics = added(result, again)
        if other.stands:
            return dataclasses.replace(again, statistics=statistics), other
        counted = {key: statistics[key] for key in COUNTED}
        result = dataclasses.replace(result, statistics={**result.statistics, **counted})
        if again.status is Status.INTERRUPTED:
            break
    return result, steady


def with_hand(judge: Judge, result: SearchResult) -> Judge:
    """Return a judge of the problem with the placements that a result's moves name."""
    if result.fingers is None:
        return judge
    problem = dataclasses.replace(judge.problem, fingers=result.fingers)
    return Judge(problem, make_backend(problem))


def _chosen(judge: Judge, result: SearchResult) -> tuple[SearchResult, Steady]:
    """Return the result with the cheapest plan without a failing junction, if there is one."""
    judge = with_hand(judge, result)
    best = _steady(judge, result.moves)
    if best.fails:
        for moves in result.others:
            other = _steady(judge, moves)
            if other.stands:
                cost = math.fsum(move.cost for move in moves)
                return dataclasses.replace(result, moves=moves, cost=cost, optimal=False), other
    return result, best


def _steady(judge: Judge, moves: tuple[Move, ...]) -> Steady:
    """Return moves under steady control; a search that used its time up gets a little for it."""
    try:
        seconds = limits.left()
        with limits.lifted(max(seconds, STEADY_SECONDS) if seconds < math.inf else None):
            return steady_moves(judge, moves)
    except (KeyboardInterrupt, LimitError):
        return Steady(moves, None)


def left(budget: Budget, result: SearchResult) -> Budget | None:
    """Return what is left of a budget after a search; None where that is nothing."""
    if result.status is not Status.SOLVED or limits.reached() or (budget.stop and budget.stop()):
        return None
    most, seconds = budget.max_iterations, budget.time_limit
    if most is not None:
        most -= int(result.statistics["expanded"])
    if seconds is not None:
        seconds -= float(result.statistics["time_s"])
    if min(1 if most is None else most, 1.0 if seconds is None else seconds) <= 0:
        return None
    return dataclasses.replace(budget, max_iterations=most, time_limit=seconds)


def added(first: SearchResult, second: SearchResult) -> dict[str, object]:
    """Return the second search's statistics, the first one's added."""
    before, now = first.statistics, second.statistics
    counted = {key: before[key] + now[key] for key in COUNTED}
    history = [[before["time_s"] + time, *rest] for time, *rest in now["history"]]
    return {**now, **counted, "history": history}
