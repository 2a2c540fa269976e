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
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.direct import direct
from gm_ompl.mechanics.stability import BALANCED

BLOCK = 8
"""Cuts of one contact state that lie side by side in memory: one cache line per placement."""

PER_STATE = 16 * BLOCK
"""Cuts kept per contact state; then the oldest goes."""

MOST_WAITING = 256
"""Cuts that may wait to be written: together they take half the time."""


class CutTables(NamedTuple):
    """The cuts of all contact states, as compiled code reads them.

    Attributes:
        members: (states, PER_STATE / BLOCK), per contact state the numbers of its blocks.
        counts: (states,), how many cuts there are.
        constants: (blocks, BLOCK), c over h_P(y); +inf where there is no cut.
        terms: (blocks, kinds, P, BLOCK), T over h_P(y).
        kinds: (n,), per finger its kind: fingers with the same columns and f_max share terms.
    """

    members: IntArray
    counts: IntArray
    constants: Array
    terms: Array
    kinds: IntArray


@inlined
def write_cut(
    q: Array, y: Array, L: Array, columns: Array, f_max: Array, at: int, terms: Array
) -> float:
    """Write T_i(g) / h_P(y) at place ``at`` of terms (kinds, P, BLOCK); return c / h_P(y)."""
    n, s, P = columns.shape[0], columns.shape[1], columns.shape[3]
    reach, constant = 0.0, 0.0
    for i in range(len(L)):
        dot = 0.0
        for t in range(6):
            dot += L[i, t] * y[t]
        reach = max(reach, dot)
    if not reach > 0.0:
        return np.inf
    for t in range(6):
        constant += q[t] * y[t]
    row = np.empty(P)
    y0, y1, y2, y3, y4, y5 = y[0], y[1], y[2], y[3], y[4], y[5]
    for i in range(n):
        for g in range(P):
            row[g] = 0.0
        for k in range(s):
            a = columns[i, k]
            # Innermost over placements, which lie side by side in memory.
            for g in range(P):
                dot = (a[0, g] * y0 + a[1, g] * y1 + a[2, g] * y2) + (
                    a[3, g] * y3 + a[4, g] * y4 + a[5, g] * y5
                )
                row[g] = max(row[g], dot)
        for g in range(P):
            terms[i, g, at] = row[g] * f_max[i] / reach
    return constant / reach


@compiled
def write_cuts(
    Q: Array, Y: Array, places: IntArray, L: Array, columns: Array, f_max: Array, cuts: CutTables
) -> None:
    """Write cuts: c / h_P(y), and T_i(g) / h_P(y) for all kinds of fingers and placements.

    Args:
        Q: (K, 6), the load of each.
        Y: (K, 6), y of each.
        places: (K, 2), block and place in it of each.
        L: (76, 6), the directions.
        columns: (kinds, s, 6, P), the fingers' columns for unit normal force.
        f_max: (kinds,).
        cuts: output: constants, +inf where y is no cut as h_P(y) is not positive, and terms.
    """
    constants, terms = cuts.constants, cuts.terms
    for k in range(len(places)):
        b, at = places[k, 0], places[k, 1]
        constants[b, at] = write_cut(Q[k], Y[k], L, columns, f_max, at, terms[b])


