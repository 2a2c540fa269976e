"""From a set that nearly holds along a way to one that does: no finger has to be regrasped.

Regrasps are dear, and sets that spare them may be few: no table of points need have one. But the
least z along a way tells how near a set comes, and grows as its fingers are moved a little.
"""

from __future__ import annotations

import math
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.holds.spots import PlacedPlan
from gm_ompl.motion.object_graph import Way
from gm_ompl.sampling.drawing import drawn
from gm_ompl.sampling.lane_store import LaneStore, SetDraw
from gm_ompl.sampling.near import FIRST_REACH, SETS, Hand, Near, hand_of
from gm_ompl.sampling.placing import Placing
from gm_ompl.sampling.route import Route

POINTS: Final = 400
"""Points of the table that it begins with, about."""

DRAWN: Final = 1000
"""Sets that are looked at for one to begin with."""

NEAREST: Final = 1e-3
"""How near points come, in half sizes of the face."""


@final
class Climb:
    """A set whose fingers are moved so that its least z along a way grows.

    Args:
        placing: makes problems of few placements.
        way: the object's.
        rng: the source of randomness.

    Attributes:
        plan: with a set that holds along the whole way; None before there is one.
        over: whether it came to its end, with a plan or without one.
    """

    def __init__(self, placing: Placing, way: Way, rng: np.random.Generator) -> None:
        self._placing, self._way, self._rng = placing, way, rng
        self._order = [(k, p) for k, arc in enumerate(way.arcs) for p in range(arc.parts)]
        rng.shuffle(self._order)
        self._hand: Hand | None = None
        self._least, self._reach = 0.0, FIRST_REACH
        self.plan: PlacedPlan | None = None

    @property
    def over(self) -> bool:
        """Whether it came to its end, with a plan or without one."""
        return self.plan is not None or self._reach < NEAREST

    def step(self) -> None:
        """Look for a set to begin with, or try those around the present one."""
        if self._hand is None:
            self._begin()
            return
        near = Near.around(self._placing, [self._hand], self._reach, self._rng)
        judge = near.judge(self._placing)
        try:
            sets = near.sets(self._placing, judge, SETS, self._rng)
            if not self._consider(judge, Route(judge, self._way), sets):
                self._reach /= 2.0
        finally:
            self._placing.done(judge)

    def _begin(self) -> None:
        """Look for a set that holds nearly, among random ones; without one it is over."""
        judge = self._placing.judge(drawn(self._placing.spots, POINTS, self._rng))
        try:
            hand, draw = judge.problem.fingers, SetDraw(judge.problem, judge, 0.0, 1.0)
            route = Route(judge, self._way)
            allowed = restricted(restricted(tuple(_free(route)), hand.start), hand.goal)
            if not self._consider(judge, route, draw.draw(DRAWN, allowed, self._rng)):
                self._reach = 0.0
        finally:
            self._placing.done(judge)

    def _consider(self, judge: Judge, route: Route, sets: IntArray) -> bool:
        """Take the set whose least z is largest, if it is larger than before; whether it is."""
        problem, last, free = judge.problem, route.strides, _free(route)
        sets = sets[free[np.arange(sets.shape[1]), sets].all(axis=1)]
        least = self._least_margins(judge, route, sets)
        if not len(sets) or not least.max() > self._least:
            return False
        best = int(np.argmax(least))
        lane = tuple(sets[best].tolist())
        table, self._least = problem.fingers.placements, float(least[best])
        self._hand = hand_of(self._placing.spots, table, lane)
        store = LaneStore(judge, PlacementSets(problem.fingers.groups()), route)
        ends = all(store.free_at_end(lane, vertex) for vertex in (0, last))
        if self._least >= problem.mechanics.z_min and ends:
            moves = moves_of(judge, self._way, [(lane, 0, last)])
            self.plan = PlacedPlan(moves, table, math.fsum(move.cost for move in moves))
        return True

    def _least_margins(self, judge: Judge, route: Route, sets: IntArray) -> Array:
        """Return the least z of sets (L, n) along the way, (L,); not exactly where it is no more.

        What is least at the best set goes first next time: there most others fail.
        """
        least, left = np.full(len(sets), np.inf), np.arange(len(sets))
        backend = judge.backend
        assert isinstance(backend, KernelBackend), "the scenario asks for it"
        margins = np.empty((len(self._order), len(sets)))
        for k, (stride, part) in enumerate(self._order):
            states = np.full(len(left), route.table.state(stride, part))
            margins[k, left] = [d.z for d in backend.decide_many(states, sets[left])]
            least[left] = np.minimum(least[left], margins[k, left])
            left = left[least[left] > self._least]
        if len(left):
            ranked = np.argsort(margins[:, left[np.argmax(least[left])]], kind="stable")
            self._order = [self._order[k] for k in ranked.tolist()]
        return least


def _free(route: Route) -> BoolArray:
    """Return where fingertips are free all along a way, (n, placements)."""
    tables = route.table.tables
    return np.asarray(tables.node_free.all(axis=2) & tables.free.all(axis=2))
