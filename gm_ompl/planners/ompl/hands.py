"""Hands that carry the object along strides of free motion, and what may take over from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import numpy as np

from gm_ompl.arrays import BoolArray, IntArray
from gm_ompl.holds.goals import Requirement, restricted
from gm_ompl.problem import Placements
from gm_ompl.sampling.carrying import KEPT, Carrying
from gm_ompl.sampling.free_model import FreeHybridModel
from gm_ompl.sampling.lane_store import SetDraw
from gm_ompl.sampling.screws import Stride
from gm_ompl.sampling.settings import ExploringSettings

REGRASPS: Final = 3
"""Sets that are taken up where others fail."""

DRAWN: Final = 128
"""Sets drawn at random for a stride."""

MANY: Final = 36
"""Of those that hold, how many are followed back to where the finger may be lifted."""

ELSEWHERE: Final = 256
"""Sets with one finger elsewhere that are tried on a stride."""


@final
class Hands:
    """Finds sets of placements that hold along strides.

    Args:
        model: judges strides and regrasps.
        rng: the source of randomness.
    """

    def __init__(self, model: FreeHybridModel, rng: np.random.Generator) -> None:
        self._model, self._rng = model, rng
        problem, judge, settings = model.problem, model.judge, ExploringSettings()
        self._draw = SetDraw(problem, judge, settings.placement_bias, settings.uniform_share)
        self._carrying = Carrying(judge, model.screws, self._draw, rng)

    def along(
        self, strides: Sequence[Stride], far: int, sets: IntArray, most: int = KEPT
    ) -> tuple[IntArray, int]:
        """Return the sets that hold the longest from a place on, and to which place.

        Args:
            strides: they follow each other.
            far: the place.
            sets: (m, n), at hand there.
            most: how many go on from a stride.
        """
        while far < len(strides):
            onwards = self._carrying.holding(strides[far], sets, most)
            if not len(onwards):
                break
            sets, far = onwards, far + 1
        return sets, far

    def fresh(self, strides: Sequence[Stride], wanted: Requirement) -> IntArray:
        """Return those of sets drawn at random that hold the longest, and learn from them.

        Args:
            strides: at least one; they follow each other.
            wanted: per finger, its placement, or None for any.
        """
        states, none = self._carrying.states.of(strides[0]), np.zeros((0, len(wanted)), np.int64)
        if states is None:
            return none
        drawn = self._draw.draw(DRAWN, restricted(states.free, wanted), self._rng)
        found, far = self.along(strides, 0, drawn, DRAWN)
        if not len(drawn) or not far:
            return none
        held = (drawn[:, None] == found).all(axis=2).any(axis=1)
        self._draw.learn(drawn, held.astype(np.float64))
        return found[:KEPT]

    def one_elsewhere(
        self, sets: IntArray, first: Placements, strides: Sequence[Stride]
    ) -> IntArray:
        """Return sets with one more finger elsewhere that hold on the last of some strides.

        Args:
            sets: (m, n), at hand until then.
            first: where the fingers were at the motion's beginning: none moves twice.
            strides: on the others the sets at hand hold.
        """
        states, known = self._carrying.states.of(strides[-1]), dict[Placements, tuple[int, int]]()
        if states is None:
            return sets[:0]
        for number, placements in enumerate(sets[:REGRASPS].tolist()):
            for finger, row in enumerate(placements):
                if row == first[finger]:
                    for other in self._rows(states.free[finger], placements, finger).tolist():
                        known.setdefault(elsewhere(placements, finger, other), (number, finger))
        if not known:
            return sets[:0]
        tried = self._rng.permutation(np.array(list(known)))[:ELSEWHERE]
        held = self._carrying.holding(strides[-1], tried, MANY)
        follow = [
            number
            for number, row in enumerate(held.tolist())
            if self._takes_over(strides, sets, *known[tuple(row)], tuple(row))
        ]
        return held[follow[:KEPT]]

    def _takes_over(
        self, strides: Sequence[Stride], sets: IntArray, number: int, finger: int,
        after: Placements,
    ) -> bool:  # fmt: skip
        """Whether a set can be regrasped from another before the last of some strides."""
        before, model = tuple(sets[number].tolist()), self._model
        for k in range(len(strides) - 1, -1, -1):
            q = model.coordinates(strides[k].tail)
            if model.rests(q, before, finger):
                return model.regrasp(q, before, finger, after[finger]) is not None
            if k and not len(self._carrying.holding(strides[k - 1], np.array([after]), 1)):
                return False
        return False

    def _rows(self, free: BoolArray, placements: Sequence[int], finger: int) -> IntArray:
        """Return where a finger may be beside the others."""
        rows, clear = free.copy(), self._model.judge.clear
        for other, row in enumerate(placements):
            rows[row] = False
            pair = clear[finger][other]
            if pair is not None and other != finger:
                rows &= pair[:, row]
        return np.flatnonzero(rows)


def elsewhere(placements: Placements, finger: int, row: int) -> Placements:
    """Return placements with one finger at another row."""
    return (*placements[:finger], row, *placements[finger + 1 :])
