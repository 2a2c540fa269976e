"""Sets of placements along one route, what is known of each, and random ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.direct import direct
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.bounds import reaches
from gm_ompl.holds.known import FAILED, Known
from gm_ompl.holds.sets import LIFTED, PlacementSets, beside, staying_of
from gm_ompl.problem import Placements, Problem
from gm_ompl.sampling.route import Route

_reaches = direct(reaches)


@final
class LaneStore:
    """Sets along one route. A set along a route is a lane.

    Args:
        judge: answers about the problem.
        sets: canonical sets, shared by all routes.
        route: the route.

    Attributes:
        route: likewise.
        known: what was decided along it.
    """

    def __init__(self, judge: Judge, sets: PlacementSets, route: Route) -> None:
        self._judge, self._sets, self.route = judge, sets, route
        self.known = Known(judge, route.table)

    def screen(self, sets: IntArray, first: int, last: int, reach: IntArray) -> None:
        """Tighten ``reach`` (L,): how far each set (L, n) may come from ``first`` to ``last``.

        Where ``last`` is the smaller vertex the motion is followed backwards, from its end.
        """
        _reaches(sets, first, last, self.route.table.tables, self.known.cuts, reach)

    def costs(self, sets: IntArray) -> Array:
        """Return lower bounds (L, K) on Eq. (9) per set and stride, from all that is known."""
        return self.known.bounds(sets)[0]

    def probe(self, lane: Placements, first: int, last: int) -> int:
        """Decide the strides of ``lane`` from vertex ``first`` towards ``last`` until one fails.

        Mechanics alone: ``screen`` knows the geometry. The segments that fail most often are asked
        first.

        Returns:
            ``last`` if all hold; else the vertex beyond which the failing stride lies, as seen
            from ``first``. Strides before it may still be undecided.
        """
        low, high = min(first, last), max(first, last)
        margins = self.known.margins(lane)
        bad = np.flatnonzero((margins[low:high] == FAILED).any(axis=1))
        if len(bad):
            return int(low + bad[0]) if last > first else int(low + bad[-1] + 1)
        open_ = np.argwhere(np.isinf(margins[low:high]))
        doubt = self.route.suspicion()[low:high]
        order = np.argsort(-doubt[open_[:, 0], open_[:, 1]])
        decided: dict[int, float] = {}
        for k, p in open_[order].tolist():
            stride = low + k
            state = self.route.table.state(stride, p)
            if state not in decided:
                decided[state] = self.known.decide(lane, state)
            margins[stride, p] = decided[state]
            fails = margins[stride, p] == FAILED
            self.route.tried[stride, p] += 1.0
            self.route.failed[stride, p] += fails
            if fails:
                return int(stride if last > first else stride + 1)
        return last

    def lifted(self, lane: Placements, slot: int) -> Placements:
        """Return the canonical set of ``lane`` with the finger at ``slot`` lifted."""
        return self._sets.replaced(lane, slot, LIFTED)

    def joined(self, hub: Placements, vertex: int, before: Placements, after: Placements) -> bool:
        """Whether the finger lifted at a hub gets through the air from one set to another."""
        (a,), (b,) = ((Counter(lane) - Counter(hub)).elements() for lane in (before, after))
        pose, slot = self.route.way.poses[vertex], hub.index(LIFTED)
        return self._judge.reach.joined(pose, slot, staying_of(hub), a, b)

    def outside(self, hub: Placements, vertex: int, lane: Placements) -> bool:
        """Whether the finger of a set that is lifted at a hub can get away."""
        (row,) = (Counter(lane) - Counter(hub)).elements()
        pose, slot = self.route.way.poses[vertex], hub.index(LIFTED)
        return self._judge.reach.outside(pose, slot, staying_of(hub), row)

    def free_at_end(self, lane: Placements, vertex: int) -> bool:
        """Whether the fingers can touch at the route's start, or leave at its end if they must."""
        hand, reach = self._judge.problem.fingers, self._judge.reach
        if vertex and not hand.leave:
            return True
        standing = () if vertex else hand.standing
        return reach.landing(self.route.way.poses[vertex], lane, standing) is not None

    def targets(self, hub: Placements, vertex: int) -> IntArray:
        """Return the canonical sets (L, n) that the lifted finger of ``hub`` can make there."""
        return self._completed(hub, self.route.node_free[hub.index(LIFTED), :, vertex])

    def anywhere(self, hub: Placements) -> IntArray:
        """Return the canonical sets (L, n) that the lifted finger of ``hub`` can make somewhere."""
        return self._completed(hub, self.route.node_free[hub.index(LIFTED)].any(axis=1))

    def _completed(self, hub: Placements, free: BoolArray) -> IntArray:
        slot, fits = hub.index(LIFTED), free & beside(hub, self._judge.clear)
        # Equal fingertips of no size would fit on one point; two on one are one.
        fits[[row for row in hub if row != LIFTED]] = False
        rows = np.flatnonzero(fits).tolist()
        return as_sets((self._sets.replaced(hub, slot, row) for row in rows), len(hub))


