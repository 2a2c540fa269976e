"""Cuts on z as tables over cells of placements, compiled.

A cell is a rectangle on a face, and a finger's columns are affine in the point of contact there.
So T_i(g) = f_max max(0, max_k b_ik(g) . y) of a cut (``cuts``) is convex in g: over a cell it is
largest at a corner, and

    b_ik . y = a + u p + v r,  max over the cell = a + u p0 + v r0 + |u| half_p + |v| half_r.

With these T the same inequality bounds z for every set of points of a product of cells.
"""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.certificate import reach
from gm_ompl.mechanics.cuts import BLOCK, CutTables

BLOCKS: Final = 6
"""Blocks of cuts kept per contact state; then the oldest cut goes."""


class CellBoxes(NamedTuple):
    """Cells as compiled code reads them, in coordinates of their faces.

    Attributes:
        sides: (cells, 4), the centre's coordinates and half the lengths of the sides.
        faces: (cells,), the face of each.
    """

    sides: Array
    faces: IntArray


@compiled
def write_terms(edges: Array, boxes: CellBoxes, first: int, last: int, terms: Array) -> None:
    """Write T / h_P(y) of some cuts for cells ``first`` to ``last``.

    Args:
        edges: (blocks, kinds, F, s, 3, BLOCK), b . y f_max / h_P(y) of each column on each face:
            its constant and its slopes.
        boxes: the cells.
        first: the first cell.
        last: one past the last cell.
        terms: output (blocks, kinds, cells, BLOCK).
    """
    kinds, s, best, sides = edges.shape[1], edges.shape[3], np.empty(BLOCK), boxes.sides
    for b in range(edges.shape[0]):
        for k in range(kinds):
            for g in range(first, last):
                p, r, wide, high = sides[g, 0], sides[g, 1], sides[g, 2], sides[g, 3]
                best[:] = 0.0
                for j in range(s):
                    column = edges[b, k, boxes.faces[g], j]
                    for e in range(BLOCK):
                        u, v = column[1, e], column[2, e]
                        most = column[0, e] + u * p + v * r + abs(u) * wide + abs(v) * high
                        best[e] = max(best[e], most)
                for e in range(BLOCK):
                    terms[b, k, g, e] = best[e]


@final
class CellCuts:
    """The cuts of all contact states over cells that become more; see ``cuts.CutPool``.

    Args:
        columns: (n, F, s, 3, 6), the fingers' columns on each face: constant and slopes.
        f_max: (n,), over force_scale.
        directions: (76, 6), the l_i.

    Attributes:
        version: grows with every cut.
        cells: number of cells.
    """

    def __init__(self, columns: Array, f_max: Array, directions: Array) -> None:
        n = len(f_max)
        first = [
            next(
                j for j in range(i + 1)
                if f_max[i] == f_max[j] and np.array_equal(columns[i], columns[j])
            )
            for i in range(n)
        ]  # fmt: skip
        distinct = sorted(set(first))
        kinds = np.array([distinct.index(i) for i in first], dtype=np.int64)
        self._columns, self._f_max, self._L = columns[distinct], f_max[distinct], directions
        self._edges = np.zeros((16, *self._columns.shape[:4], BLOCK))
        self._tables = CutTables(
            np.zeros((0, BLOCKS), dtype=np.int64),
            np.zeros(0, dtype=np.int64),
            np.full((16, BLOCK), np.inf),
            np.zeros((16, len(distinct), 0, BLOCK)),
            kinds,
        )
        self._boxes, self.cells = CellBoxes(np.empty((0, 4)), np.empty(0, dtype=np.int64)), 0
        self._added: dict[int, int] = {}
        self._blocks = self.version = 0

    @property
    def tables(self) -> CutTables:
        """The cuts; replaced by larger tables when full."""
        return self._tables

    def of(self, fingers: list[int]) -> CutTables:
        """Return the cuts for some of the fingers alone: the others exert no force."""
        return self._tables._replace(kinds=self._tables.kinds[fingers])

    def widen(self, boxes: CellBoxes, cells: int) -> None:
        """Take more cells in: the first ``cells`` of ``boxes``, those known before among them."""
        terms = self._tables.terms
        if len(boxes.sides) > terms.shape[2]:
            wider = np.zeros((*terms.shape[:2], len(boxes.sides), BLOCK))
            wider[:, :, : terms.shape[2]] = terms
            self._tables = self._tables._replace(terms=wider)
        used = slice(0, self._blocks)
        write_terms(self._edges[used], boxes, self.cells, cells, self._tables.terms[used])
        self._boxes, self.cells = boxes, cells

    def reserve(self, states: int) -> None:
        """Make room for contact states up to number ``states`` - 1."""
        members, counts = self._tables.members, self._tables.counts
        more = states - len(counts)
        if more > 0:
            rows = np.zeros((more, members.shape[1]), dtype=np.int64)
            self._tables = self._tables._replace(
                members=np.concatenate([members, rows]),
                counts=np.concatenate([counts, np.zeros(more, dtype=np.int64)]),
            )

    def add(self, state: int, q: Array, y: Array) -> None:
        """Add the cut of ``y`` (6,), in the polar of the state's cone, under the load ``q``.

        A ``y`` that bounds nothing is left out.
        """
        h = reach(self._L, y)
        if not h > 0.0:
            return
        self.reserve(state + 1)
        block, place = self._place(state)
        self._tables.constants[block, place] = float(q @ y) / h
        slopes = self._columns @ (y / h)
        self._edges[block, ..., place] = slopes * self._f_max[:, None, None, None]
        one = slice(block, block + 1)
        write_terms(self._edges[one], self._boxes, 0, self.cells, self._tables.terms[one])
        self.version += 1

    def _place(self, state: int) -> tuple[int, int]:
        """Return where the next cut of a state goes: its oldest one's place, if it has so many."""
        added = self._added.get(state, 0)
        self._added[state] = added + 1
        row, place = divmod(added % (BLOCKS * BLOCK), BLOCK)
        if added < BLOCKS * BLOCK:
            if place == 0:
                self._tables.members[state, row] = self._free_block()
            self._tables.counts[state] = added + 1
        return int(self._tables.members[state, row]), place

    def _free_block(self) -> int:
        constants, terms = self._tables.constants, self._tables.terms
        if self._blocks == len(constants):
            self._tables = self._tables._replace(
                constants=np.concatenate([constants, np.full_like(constants, np.inf)]),
                terms=np.concatenate([terms, np.zeros_like(terms)]),
            )
            self._edges = np.concatenate([self._edges, np.zeros_like(self._edges)])
        self._blocks += 1
        return self._blocks - 1
