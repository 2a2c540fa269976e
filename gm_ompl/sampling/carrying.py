"""Hands for the object's way: sets of placements that hold along a leap, found as it is made.

A few sets stand for all: that some set holds makes a leap worth growing on; which sets carry the
object along the whole route, and where fingers are regrasped, lanes decide (``tree``).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.holds.goals import restricted
from gm_ompl.motion.arc import Moment
from gm_ompl.sampling.lane_store import SetDraw
from gm_ompl.sampling.screws import Screws, Stride
from gm_ompl.sampling.stride_states import StatesAlong, StrideStates

KEPT: Final = 12
"""Sets that go on from a pose at most."""

DRAWN: Final = 96
"""Sets drawn at random where those at hand do not hold."""

FRESH: Final = 48
"""Sets that are followed back to where fingers are regrasped."""

BACK: Final = 40
"""Strides that they are followed back at most."""

VAIN: Final = 400
"""Sets that failed at a contact state before it counts as one where nothing holds."""

NEIGHBOURS: Final = 48
"""Sets with one finger elsewhere that are tried."""


class Carried(NamedTuple):
    """How far hands carry the object along a leap.

    Attributes:
        strides: how many strides of it.
        sets: (m, n), sets that hold on the last of them.
        regrasps: regrasps on the way, about.
    """

    strides: int
    sets: IntArray
    regrasps: int


@final
class Carrying:
    """Finds sets that hold.

    Args:
        judge: answers about the problem.
        screws: poses by numbers.
        draw: draws sets, and learns.
        rng: the source of randomness.

    Attributes:
        states: what judging strides needs.
    """

    def __init__(
        self, judge: Judge, screws: Screws, draw: SetDraw, rng: np.random.Generator
    ) -> None:
        problem = judge.problem
        self._judge, self._screws, self._draw, self._rng = judge, screws, draw, rng
        self._z_min = problem.mechanics.z_min
        self._n = problem.fingers.count
        self.states = StrideStates(judge)
        self._failed: dict[int, int] = {}
        self._held: set[int] = set()

    def carry(
        self, before: Sequence[Stride], strides: Sequence[Stride], sets: IntArray | None
    ) -> Carried:
        """Return how far the object is carried along strides.

        Where sets fail, others are sought that hold there, regrasped at the last place before
        where the object rests, or held from the start.

        Args:
            before: the strides from the start to where these begin.
            strides: they follow each other.
            sets: (m, n), at hand where they begin; None: any.
        """
        whole, regrasps = [*before, *strides], 0
        place = len(before)
        while place < len(whole):
            found = None if sets is None else self.holding(whole[place], sets, KEPT)
            if found is None or not len(found):
                renewed = self._renewed(whole, place, sets)
                if renewed is None:
                    break
                found, regrasped = renewed
                regrasps += regrasped
            sets, place = found, place + 1
        none = np.zeros((0, self._n), dtype=np.int64)
        return Carried(place - len(before), none if sets is None else sets, regrasps)

    def _renewed(
        self, whole: Sequence[Stride], failing: int, sets: IntArray | None
    ) -> tuple[IntArray, bool] | None:
        """Return sets that hold where others fail, and whether a finger is regrasped for that."""
        fresh, last = self.fresh(whole[failing], sets), max(0, failing - BACK)
        for begin in range(failing, last - 1, -1):
            if begin == 0 and len(fresh):
                fresh = fresh[self._fits_start(fresh)]
            if not len(fresh):
                return None
            if begin == 0 or self._may_regrasp(whole[begin].tail, sets):
                return fresh[:KEPT], begin > 0
            fresh = self.holding(whole[begin - 1], fresh, FRESH)
        return None

    def _fits_start(self, sets: IntArray) -> BoolArray:
        given = self._judge.problem.fingers.start
        wanted = np.array([-1 if row is None else row for row in given])
        fits: BoolArray = ((sets == wanted) | (wanted < 0)).all(axis=1)
        return fits

    def fresh(self, stride: Stride, sets: IntArray | None) -> IntArray:
        """Return sets that hold on a stride, drawn near those at hand and at random."""
        none = np.zeros((0, self._n), dtype=np.int64)
        states = self.states.of(stride)
        if states is None or self._hopeless(states):
            return none
        allowed = states.free
        if sets is None:
            allowed = restricted(allowed, self._judge.problem.fingers.start)
        drawn = [] if sets is None else [self._neighbours(sets, states.free)]
        drawn.append(self._draw.draw(DRAWN, allowed, self._rng))
        tried = np.concatenate(drawn)
        found = self.holding(stride, tried, FRESH)
        if len(tried):
            shares = (tried[:, None] == found).all(axis=2).any(axis=1).astype(np.float64)
            self._draw.learn(tried, shares)
        return found

    def _neighbours(self, sets: IntArray, free: Sequence[BoolArray]) -> IntArray:
        """Return sets with one finger elsewhere."""
        many = self._rng.integers(len(sets), size=NEIGHBOURS)
        slots = self._rng.integers(self._n, size=NEIGHBOURS)
        new = sets[many].copy()
        for i in range(self._n):
            rows = np.flatnonzero(free[i])
            if len(rows):
                here = slots == i
                new[here, i] = self._rng.choice(rows, size=int(here.sum()))
        return self._draw.fitting(new)

    def _hopeless(self, states: StatesAlong) -> bool:
        return any(
            self._failed.get(state, 0) >= VAIN and state not in self._held
            for state in states.numbers
        )

    def holding(self, stride: Stride, sets: IntArray, most: int) -> IntArray:
        """Return those of some sets (m, n) that hold along a stride, so many at most."""
        states = self.states.of(stride)
        if states is None or not len(sets):
            return sets[:0]
        free = np.ones(len(sets), dtype=bool)
        for i in range(self._n):
            free &= states.free[i][sets[:, i]]
        left = sets[free]
        for state in dict.fromkeys(reversed(states.numbers)):
            if not len(left):
                break
            holds = self._decided(state, left)
            if holds.any():
                self._held.add(state)
            else:
                self._failed[state] = self._failed.get(state, 0) + len(left)
            left = left[holds]
        return left[:most]

    def _decided(self, state: int, sets: IntArray) -> BoolArray:
        backend = self._judge.backend
        fingers, rows = tuple(range(self._n)), [tuple(row) for row in sets.tolist()]
        holds = np.array([backend.bound(state, fingers, row) >= self._z_min for row in rows])
        open_ = np.flatnonzero(holds)
        if isinstance(backend, KernelBackend):
            numbers = np.full(len(open_), state, dtype=np.int64)
            answers = backend.decide_many(numbers, sets[open_], self._z_min)
        else:
            answers = [backend.decide(state, fingers, rows[k], self._z_min) for k in open_]
        holds[open_] = [answer.z >= self._z_min for answer in answers]
        return holds

    def _may_regrasp(self, place: int, sets: IntArray | None) -> bool:
        """Whether the object rests at a pose while some finger of some set is lifted."""
        if sets is None:
            return True
        state = None
        for row in sets[:3].tolist():
            for slot in range(self._n):
                hub = (*row[:slot], *row[slot + 1 :])
                if state is None:
                    state = self._judge.environment(Moment(self._screws.pose(place)))
                fingers = tuple(i for i in range(self._n) if i != slot)
                decision = self._judge.backend.decide(state, fingers, hub, self._z_min)
                if decision.z >= self._z_min:
                    return True
        return False
