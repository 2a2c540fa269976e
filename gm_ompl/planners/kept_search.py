"""Exact search for plans of free motion that keep the whole hand in place: A* over all sets.

Plans with k regrasps cost at least k X_regr and what fingertips that are kept must travel; so a
plan without regrasping that is cheaper than all of those is optimal.
"""

from __future__ import annotations

import math
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.kept_graph import START, KeptGraph
from gm_ompl.graph.kept_tables import ARRIVED, STATES
from gm_ompl.holds.extraction import moves_of
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.outcome import Log
from gm_ompl.problem import Move

SLACK: Final = 0.02
"""The limit on bounds is ahead of the least one by this, relatively."""

SAME: Final = 1e-9
"""A plan is no better by less than this, relatively."""


@final
class KeptSearch:
    """One search; it can be gone on with.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.
        log: its budget is spent.

    Attributes:
        bound: no plan is cheaper, with regrasps or without.
        cost: of the best plan that was found here, or +inf.
        expanded: states whose arcs were followed, those followed again included.
        closed: whether no plan is cheaper than what was enough at last.
    """

    def __init__(self, judge: Judge, log: Log) -> None:
        self._judge, self._log = judge, log
        self.graph = KeptGraph(judge)
        self._regrasping = self._with_regrasps()
        self._best, self._arrived = -1, 0
        self.bound, self.cost, self.expanded = 0.0, math.inf, 0
        self.closed, self._limit = False, 0.0
        self._arrive()

    def _with_regrasps(self) -> float:
        """Return a lower bound on plans that regrasp."""
        hand, price = self._judge.problem.fingers, float(self._judge.problem.cost.regrasp)
        n, start = hand.count, self._judge.problem.object_graph.pose(START)
        free, motion = self._judge.node(start).free, self._judge.problem.motion
        there = self.graph.goal_sets.free()
        assert isinstance(motion, FreeMotion)
        ways = [
            GoalDistance(motion.goal, self._judge.centres(i)[free[i] & there[i]])
            .distances(start.rotation, start.position)
            .min(initial=math.inf)
            for i in range(n)
        ]
        one = price + min(ways) if n > 1 else math.inf
        return min(one, n * price)

    @classmethod
    def of(cls, judge: Judge, log: Log) -> KeptSearch | None:
        """Return a search, or None where there is nothing to keep, or too much."""
        if not judge.problem.fingers.count:
            return None
        search = cls(judge, log)
        return search if len(search.graph.tables.hands.rows) else None

    @property
    def done(self) -> bool:
        """Whether it can say no more."""
        known = self.bound >= min(self.cost, self._regrasping)
        return self.closed or known or self.graph.full

    def proves(self, cost: float) -> bool:
        """Whether a plan of this cost is proven optimal where no plan found here is cheaper."""
        return cost <= self._regrasping

    def step(self, enough: float) -> None:
        """Go on where plans cheaper than ``enough`` may begin.

        Raises:
            LimitError: a limit is reached.
        """
        limits.check()
        if self._log.meter.spent():
            raise LimitError
        if self._log.due():
            self._log.event(min(self.cost, enough), self.bound, self.expanded, len(self.graph.open))
        most = min(self.cost, enough) * (1.0 - SAME)
        open_, key = self.graph.open, self.graph.tables.book.key
        front = float(key[open_].min(initial=math.inf))
        if front >= most:
            front = min(self.cost, enough)
        self.bound = max(self.bound, min(front, self._regrasping))
        if self.bound < min(self.cost, enough, self._regrasping):
            self._limit = min(most, max(self._limit, front * (1.0 + SLACK)))
            self._follow(open_[key[open_] <= self._limit], self._limit)
        else:
            self.closed = True

    def _follow(self, which: IntArray, limit: float) -> None:
        """Follow the arcs from states, and find what was asked for."""
        graph = self.graph
        which = graph.sharpen(which, limit)
        graph.follow(which, limit)
        self.expanded += len(which)
        graph.answer()
        if graph.tables.book.counts[ARRIVED] > self._arrived:
            self._arrived = int(graph.tables.book.counts[ARRIVED])
            self._arrive()

    def _arrive(self) -> None:
        """Look for the best way that leads to the goal."""
        poses, book = self.graph.tables.poses, self.graph.tables.book
        states = slice(0, int(book.counts[STATES]))
        there = np.flatnonzero(poses.goal[book.pose[states]] & (book.cost[states] < self.cost))
        for number in there[np.argsort(book.cost[there], kind="stable")].tolist():
            if self._stands(number):
                self._best, self.cost = number, float(book.cost[number])
                return

    def _stands(self, number: int) -> bool:
        """Whether fingers get to where they are at the start of a way, and off at its end.

        The grids that say so are no mirror images: where they refuse a set, its images are asked.
        """
        hands, book = self.graph.tables.hands, self.graph.tables.book
        hand, problem = int(book.hand[number]), self._judge.problem
        if not hands.alive[hand]:
            return False
        placements, reach = self.graph.placements(hand), self._judge.reach
        start = problem.object_graph.pose(START)
        if reach.landing(start, placements, problem.fingers.standing) is None:
            hands.alive[hand] = False
            self.graph.open_images(hand)
            return False
        end = problem.object_graph.pose(int(book.pose[number]))
        stands = not problem.fingers.leave or reach.landing(end, placements) is not None
        if not stands:
            self.graph.open_images(hand)
        return stands

    def moves(self) -> tuple[Move, ...]:
        """Return the best plan's moves; none where no plan is known."""
        if self._best < 0:
            return ()
        nodes = self.graph.way(self._best)
        placements = self.graph.placements(int(self.graph.tables.book.hand[self._best]))
        way = self._judge.problem.object_graph.way(nodes)
        return moves_of(self._judge, way, [(placements, 0, len(nodes) - 1)])
