"""Cuts on z as tables over placements, compiled.

A wrench y in the polar of the environment's cone bounds z at that contact state for *all* sets of
placements and all modes:

    z <= c + sum_i T_i(g_i),   c = q . y,   T_i(g) = f_max,i max(0, max_k b_ik(g) . y),

everything over h_P(y) = max_i l_i . y. Every mode decision leaves one; one addition per finger
then refutes most other sets.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

PER_STATE = 128
"""Cuts kept per contact state; then the oldest goes."""


@compiled
def tip_terms(columns: Array, f_max: Array, y: Array, terms: Array) -> None:
    """Write T_i(g) (n, P) for all fingers and placements, from columns (n, s, 6, P)."""
    n, s, P = columns.shape[0], columns.shape[1], columns.shape[3]
    dots = np.empty(P)
    for i in range(n):
        terms[i, :] = 0.0
        for k in range(s):
            dots[:] = 0.0
            # Innermost over placements, which lie side by side in memory.
            for t in range(6):
                for g in range(P):
                    dots[g] += columns[i, k, t, g] * y[t]
            for g in range(P):
                terms[i, g] = max(terms[i, g], dots[g])
        for g in range(P):
            terms[i, g] *= f_max[i]


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
        """Add the cut of ``y`` (6,), in the polar of the state's cone, under the load ``q``."""
        reach = float((self._directions @ y).max())
        if not reach > 0.0:
            return
        self.reserve(state + 1)
        added = self._added.get(state, 0)
        place = added % PER_STATE
        slot = int(self.tables.members[state, place]) if added >= PER_STATE else self._new_slot()
        tables = self.tables
        tables.members[state, place] = slot
        tables.counts[state] = min(added + 1, PER_STATE)
        tables.constants[slot] = float(q @ y) / reach
        tip_terms(self._columns, self._f_max, y / reach, tables.terms[slot])
        self._added[state] = added + 1
        self.version += 1

    def _new_slot(self) -> int:
        constants, terms = self.tables.constants, self.tables.terms
        if self._used == len(constants):
            self.tables = self.tables._replace(
                constants=np.concatenate([constants, np.empty_like(constants)]),
                terms=np.concatenate([terms, np.empty_like(terms)]),
            )
        self._used += 1
        return self._used - 1

    def bound(self, state: int, rows: IntArray) -> float:
        """Return an upper bound on z (over force_scale) for all fingers at ``rows`` (n,)."""
        if state >= len(self.tables.counts):
            return float("inf")
        return float(state_bound(state, rows, self.tables))
