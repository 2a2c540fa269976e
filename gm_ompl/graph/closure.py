"""The part of an object graph that plans up to a cost can use: it grows with that cost."""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Final, cast, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.holds.watch import Stop, never
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Problem

if TYPE_CHECKING:
    from gm_ompl.contact.lattice import ContactLattice  # paths do without

AHEAD: Final = 32
"""Nodes whose arcs are made at once."""


@final
class Closure:
    """Nodes by a lower bound on plans that pass them.

    A fingertip that is kept all along travels to a node at least as far as the shortest way there
    takes it, and on at least straight to where it is at the goal. Of n fingers k regrasps leave
    n - k kept, at different placements: the plan costs at least k X_regr and the (n - k)-th
    smallest such travel of all placements. With n regrasps or more it costs at least n X_regr and
    the travel to the node with whatever placement is best on each arc.

    Args:
        judge: of the problem.
        stop: asked now and then.

    Raises:
        LimitError: ``stop`` said so.
    """

    def __init__(self, judge: Judge, stop: Stop = never) -> None:
        problem, hand = judge.problem, judge.problem.fingers
        assert isinstance(problem.motion, FreeMotion), "other graphs are searched whole"
        self._graph, self._stop = cast("ContactLattice", problem.object_graph), stop
        self._fingers, self._X_regr = hand.count, float(problem.cost.regrasp)
        firsts = firsts_of(hand.shapes)
        self._centres = [judge.centres(i) for i in firsts.values()]
        self._lifts = lifts(problem)
        self._tips = np.concatenate([*self._centres, np.zeros((0, 3))])
        self._travel: dict[Hashable, tuple[Array, float]] = {}
        self._leaving: dict[int, Sequence[GraphArc]] = {}
        self._doubling: tuple[float, int] | None = None  # up to which bound, and how many nodes
        start, here = self._graph.start, judge.node(self._graph.pose(self._graph.start))
        free = np.concatenate([here.free[i] for i in firsts.values()] or [np.zeros(0, dtype=bool)])
        self._kept = {start: np.where(free, 0.0, np.inf)}
        self._best = {start: 0.0}
        self._onward: dict[int, Array] = {}
        self._seen: tuple[int, dict[int, tuple[Array, float]]] = (0, {})
        self._goal = GoalDistance(problem.motion.goal, self._tips)
        self._keys = {start: self._key(start)}
        self._open = [(self._keys[start], start)]

    @property
    def next(self) -> float:
        """The least bound of a node that is not in it yet; +inf where it is whole."""
        while self._open and (
            self._open[0][1] in self._leaving or self._open[0][0] > self._keys[self._open[0][1]]
        ):
            heapq.heappop(self._open)
        return self._open[0][0] if self._open else math.inf

    def to_goal(self, pause: Stop = never) -> float | None:
        """Grow until the goal is in it, or it is whole, or ``pause`` says so.

        Returns:
            The bound at the goal; +inf where it is whole; None where it paused.
        """
        while self.next < math.inf and not pause():
            bound, node = self._open[0]
            self._take()
            if self._graph.in_goal(node):
                return bound
        return None if self.next < math.inf else math.inf

    def __len__(self) -> int:
        return len(self._leaving)

    def grow(self, most: float, nodes: float = math.inf, pause: Stop = never) -> bool:
        """Take in all nodes with a bound of at most this, up to so many; whether that is done.

        Where ``pause`` says so it is not, and can be gone on with.
        """
        while self.next <= most and self.next < math.inf and len(self._leaving) < nodes:
            if pause():
                return False
            self._take()
        return True

    def double(self, pause: Stop = never) -> bool:
        """Take in as many nodes as are in it, and those with the same bound as the last.

        Returns:
            Whether that is done; where ``pause`` says so it is not, and can be gone on with.
        """
        most, count = self._doubling or (0.0, 2 * len(self._leaving))
        while len(self._leaving) < count and self.next < math.inf:
            self._doubling = most, count
            if pause():
                return False
            most = max(most, self.next)
            self._take()
        self._doubling = most, count
        if not self.grow(most, pause=pause):
            return False
        self._doubling = None
        return True

    def leaving(self, most: float = math.inf) -> Mapping[int, Sequence[GraphArc]]:
        """Return the arcs between the nodes in it that plans of at most this cost may pass.

        By their tails. The start is always there.
        """
        inside = set(self._leaving)
        if most < math.inf:
            inside = {node for node in inside if self._through(node) <= most}
            inside.add(self._graph.start)
        return {n: [arc for arc in self._leaving[n] if arc.head in inside] for n in inside}

    def _through(self, node: int) -> float:
        """Return a lower bound on plans that pass a node and do not leave what is in it."""
        ahead = self._ahead().get(node)
        return math.inf if ahead is None else self._bound(node, *ahead)

    def _ahead(self) -> dict[int, tuple[Array, float]]:
        """Return the least travel to the goal from each node in it, as ``_kept`` and ``_best``."""
        if self._seen[0] == len(self._leaving):
            return self._seen[1]
        into: dict[int, list[tuple[int, Array, float]]] = {}
        for tail, arcs in self._leaving.items():
            for arc in arcs:
                into.setdefault(arc.head, []).append((tail, *self._lengths(arc)))
        none = np.zeros(len(self._tips))
        found = {node: (none, 0.0) for node in self._leaving if self._graph.in_goal(node)}
        waiting = deque(found)
        while waiting:
            limits.check()
            node = waiting.popleft()
            kept, best = found[node]
            for tail, travel, least in into.get(node, ()):
                if tail not in self._leaving:
                    continue
                now, before = (kept + travel, best + least), found.get(tail)
                if before is not None:
                    if now[1] >= before[1] and not (now[0] < before[0]).any():
                        continue
                    now = np.minimum(now[0], before[0]), min(now[1], before[1])
                found[tail] = now
                waiting.append(tail)
        self._seen = len(self._leaving), found
        return found

    def _take(self) -> None:
        """Take in the next node."""
        if len(self._leaving) % 32 == 0 and self._stop():
            raise LimitError
        first = self._open[0][1]  # ``next`` was asked, and takes it from there once it is in
        if not self._graph.has_left(first):  # with those that come next, on all cores
            self._graph.leave([node for _, node in heapq.nsmallest(AHEAD, self._open)])
        arcs = self._graph.arcs_from(first)
        self._leaving[first] = [arc for arc in arcs if self._lifts or not arc.bare]
        try:
            self._spread(first)
        except BaseException:
            del self._leaving[first]  # where it leads to is not known yet: plans may pass it
            raise

    def _spread(self, first: int) -> None:
        """Take the arcs into account that leave a node, and what follows for others."""
        waiting = deque([first])
        while waiting:
            limits.check()
            node = waiting.popleft()
            for arc in self._leaving[node]:
                if self._reach(node, arc) and arc.head in self._leaving:
                    waiting.append(arc.head)

    def _reach(self, tail: int, arc: GraphArc) -> bool:
        """Take an arc into account; whether a bound fell at its head."""
        head, (travel, least) = arc.head, self._lengths(arc)
        kept, best = self._kept[tail] + travel, self._best[tail] + least
        before = self._kept.get(head)
        if before is None:
            self._kept[head], self._best[head] = kept, best
        elif best < self._best[head] or (kept < before).any():
            self._kept[head] = np.minimum(kept, before)
            self._best[head] = min(best, self._best[head])
        else:
            return False
        if head not in self._leaving:
            key = self._keys[head] = self._key(head)
            heapq.heappush(self._open, (key, head))
        return True

    def _key(self, node: int) -> float:
        """Return a lower bound on plans that pass a node."""
        onward = self._onward.get(node)
        if onward is None:
            pose = self._graph.pose(node)
            onward = self._onward[node] = self._goal.distances(pose.rotation, pose.position)
        return self._bound(node, onward, 0.0)

    def _bound(self, node: int, onward: Array, best: float) -> float:
        """Return the bound by what is left to go, per placement and for the best on each arc."""
        n, X_regr = self._fingers, self._X_regr
        low, whole = n * X_regr + self._best[node] + best, self._kept[node] + onward
        if len(whole) >= n > 0:
            smallest = np.sort(np.partition(whole, n - 1)[:n])[::-1]
            low = min(low, float((smallest + X_regr * np.arange(n)).min()))
        return low

    def _lengths(self, arc: GraphArc) -> tuple[Array, float]:
        """Return how far fingertips go along an arc, and the best placement's of the slowest."""
        known = None if arc.form is None else self._travel.get(arc.form)
        if known is None:
            each = [arc.lengths(centres).sum(axis=1) for centres in self._centres]
            least = max((float(np.min(own, initial=math.inf)) for own in each), default=0.0)
            known = np.concatenate([*each, np.zeros(0)]), least
            if arc.form is not None:
                self._travel[arc.form] = known
        return known


def lifts(problem: Problem) -> bool:
    """Whether fingers alone may hold the object with the margin that is asked for."""
    hand = problem.fingers
    # Two points of contact resist no moment about the line that joins them.
    point, needed = not hand.soft.any(), problem.mechanics.z_min > 0.0
    return not (needed and point and hand.count < 3)


def firsts_of(shapes: Sequence[tuple[float, int]]) -> dict[tuple[float, int], int]:
    """Return the first finger of each shape, of the fingers' shapes."""
    return {shape: i for i, shape in reversed(list(enumerate(shapes)))}