def as_sets(sets: Iterable[Placements], count: int) -> IntArray:
    """Return sets of ``count`` fingers as an array (L, count)."""
    return np.array(list(sets), dtype=np.int64).reshape(-1, count)


@final
class SetDraw:
    """Draws valid sets of placements at one end of the motion and learns from how far they get.

    A placement's weight is the mean share of the way that sets with it came (one success and
    one failure are assumed before the first), times that of its face, to the power ``lean``;
    ``explore`` of the probability is spread evenly.

    Args:
        problem: the problem.
        judge: answers about it.
        lean: 0 draws evenly.
        explore: share of even draws.
    """

    def __init__(self, problem: Problem, judge: Judge, lean: float, explore: float) -> None:
        self._groups = problem.fingers.groups()
        self._clear = judge.clear
        self._lean, self._explore = lean, explore
        table = problem.fingers.placements
        self._face, self._faces = table.face, len(table.labels)
        n, rows = problem.fingers.count, len(table)
        self._tried = np.zeros((n, rows))
        self._gone = np.zeros((n, rows))

    def learn(self, sets: IntArray, shares: Array) -> None:
        """Learn that ``sets`` (L, n) came ``shares`` (L,) of the way, each in 0..1."""
        for i in range(sets.shape[1]):
            np.add.at(self._tried[i], sets[:, i], 1.0)
            np.add.at(self._gone[i], sets[:, i], shares)
        for group in self._groups:
            if len(group) > 1:
                for counts in (self._tried, self._gone):
                    counts[list(group)] = counts[list(group)].mean(axis=0)

    def _weights(self, i: int, allowed: BoolArray) -> Array:
        rows = np.flatnonzero(allowed)
        tried, gone = self._tried[i], self._gone[i]
        by_face = np.bincount(self._face, tried, self._faces)
        gone_by_face = np.bincount(self._face, gone, self._faces)
        face = (gone_by_face + 1.0) / (by_face + 2.0)
        own = (gone[rows] + 2.0 * face[self._face[rows]]) / (tried[rows] + 2.0)
        weights = (own * face[self._face[rows]]) ** self._lean
        share: Array = weights / weights.sum()
        return (1.0 - self._explore) * share + self._explore / len(rows)

    def draw(self, count: int, allowed: Sequence[BoolArray], rng: np.random.Generator) -> IntArray:
        """Return up to ``count`` different canonical sets (L, n), valid as ``allowed`` says.

        Args:
            count: sets drawn; those that do not fit together or repeat are dropped.
            allowed: per finger, (P,), where it may be.
            rng: the source of randomness.
        """
        n = len(allowed)
        if not all(mask.any() for mask in allowed):
            return np.zeros((0, n), dtype=np.int64)
        sets = np.empty((count, n), dtype=np.int64)
        for i, mask in enumerate(allowed):
            chance = self._weights(i, mask)
            sets[:, i] = rng.choice(np.flatnonzero(mask), size=count, p=chance)
        return self.fitting(sets)

    def fitting(self, sets: IntArray) -> IntArray:
        """Return those of some sets (L, n) that fit together, canonical, none twice."""
        for group in self._groups:
            columns = list(group)
            sets[:, columns] = np.sort(sets[:, columns], axis=1)
        keep = np.ones(len(sets), dtype=bool)
        for i in range(sets.shape[1]):
            for j in range(i):
                keep &= sets[:, i] != sets[:, j]
                pair = self._clear[i][j]
                if pair is not None:
                    keep &= pair[sets[:, i], sets[:, j]]
        sets = sets[keep]
        _, first = np.unique(sets, axis=0, return_index=True)
        return np.ascontiguousarray(sets[np.sort(first)])
