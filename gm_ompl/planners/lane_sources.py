"""Where lanes come from: all start sets, in increasing order of their lower bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Protocol, final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goals import restricted
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.graph.sets import ordered_sets, placement_sets
from gm_ompl.problem import Placements, Problem

MOST_SETS = 2_000_000
"""Start sets kept in one array; beyond, they are made one by one with weaker bounds."""

FIRST_REKEYING = 128
"""Stale keys met before all keys are computed anew; doubles each time."""


class Source(Protocol):
    """Start sets, one at a time."""

    def key(self) -> float:
        """Return a lower bound on the cost of plans from the next set; +inf at the end."""

    def take(self) -> tuple[float, Placements]:
        """Return the next set with its bound."""

    def wasted(self) -> None:
        """Hear that a set's bound had gone stale when it was treated."""

    def renew(self) -> None:
        """Make the bounds of all sets that still wait as tight as they can be now."""


@final
class SortedSets:
    """All start sets in one array, sorted; sorted anew when cuts have made the bounds stale."""

    def __init__(self, sets: IntArray, start: int, graph: LaneGraph) -> None:
        self._sets, self._start, self._graph = sets, start, graph
        self._stale, self._patience = 0, FIRST_REKEYING
        self._compute()

    def _compute(self) -> None:
        keys = self._graph.keys(self._sets, self._start)
        hopeful = np.flatnonzero(np.isfinite(keys))
        order = hopeful[np.argsort(keys[hopeful], kind="stable")]
        self._sets, self._keys = np.ascontiguousarray(self._sets[order]), keys[order]
        self._next = 0

    def key(self) -> float:
        """Return the bound of the next set."""
        return float(self._keys[self._next]) if self._next < len(self._keys) else math.inf

    def take(self) -> tuple[float, Placements]:
        """Return the next set with its bound."""
        i = self._next
        self._next += 1
        return float(self._keys[i]), tuple(self._sets[i].tolist())

    def wasted(self) -> None:
        """Count; when too many were stale, renew the bounds of all sets that still wait."""
        self._stale += 1
        if self._stale >= self._patience:
            self._patience *= 2
            self.renew()

    def renew(self) -> None:
        """Renew the bounds of all sets that still wait."""
        self._stale = 0
        self._sets = np.ascontiguousarray(self._sets[self._next :])
        self._compute()


@final
class OrderedSets:
    """Start sets made on demand, for hands with more sets than memory holds."""

    def __init__(self, sets: Iterator[tuple[float, Placements]]) -> None:
        self._sets = sets
        self._head = next(sets, None)

    def key(self) -> float:
        """Return the bound of the next set."""
        return math.inf if self._head is None else self._head[0]

    def take(self) -> tuple[float, Placements]:
        """Return the next set with its bound."""
        assert self._head is not None, "taken from an empty source"
        head, self._head = self._head, next(self._sets, None)
        return head

    def wasted(self) -> None:
        """Nothing to renew: bounds do not depend on cuts."""

    def renew(self) -> None:
        """Nothing to renew."""


def start_sets(problem: Problem, judge: Judge, graph: LaneGraph, start: int) -> Source:
    """Return the source of all valid sets at the start node."""
    tables = graph.tables
    geometry = judge.node(problem.lattice.coordinates(start))
    allowed = restricted(geometry.free, problem.fingers.start)
    groups = problem.fingers.groups()
    sets = placement_sets(groups, allowed, judge.clear, MOST_SETS)
    if sets is not None:
        return SortedSets(sets, start, graph)
    onward = tables.X_regr + tables.least[start]
    keys = [np.minimum(tables.ahead[i, :, start], onward) for i in range(len(allowed))]
    return OrderedSets(ordered_sets(groups, allowed, keys, judge.clear))
