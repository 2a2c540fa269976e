"""A* over states of the object with fingertips in place, all sets of placements at once."""

from __future__ import annotations

import math
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.kept_tables import ARRIVED
from gm_ompl.graph.state_graph import StateGraph
from gm_ompl.holds.extraction import moves_of
from gm_ompl.planners.outcome import Log
from gm_ompl.problem import Move

MANY: Final = 4000
"""States that are followed at once where their bounds are near each other."""

SAME: Final = 1e-9
"""A plan is no better by less than this, relatively."""


@final
class StateSearch:
    """One search; it can be gone on with.

    Args:
        judge: answers about the problem.
        graph: states of the plans that are looked for.
        log: its budget is spent.
        bound: what such plans are known to cost at least.

    Attributes:
        graph: likewise.
        bound: no such plan is cheaper.
        cost: of the best plan that was found, or +inf.
        expanded: states that were followed, those followed again included.
    """

    def __init__(self, judge: Judge, graph: StateGraph, log: Log, bound: float = 0.0) -> None:
        self._judge, self._log, self.graph = judge, log, graph
        self._best, self._arrived = -1, 0
        self.bound, self.cost, self.expanded = bound, math.inf, 0
        self._arrive()

    def step(self, enough: float) -> None:
        """Go on where plans cheaper than ``enough`` may begin.

        Raises:
            LimitError: a limit is reached.
        """
        limits.check()
        if self._log.meter.spent():
            raise LimitError
        self._take_arrived()
        graph, most = self.graph, min(self.cost, enough)
        open_, key = graph.open, graph.tables.book.key
        keys = key[open_]
        front = float(keys.min(initial=math.inf))
        if graph.doubt < math.inf and front >= graph.doubt:
            front, graph.full = graph.doubt, True
        if front >= most * (1.0 - SAME):
            self.bound = max(self.bound, most)
            return
        self.bound = max(self.bound, front)
        travel = max(front - graph.paid, 0.0)
        low, high = (front + slack * travel for slack in graph.slack)
        many = float(np.partition(keys, MANY)[MANY]) if len(keys) > MANY else math.inf
        limit = min(most * (1.0 - SAME), max(low, min(high, many)))
        if not graph.reach(limit):
            self._follow(open_[keys <= limit], limit)

    def _follow(self, which: IntArray, limit: float) -> None:
        """Follow what leads on from states, and find what was asked for."""
        graph = self.graph
        graph.follow(which, limit)
        self.expanded += len(which)
        self._take_arrived()

    def _take_arrived(self) -> None:
        """Look for a better way where some have led to the goal since."""
        arrived = int(self.graph.tables.book.counts[ARRIVED])
        if arrived > self._arrived:
            self._arrive()
            self._arrived = arrived  # last: a limit may be reached before

    def _arrive(self) -> None:
        """Look for the best way that leads to the goal."""
        there, cost = self.graph.arrived(), self.graph.tables.book.cost
        there = there[cost[there] < self.cost]
        for number in there[np.argsort(cost[there], kind="stable")].tolist():
            if self.graph.stands(number):
                self._best, self.cost = number, float(cost[number])
                return

    def moves(self) -> tuple[Move, ...]:
        """Return the best plan's moves; none where no plan is known."""
        if self._best < 0:
            return ()
        nodes, legs = self.graph.legs(self._best)
        return moves_of(self._judge, self._judge.problem.object_graph.way(nodes), legs)
