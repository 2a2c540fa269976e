"""Cuts on z as tables over placements, compiled.

A wrench y in the polar of the environment's cone bounds z at that contact state for *all* sets of
placements and all modes:

    z <= c + sum_i T_i(g_i),   c = q . y,   T_i(g) = f_max,i max(0, max_k b_ik(g) . y),

everything over h_P(y) = max_i l_i . y. Every mode decision leaves one; one addition per finger
then refutes most other sets.
"""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

PER_STATE = 128
"""Cuts kept per contact state; then the oldest goes."""


@compiled
def write_cut(
    q: Array, y: Array, L: Array, columns: Array, f_max: Array, alike: IntArray, terms: Array
) -> float:
    """Write T_i(g) / h_P(y), (n, P), for all fingers and placements; return c / h_P(y).

    Args:
        q: (6,), the load.
        y: (6,).
        L: (76, 6), the directions.
        columns: (n, s, 6, P), the fingers' columns for unit normal force.
        f_max: (n,).
        alike: (n,), per finger the first one with the same columns and f_max.
        terms: output.

    Returns:
        NaN where y is no cut: h_P(y) is not positive.
    """
    n, s, P = columns.shape[0], columns.shape[1], columns.shape[3]
    reach, constant = 0.0, 0.0
    for i in range(len(L)):
        dot = 0.0
        for t in range(6):
            dot += L[i, t] * y[t]
        reach = max(reach, dot)
    if not reach > 0.0:
        return np.nan
    for t in range(6):
        constant += q[t] * y[t]
    y0, y1, y2, y3, y4, y5 = y[0], y[1], y[2], y[3], y[4], y[5]
    for i in range(n):
        if alike[i] < i:
            for g in range(P):
                terms[i, g] = terms[alike[i], g]
            continue
        for g in range(P):
            terms[i, g] = 0.0
        for k in range(s):
            a = columns[i, k]
            # Innermost over placements, which lie side by side in memory.
            for g in range(P):
                dot = (a[0, g] * y0 + a[1, g] * y1 + a[2, g] * y2) + (
                    a[3, g] * y3 + a[4, g] * y4 + a[5, g] * y5
                )
                terms[i, g] = max(terms[i, g], dot)
        for g in range(P):
            terms[i, g] *= f_max[i] / reach
    return constant / reach


class CutTables(NamedTuple):
    """The cuts of all contact states, as compiled code reads them.

    Attributes:
        members: (states, PER_STATE), per contact state the numbers of its cuts.
        counts: (states,), how many there are.
        constants: (cuts,), c over h_P(y).
        terms: (cuts, n, P), T over h_P(y).
    """

    members: IntArray
    counts: IntArray
    constants: Array
    terms: Array


@compiled
def state_bound(state: int, rows: IntArray, cuts: CutTables) -> float:
    """Return the least bound on z that a state's cuts give for one set of placements."""
    best = np.inf
    for m in range(cuts.counts[state]):
        j = cuts.members[state, m]
        z = cuts.constants[j]
        for i in range(len(rows)):
            z += cuts.terms[j, i, rows[i]]
        best = min(best, z)
    return max(best, 0.0)


@final
class CutPool:
    """The cuts of all contact states, growing.

    Args:
        tips: (n, P, s, 6), the fingers' columns for unit normal force at every placement.
        f_max: (n,).
        directions: (N, 6), the l_i.

    Attributes:
        tables: the cuts; replaced by larger tables when full.
        version: grows with every cut.
    """

    def __init__(self, tips: Array, f_max: Array, directions: Array) -> None:
        self._shape, self._f_max, self._directions = tips.shape[:2], f_max, directions
        self._columns = np.ascontiguousarray(tips.transpose(0, 2, 3, 1))
        self._alike = np.array([
            next(j for j in range(i + 1) if self._same(i, j)) for i in range(len(f_max))
        ], dtype=np.int64)  # fmt: skip
        self.clear()

    def clear(self) -> None:
        """Drop all cuts."""
        self.tables = CutTables(
            np.zeros((16, PER_STATE), dtype=np.int64),
            np.zeros(16, dtype=np.int64),
            np.empty(64),
            np.empty((64, *self._shape)),
        )
        self._added: dict[int, int] = {}
        self._used = 0
        self.version = 0

    def reserve(self, states: int) -> None:
        """Make room for contact states up to number ``states`` - 1."""
        have = len(self.tables.counts)
        if states > have:
            more = max(states, 2 * have) - have
            rows = np.zeros((more, PER_STATE), dtype=np.int64)
            self.tables = self.tables._replace(
                members=np.concatenate([self.tables.members, rows]),
                counts=np.concatenate([self.tables.counts, np.zeros(more, dtype=np.int64)]),
            )

    def add(self, state: int, q: Array, y: Array) -> None:
        """Add the cut of ``y`` (6,), in the polar of the state's cone, under the load ``q``.

        Nothing is added where ``y`` bounds nothing (zero, say).
        """
        self.reserve(state + 1)
        added = self._added.get(state, 0)
        place = added % PER_STATE
        full = added >= PER_STATE
        slot = int(self.tables.members[state, place]) if full else self._free_slot()
        tables = self.tables
        constant = write_cut(
            q, y, self._directions, self._columns, self._f_max, self._alike, tables.terms[slot]
        )
        if math.isnan(constant):
            return
        if not full:
            self._used += 1
            tables.members[state, place] = slot
            tables.counts[state] = added + 1
        tables.constants[slot] = constant
        self._added[state] = added + 1
        self.version += 1

    def _same(self, i: int, j: int) -> bool:
        same = self._f_max[i] == self._f_max[j]
        return bool(same) and np.array_equal(self._columns[i], self._columns[j])

    def _free_slot(self) -> int:
        constants, terms = self.tables.constants, self.tables.terms
        if self._used == len(constants):
            self.tables = self.tables._replace(
                constants=np.concatenate([constants, np.empty_like(constants)]),
                terms=np.concatenate([terms, np.empty_like(terms)]),
            )
        return self._used

    def bound(self, state: int, rows: IntArray) -> float:
        """Return an upper bound on z (over force_scale) for all fingers at ``rows`` (n,)."""
        if state >= len(self.tables.counts):
            return float("inf")
        return float(state_bound(state, rows, self.tables))
