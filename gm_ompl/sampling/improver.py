"""Anytime improvement along one route: informed draws of sets, then a lazy search over them.

A set is drawn near the best plan (one finger elsewhere), near any other lane of the sample, or at
random; it joins the sample only where a lower bound on the cost of every plan through it is below
the best cost. As draws never exclude a set, the best plan of the route is approached.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Placements
from gm_ompl.sampling.draws import SetDraw
from gm_ompl.sampling.lane_sample import CHEAPER, LaneSample
from gm_ompl.sampling.lane_store import LaneStore, as_sets
from gm_ompl.sampling.settings import ImprovingSettings


@final
class Improver:
    """Improves plans along one route.

    Args:
        judge: answers about the problem.
        store: what is known along the route.
        draw: draws whole sets.
        settings: how.
        rng: the source of randomness.

    Attributes:
        sample: the lanes sampled.
        legs: the best plan along this route.
        steps: iterations so far.
    """

    def __init__(
        self,
        judge: Judge,
        store: LaneStore,
        draw: SetDraw,
        settings: ImprovingSettings,
        rng: np.random.Generator,
    ) -> None:
        self._judge, self._store, self._draw = judge, store, draw
        self._settings, self._rng = settings, rng
        self.sample = LaneSample(judge.problem, store)
        self.legs: list[Leg] = []
        self.steps = 0
        self._done: set[tuple[Placements, int]] = set()

    def seed(self, lanes: Sequence[Placements]) -> None:
        """Put lanes into the sample."""
        count = self._judge.problem.fingers.count
        self.sample.add(as_sets(lanes, count))

    def step(self, below: float, stop: Stop) -> list[Leg] | None:
        """Do one iteration; return the legs of a plan cheaper than ``below`` if one is found."""
        self.steps += 1
        if not self.sample.least[0] < below:
            return None
        self._join(self._candidates(), below)
        legs = self.sample.improve(below, self._settings.tries, stop)
        if legs is not None:
            self.legs = legs
            self._prune(self.sample.best)
        return legs

    def _candidates(self) -> IntArray:
        chance, settings = self._rng.random(), self._settings
        if chance < settings.best_neighbour_share and self.legs:
            lanes = [lane for lane, _, _ in self.legs]
            near = self._neighbours(lanes[int(self._rng.integers(len(lanes)))])
            if len(near):
                return near
        near_any = settings.best_neighbour_share + settings.neighbour_share
        if chance < near_any and len(self.sample):
            row = self.sample.sets[int(self._rng.integers(len(self.sample)))]
            near = self._neighbours(tuple(row.tolist()))
            if len(near):
                return near
        return self._anywhere()

    def _neighbours(self, lane: Placements) -> IntArray:
        """Return the sets that differ in one random finger, where it may be somewhere."""
        slot = int(self._rng.integers(len(lane)))
        if (lane, slot) in self._done:
            return as_sets((), len(lane))
        self._done.add((lane, slot))
        hub = self._store.lifted(lane, slot)
        return self._store.anywhere(hub)

    def _anywhere(self) -> IntArray:
        """Return random sets that are free at a random vertex."""
        route = self._store.route
        vertex = int(self._rng.integers(route.strides + 1))
        allowed = tuple(route.node_free[:, :, vertex])
        return self._draw.draw(self._settings.drawn, allowed, self._rng)

    def _join(self, sets: IntArray, below: float) -> None:
        """Add the most promising of ``sets`` to the sample, some others that may do by luck."""
        if not len(sets):
            return
        _, g = self.sample.so_far()
        _, d = self.sample.onward()
        bound, here = self.sample.bounds(sets, g, d)
        limit = below * CHEAPER
        hopeful = np.flatnonzero(bound < limit)
        if math.isfinite(limit):
            self._draw.learn(sets, (bound < limit).astype(float))
        jitter = self._rng.random(len(hopeful))
        # Those that improve on the plan at once by what is known, then the rest at random.
        at_once = np.where(here[hopeful] < limit, here[hopeful], np.inf)
        order = np.lexsort((jitter, at_once))
        self.sample.add(sets[hopeful[order][: self._settings.joining]])

    def _prune(self, best: float) -> None:
        """Drop lanes that no plan cheaper than ``best`` can use, and the worst if too many."""
        _, g = self.sample.so_far()
        _, d = self.sample.onward()
        bound, here = self.sample.bounds(self.sample.sets, g, d)
        keep = bound < best / CHEAPER
        if keep.sum() > self._settings.sample_limit:
            order = np.lexsort((bound, here))
            keep &= np.isin(np.arange(len(keep)), order[: self._settings.sample_limit])
        self.sample.keep(keep)