@lean
def state_bound(state: int, rows: IntArray, cuts: CutTables) -> float:
    """Return the least bound on z that a state's cuts give for one set of placements.

    It is negative where a cut proves that nothing balances the load: forces that do so but for
    BALANCED have a bound of -BALANCED at least, as h_P(y) >= |y|.
    """
    members, constants, terms, kinds = cuts.members, cuts.constants, cuts.terms, cuts.kinds
    best = np.inf
    for m in range((cuts.counts[state] + BLOCK - 1) // BLOCK):
        b = members[state, m]
        z0, z1, z2, z3 = constants[b, 0], constants[b, 1], constants[b, 2], constants[b, 3]
        z4, z5, z6, z7 = constants[b, 4], constants[b, 5], constants[b, 6], constants[b, 7]
        for i in range(len(rows)):
            k, g = kinds[i], rows[i]
            z0, z1 = z0 + terms[b, k, g, 0], z1 + terms[b, k, g, 1]
            z2, z3 = z2 + terms[b, k, g, 2], z3 + terms[b, k, g, 3]
            z4, z5 = z4 + terms[b, k, g, 4], z5 + terms[b, k, g, 5]
            z6, z7 = z6 + terms[b, k, g, 6], z7 + terms[b, k, g, 7]
        z0, z1, z2, z3 = min(z0, z4), min(z1, z5), min(z2, z6), min(z3, z7)
        best = min(best, min(min(z0, z1), min(z2, z3)))
    return best if best < -BALANCED else max(best, 0.0)


_state_bound = direct(state_bound)


@final
class CutPool:
    """The cuts of all contact states, growing.

    Args:
        tips: (n, P, s, 6), the fingers' columns for unit normal force at every placement.
        f_max: (n,).
        directions: (N, 6), the l_i.

    Attributes:
        version: grows with every cut.
    """

    def __init__(self, tips: Array, f_max: Array, directions: Array) -> None:
        n = len(f_max)
        first = [next(j for j in range(i + 1) if _alike(tips, f_max, i, j)) for i in range(n)]
        distinct = sorted(set(first))
        self._kinds = np.array([distinct.index(i) for i in first], dtype=np.int64)
        self._columns = np.ascontiguousarray(tips[distinct].transpose(0, 2, 3, 1))
        self._f_max, self._directions = f_max[distinct], directions
        self.clear()

    def clear(self) -> None:
        """Drop all cuts."""
        self._tables = CutTables(
            np.zeros((16, PER_STATE // BLOCK), dtype=np.int64),
            np.zeros(16, dtype=np.int64),
            np.empty((16, BLOCK)),
            np.empty((16, len(self._columns), self._columns.shape[3], BLOCK)),
            self._kinds,
        )
        self._added: dict[int, int] = {}
        self._waiting: list[tuple[int, Array, Array]] = []
        self._blocks = 0
        self.version = 0

    def reserve(self, states: int) -> None:
        """Make room for contact states up to number ``states`` - 1."""
        have = len(self._tables.counts)
        if states > have:
            more = max(states, 2 * have) - have
            rows = np.zeros((more, PER_STATE // BLOCK), dtype=np.int64)
            self._tables = self._tables._replace(
                members=np.concatenate([self._tables.members, rows]),
                counts=np.concatenate([self._tables.counts, np.zeros(more, dtype=np.int64)]),
            )

    def add(self, state: int, q: Array, y: Array) -> None:
        """Add the cut of ``y`` (6,), in the polar of the state's cone, under the load ``q``.

        It is written when ``tables`` are asked for, at the latest with the next hundreds. A ``y``
        of zero bounds nothing, and is left out.
        """
        self._waiting.append((state, q, y))
        self.version += 1
        if len(self._waiting) >= MOST_WAITING:
            self._write()

    @property
    def tables(self) -> CutTables:
        """The cuts; replaced by larger tables when full."""
        if self._waiting:
            self._write()
        return self._tables

    def _write(self) -> None:
        cuts = [cut for cut in self._waiting if cut[2].any()]
        self._waiting.clear()
        if not cuts:
            return
        states, Q, Y = zip(*cuts, strict=True)
        self.reserve(1 + max(states))
        places = np.array([self._place(state) for state in states])
        write_cuts(
            np.array(Q), np.array(Y), places, self._directions, self._columns, self._f_max,
            self._tables,
        )  # fmt: skip

    def _place(self, state: int) -> tuple[int, int]:
        """Return where the next cut of a state goes: its oldest one's place, if it has so many."""
        added = self._added.get(state, 0)
        self._added[state] = added + 1
        row, place = divmod(added % PER_STATE, BLOCK)
        if added < PER_STATE:
            if place == 0:
                self._tables.members[state, row] = self._free_block()
            self._tables.counts[state] = added + 1
        return int(self._tables.members[state, row]), place

    def _free_block(self) -> int:
        constants, terms = self._tables.constants, self._tables.terms
        if self._blocks == len(constants):
            self._tables = self._tables._replace(
                constants=np.concatenate([constants, np.empty_like(constants)]),
                terms=np.concatenate([terms, np.empty_like(terms)]),
            )
        block, self._blocks = self._blocks, self._blocks + 1
        self._tables.constants[block] = np.inf
        self._tables.terms[block] = 0.0
        return block

    def bound(self, state: int, rows: IntArray) -> float:
        """Return an upper bound on z (over force_scale) for all fingers at ``rows`` (n,)."""
        tables = self.tables
        if state >= len(tables.counts):
            return float("inf")
        return _state_bound(state, rows, tables)


def _alike(tips: Array, f_max: Array, i: int, j: int) -> bool:
    """Whether two fingers have the same columns and f_max."""
    return bool(f_max[i] == f_max[j]) and np.array_equal(tips[i], tips[j])
