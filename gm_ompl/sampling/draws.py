"""Random sets of placements, leaning to placements that got far."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.problem import Problem


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
        return self._fitting(sets)

    def _fitting(self, sets: IntArray) -> IntArray:
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
