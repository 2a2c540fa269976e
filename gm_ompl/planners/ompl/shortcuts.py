"""A path made cheaper: the cheapest way through the states that it leads through."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Sequence

from gm_ompl.holds.watch import Stop
from gm_ompl.planners.ompl.motions import HybridMotions
from gm_ompl.problem import Regrasp
from gm_ompl.sampling.motions import HybridState
from gm_ompl.sampling.stages import after


def shortcut(
    motions: HybridMotions, states: Sequence[HybridState], stop: Stop
) -> list[HybridState]:
    """Return a path from the first to the last of ``states`` that is no dearer.

    It leads through some of the states, in order, and through some of those where the path
    regrasps. Of all such paths it is the cheapest, unless ``stop`` comes first.

    Args:
        motions: what motions consist of and cost.
        states: a path.
        stop: whether to be content.
    """
    way = _rests(motions, states)
    last, least = len(way) - 1, motions.model.least_cost
    ahead = [least(state, way[last]) for state in way]
    best = math.fsum(motions.cost(a, b) for a, b in itertools.pairwise(states))
    cost, through = [0.0] + [math.inf] * last, [[way[0]]] + [list[HybridState]()] * last
    shortest = list(states)
    edges = [(least(way[0], way[k]) + ahead[k], 0, k) for k in range(1, last + 1)]
    heapq.heapify(edges)
    while edges and not stop():
        estimate, i, j = heapq.heappop(edges)
        if estimate >= best:
            break
        found = cost[i] + motions.cost(way[i], way[j])
        if found >= cost[j] or found + ahead[j] >= best:
            continue
        cost[j], through[j] = found, [*through[i], way[j]]
        if j == last:
            best, shortest = found, through[j]
        for k in range(j + 1, last + 1):
            heapq.heappush(edges, (found + least(way[j], way[k]) + ahead[k], j, k))
    return shortest


def _rests(motions: HybridMotions, states: Sequence[HybridState]) -> list[HybridState]:
    """Return the states of a path and those before and after each regrasp, in order."""
    way = dict.fromkeys(states[:1])
    for origin, target in itertools.pairwise(states):
        for move in motions.expand(origin, target) or ():
            if isinstance(move, Regrasp):
                at = motions.model.where(move)
                way[HybridState(at, move.placements)] = None
                way[HybridState(at, after(move))] = None
        way.pop(target, None)
        way[target] = None
    return list(way)
