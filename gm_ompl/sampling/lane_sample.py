"""The lanes sampled along one route, and the cheapest plan through them.

A lazy search: strides cost what bounds say until a path that uses them is the cheapest; then the
path is judged, what is most likely to fail first. Edges follow the best parent by construction,
so no tree has to be rewired.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.holds.extraction import Leg, merged
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Placements, Problem
from gm_ompl.sampling.lane_store import LaneStore

CHEAPER: Final = 1.0 - 1e-9
"""A plan is better only by this factor: sums in another order are no improvement."""

RENEW: Final = 32
"""Cuts that may be added before all bounds are renewed."""


@final
class LaneSample:
    """A growing set of lanes of one route.

    Args:
        problem: the problem.
        store: what is known along the route.

    Attributes:
        sets: (L, n), the lanes.
        least: (K + 1,), no plan pays less for displacement from a vertex to the goal.
        best: cost of the best plan found in this sample.
    """

    def __init__(self, problem: Problem, store: LaneStore) -> None:
        self.store = store
        self._problem, self._X = problem, problem.cost.regrasp
        self._K, n = store.route.strides, problem.fingers.count
        self.sets: IntArray = np.zeros((0, n), dtype=np.int64)
        self._members: set[Placements] = set()
        self._costs: Array = np.zeros((0, self._K))
        self._hubs: IntArray = np.zeros((0, n), dtype=np.int64)
        self._hub_numbers: dict[Placements, int] = {}
        self._hub_sets: list[Placements] = []
        self._unstable: BoolArray = np.zeros((0, self._K + 1), dtype=bool)
        self._stuck: tuple[set[Placements], set[Placements]] = set(), set()
        self._barred: dict[int, set[tuple[Placements, int]]] = {}
        self._renewed_at = store.known.version
        self.least = store.route.table.measured.least
        self.best = math.inf

    def __len__(self) -> int:
        return len(self.sets)

    def add(self, sets: IntArray) -> None:
        """Add lanes (L, n); those known already are passed over."""
        fresh = [k for k, row in enumerate(sets.tolist()) if tuple(row) not in self._members]
        if not fresh:
            return
        new = np.ascontiguousarray(sets[fresh])
        self._members.update(tuple(row) for row in new.tolist())
        self.sets = np.ascontiguousarray(np.concatenate([self.sets, new]))
        self._costs = np.concatenate([self._costs, self.store.costs(new)])
        self._hubs = np.concatenate([self._hubs, self.hub_numbers(new)])

    def hub_numbers(self, sets: IntArray) -> IntArray:
        """Return (L, n): the number of the hub of each set with each finger lifted."""
        numbers = np.empty_like(sets)
        for m, row in enumerate(sets.tolist()):
            for slot in range(len(row)):
                hub = self.store.lifted(tuple(row), slot)
                number = self._hub_numbers.setdefault(hub, len(self._hub_sets))
                if number == len(self._hub_sets):
                    self._hub_sets.append(hub)
                numbers[m, slot] = number
        more = len(self._hub_sets) - len(self._unstable)
        if more > 0:
            room = np.zeros((max(more, len(self._unstable)), self._K + 1), dtype=bool)
            self._unstable = np.concatenate([self._unstable, room])
        return numbers

    def keep(self, keep: BoolArray) -> None:
        """Drop the lanes (L,) that are not to be kept."""
        self.sets, self._costs = np.ascontiguousarray(self.sets[keep]), self._costs[keep]
        self._hubs = self._hubs[keep]
        self._members = {tuple(row) for row in self.sets.tolist()}

    def _renew(self) -> None:
        if self.store.known.version - self._renewed_at >= RENEW:
            self._costs = self.store.costs(self.sets)
            self._renewed_at = self.store.known.version

    def _valid(self, sets: IntArray) -> BoolArray:
        """Return (L, K + 1), whether all fingertips are free at each vertex."""
        free = self.store.route.node_free
        valid = np.ones((len(sets), self._K + 1), dtype=bool)
        for i in range(sets.shape[1]):
            valid &= free[i, sets[:, i]]
        return valid

    def _fits(self, sets: IntArray, wanted: Sequence[int | None], vertex: int) -> BoolArray:
        """Return which sets (L,) a plan may begin or end with, at vertex 0 or K."""
        fits = np.ones(len(sets), dtype=bool)
        for lane in self._stuck[vertex > 0]:
            fits &= (sets != np.array(lane)).any(axis=1)
        for i, row in enumerate(wanted):
            if row is not None:
                fits &= sets[:, i] == row
        return fits

    def onward(self) -> tuple[Array, Array]:
        """Return lower bounds on the cost to the goal: per lane (L, K + 1), per hub (H, K + 1).

        They hold for plans through lanes of the sample; a hub's bound leaves out X_regr.
        """
        return self._sweep(range(self._K, -1, -1), self._problem.fingers.goal, 1, 0)

    def so_far(self) -> tuple[Array, Array]:
        """Return lower bounds on the cost from the start, likewise."""
        return self._sweep(range(self._K + 1), self._problem.fingers.start, -1, -1)

    def _sweep(
        self, vertices: range, given: Sequence[int | None], side: int, stride: int
    ) -> tuple[Array, Array]:
        d = np.full((len(self.sets), self._K + 1), np.inf)
        h = np.full((len(self._unstable), self._K + 1), np.inf)
        valid, end = self._valid(self.sets), vertices[0]
        d[self._fits(self.sets, given, end) & valid[:, end], end] = 0.0
        for v in vertices:
            if v != end:
                d[:, v] = self._costs[:, v + stride] + d[:, v + side]
            self._exchange(d, h, v, valid)
        return d, h

    def _exchange(self, d: Array, h: Array, v: int, valid: BoolArray) -> None:
        """Let lanes reach each other through hubs at vertex ``v``, as often as it pays."""
        barred = self._barred_at(v)
        for _ in range(self.sets.shape[1] + 1):
            for slot in range(self.sets.shape[1]):
                along = np.where(barred[:, slot], np.inf, d[:, v])
                np.minimum.at(h[:, v], self._hubs[:, slot], along)
            h[self._unstable[:, v], v] = np.inf
            onward = np.where(barred, np.inf, h[self._hubs, v])
            through = self._X + onward.min(axis=1, initial=np.inf)
            better = valid[:, v] & (through < d[:, v] * CHEAPER)
            if not better.any():
                return
            d[better, v] = through[better]

    def _barred_at(self, v: int) -> BoolArray:
        """Return which fingers (L, n) of which lanes lead nowhere where they are lifted."""
        barred = np.zeros(self.sets.shape, dtype=bool)
        for lane, hub in self._barred.get(v, ()):
            at = (self.sets == np.array(lane)).all(axis=1)
            barred |= at[:, None] & (self._hubs == hub)
        return barred

    def improve(self, below: float, tries: int, stop: Stop) -> list[Leg] | None:
        """Return the legs of a plan cheaper than ``below``, the cheapest of the sample.

        Args:
            below: cost to beat.
            tries: paths that may turn out not to hold before giving up for now.
            stop: asked between judgements.
        """
        for _ in range(tries):
            self._renew()
            d, h = self.onward()
            legs = self._walk(d, h)
            if legs is None or stop():
                return None
            cost, path = legs
            if not cost < below * CHEAPER:
                return None
            if self._holds(path):
                self.best = min(self.best, cost)
                return merged(path)
        return None

    def _walk(self, d: Array, h: Array) -> tuple[float, list[Leg]] | None:
        """Return the cheapest path and its cost; None where the sample has none."""
        starts = np.where(self._fits(self.sets, self._problem.fingers.start, 0), d[:, 0], np.inf)
        if not len(starts) or not starts.min() < np.inf:
            return None
        m = int(np.argmin(starts))
        legs: list[Leg] = []
        v, entered = 0, 0
        while True:
            onward = d[m, v + 1] + self._costs[m, v] if v < self._K else np.inf
            arrived = v == self._K and d[m, v] == 0.0
            if not arrived and onward <= d[m, v] / CHEAPER:
                v += 1
                continue
            legs.append((tuple(self.sets[m].tolist()), entered, v))
            if arrived:
                return float(starts.min()), legs
            if len(legs) > (self._K + 1) * (self.sets.shape[1] + 1):
                return None  # regrasps that cost nothing may go in circles
            barred = self._barred_at(v)
            hub = self._hubs[m, int(np.argmin(np.where(barred[m], np.inf, h[self._hubs[m], v])))]
            group = ((self._hubs == hub) & ~barred).any(axis=1)
            m = int(np.argmin(np.where(group, d[:, v], np.inf)))
            entered = v

    def _holds(self, path: list[Leg]) -> bool:
        """Judge a path; note what fails."""
        for lane, vertex in ((path[0][0], 0), (path[-1][0], self._K)):
            if not self.store.free_at_end(lane, vertex):
                self._stuck[vertex > 0].add(lane)
                return False
        for (before, _, v), (after, _, _) in itertools.pairwise(path):
            hub = self._common(before, after, v)
            if not self.store.known.rest_holds(self._hub_sets[hub], v):
                self._unstable[hub, v] = True
                return False
            if not self.store.joined(self._hub_sets[hub], v, before, after):
                self._bar(hub, v, before, after)
                return False
        held = True
        for lane, first, last in path:
            if self.store.probe(lane, first, last) != last:
                held = False
            at = np.flatnonzero((self.sets == np.array(lane)).all(axis=1))
            before_ = self._costs[at, first:last].sum()
            self._costs[at] = self.store.costs(self.sets[at])
            # Judged margins are lower than their bounds: the path may have become dearer.
            held = held and self._costs[at, first:last].sum() <= before_ / CHEAPER
            if not held:
                return False
        return True

    def _bar(self, hub: int, v: int, before: Placements, after: Placements) -> None:
        """Let whichever finger is in a pocket be lifted there no more, nor set down."""
        lanes = [
            lane for lane in (before, after) if not self.store.outside(self._hub_sets[hub], v, lane)
        ]
        self._barred.setdefault(v, set()).update((lane, hub) for lane in lanes)

    def _common(self, before: Placements, after: Placements, v: int) -> int:
        """Return the hub between two sets."""
        mine = {self._hub_numbers[self.store.lifted(before, k)] for k in range(len(before))}
        return next(
            number
            for k in range(len(after))
            if (number := self._hub_numbers[self.store.lifted(after, k)]) in mine
            and not self._unstable[number, v]
        )

    def bounds(self, sets: IntArray, g: Array, d: Array) -> tuple[Array, Array]:
        """Return for candidate lanes (L, n) two bounds (L,) on a plan's cost through each.

        The first holds for any plan, the second for plans through the hubs known here.

        Args:
            sets: the candidates.
            g: per hub, from ``so_far``.
            d: per hub, from ``onward``.
        """
        costs, hubs = self.store.costs(sets), self.hub_numbers(sets)
        problem, valid = self._problem, self._valid(sets)
        past = self.least[0] - self.least
        room = np.full((len(self._unstable), self._K + 1), np.inf)
        g_all, d_all = room.copy(), room
        g_all[: len(g)], d_all[: len(d)] = g, d
        starts = self._fits(sets, problem.fingers.start, 0)
        ends = self._fits(sets, problem.fingers.goal, self._K)
        results = []
        for known in (False, True):
            into = g_all[hubs].min(axis=1) if known else np.broadcast_to(past, valid.shape)
            out = d_all[hubs].min(axis=1) if known else np.broadcast_to(self.least, valid.shape)
            into = np.where(valid, self._X + into, np.inf)
            out = np.where(valid, self._X + out, np.inf)
            into[starts & valid[:, 0], 0] = 0.0
            out[ends & valid[:, -1], -1] = 0.0
            run = into[:, 0].copy()
            best = run + out[:, 0]
            for v in range(1, self._K + 1):
                run = np.minimum(run + costs[:, v - 1], into[:, v])
                best = np.minimum(best, run + out[:, v])
            results.append(best)
        return results[0], results[1]
