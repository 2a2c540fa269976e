"""Cells of placements: those of a face in a rectangle of its grid, or some of them.

They are halved on demand down to single placements.
"""

from __future__ import annotations

from typing import Final, Protocol, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.holds.rows import Tables
from gm_ompl.mechanics.cell_cuts import CellBoxes

FIRST: Final = 256
"""Cells that there is room for at first; then it doubles."""

ROUNDING: Final = 1e-12
"""By this much bounds of cells give way: a placement is not refuted by rounding."""


class CellTree(Protocol):
    """Cells that are made on demand, by their numbers.

    Attributes:
        boxes: the cells in coordinates of their faces.
        tables: as those of placements, by cells: what is best in a cell.
        faces: (F,), per face the cell of all of it.
        planes: (F, 3, 3), per face the point of coordinates (0, 0), and a unit of either.
    """

    boxes: CellBoxes
    tables: Tables
    faces: tuple[int, ...]
    planes: Array

    def __len__(self) -> int: ...

    def by_face(self, columns: Array) -> Array:
        """Return the fingers' columns (n, P, s, 6) on each face: (n, F, s, 3, 6)."""

    def point(self, row: int) -> int:
        """Return the cell of one placement alone."""

    def row(self, cell: int) -> int:
        """Return the placement of a cell that has no other, else -1."""

    def width(self, cell: int) -> float:
        """Return the length of a cell's longer side; 0 of a single placement."""

    def halves(self, cell: int) -> tuple[int, int]:
        """Return the two cells that a cell falls into."""

    def apart(self, i: int, cell: int, j: int, other: int, least: float) -> bool:
        """Whether somewhere in two cells fingertips i and j may be so far apart."""


@final
class Cells:
    """The cells that were made so far, by their numbers.

    A cell's corners are those of the rectangle of indices around its placements. What ``tables``
    say of it is what is best among its placements.

    Args:
        table: the placements.
        lanes: what all sets share along the arcs, by placements.
        centres: (n, P, 3), of the fingertips at every placement.

    Attributes:
        boxes: the cells in coordinates of their faces: the grid's indices.
        points: ``lanes``.
        tables: as ``lanes``, by cells.
        faces: (F,), per face the cell of all its placements.
        planes: (F, 3, 3), per face the point of indices (0, 0), and a step of either.
    """

    def __init__(self, table: PlacementTable, lanes: Tables, centres: Array) -> None:
        self._placements, self.points, self._centres = table, lanes, centres
        n, rows, P = len(centres), lanes.free.shape[2], lanes.states.shape[1]
        self.boxes = CellBoxes(np.empty((FIRST, 4)), np.zeros(FIRST, dtype=np.int64))
        self.tables = lanes._replace(
            free=np.empty((n, FIRST, rows), dtype=np.bool_),
            lengths=np.empty((n, FIRST, rows, P)),
            node_free=np.empty((n, FIRST, lanes.node_free.shape[2]), dtype=np.bool_),
            wanted=np.full(n, -1, dtype=np.int64),
            z_min=lanes.z_min * (1.0 - ROUNDING),
        )
        self._middles, self._arms = np.empty((n, FIRST, 3)), np.empty(FIRST)
        self._members: list[IntArray] = []
        self._halves: dict[int, tuple[int, int]] = {}
        self._known: dict[bytes, int] = {}
        used = np.unique(table.face)
        self._face = np.searchsorted(used, table.face)
        self.planes = np.array([self._plane(f) for f in range(len(used))])
        members = [np.flatnonzero(self._face == f) for f in range(len(used))]
        self.faces = tuple(self._make(rows) for rows in members)

    def __len__(self) -> int:
        return len(self._members)

    def _plane(self, face: int) -> Array:
        """Return (3, 3): the point of indices (0, 0) on a face, and a step of either."""
        rows = np.flatnonzero(self._face == face)
        return self.affine(rows, self._placements.points[rows])

    def affine(self, rows: IntArray, values: Array) -> Array:
        """Return (3, ..) with values (k, ..) at placements of a face = (1, i, j) @ it."""
        cells = self._placements.cell[rows]
        indices = np.column_stack([np.ones(len(rows)), cells])
        flat = np.linalg.lstsq(indices, values.reshape(len(rows), -1), rcond=None)[0]
        return np.asarray(flat.reshape(3, *values.shape[1:]))

    def by_face(self, columns: Array) -> Array:
        """Return the fingers' columns (n, P, s, 6) on each face: (n, F, s, 3, 6)."""
        n, _, s, _ = columns.shape
        sides = np.empty((n, len(self.faces), s, 3, 6))
        for f, cell in enumerate(self.faces):
            rows = self._members[cell]
            found = self.affine(rows, columns[:, rows].swapaxes(0, 1))
            sides[:, f] = found.transpose(1, 2, 0, 3)
        return sides

    def point(self, row: int) -> int:
        """Return the cell of one placement alone."""
        return self.of(np.array([row]))

    def members(self, cell: int) -> IntArray:
        """Return the placements of a cell."""
        return self._members[cell]

    def of(self, members: IntArray) -> int:
        """Return the cell of some placements of a face, in increasing order."""
        known = self._known.get(members.tobytes())
        return self._make(members) if known is None else known

    def row(self, cell: int) -> int:
        """Return the placement of a cell that has no other, else -1."""
        members = self._members[cell]
        return int(members[0]) if len(members) == 1 else -1

    def width(self, cell: int) -> float:
        """Return the length of a cell's longer side; 0 of a single placement."""
        return float(self._sides(cell).max())

    def _sides(self, cell: int) -> Array:
        """Return the lengths (2,) of a cell's sides."""
        steps = self.planes[self.boxes.faces[cell]][1:]
        lengths: Array = 2.0 * self.boxes.sides[cell, 2:] * np.linalg.norm(steps, axis=1)
        return lengths

    def halves(self, cell: int) -> tuple[int, int]:
        """Return the two cells that a cell of several placements falls into."""
        known = self._halves.get(cell)
        if known is None:
            axis = int(np.argmax(self._sides(cell)))
            members = self._members[cell]
            low = self._placements.cell[members, axis] <= self.boxes.sides[cell, axis]
            known = self._halves[cell] = self.of(members[low]), self.of(members[~low])
        return known

    def apart(self, i: int, cell: int, j: int, other: int, least: float) -> bool:
        """Whether somewhere in two cells fingertips i and j may be so far apart."""
        middle = self._middles[i, cell] - self._middles[j, other]
        return bool(np.linalg.norm(middle) + self._arms[cell] + self._arms[other] >= least)

    def _make(self, members: IntArray) -> int:
        """Make the cell of some placements of a face."""
        cell = len(self._members)
        if cell == len(self._arms):
            self._grow()
        self._members.append(members)
        self._known[members.tobytes()] = cell
        lanes, tables, face = self.points, self.tables, int(self._face[members[0]])
        indices = self._placements.cell[members]
        low, high = indices.min(axis=0), indices.max(axis=0)
        sides = self.boxes.sides[cell]
        sides[:2], sides[2:] = (low + high) / 2.0, (high - low) / 2.0
        self.boxes.faces[cell] = face
        tables.free[:, cell] = lanes.free[:, members].any(axis=1)
        tables.lengths[:, cell] = lanes.lengths[:, members].min(axis=1)
        tables.node_free[:, cell] = lanes.node_free[:, members].any(axis=1)
        plane = self.planes[face]
        middle, outward = plane[0] + sides[:2] @ plane[1:], self._centres[:, members[0]]
        self._middles[:, cell] = middle + outward - self._placements.points[members[0]]
        self._arms[cell] = (sides[2:] * np.linalg.norm(plane[1:], axis=1)).sum()
        if len(members) == 1:
            self._middles[:, cell], self._arms[cell] = outward, 0.0
        return cell

    def _grow(self) -> None:
        """Make room for twice as many cells."""
        self.boxes, self.tables = grown(self.boxes, self.tables)
        self._middles, self._arms = doubled(self._middles, 1), doubled(self._arms, 0)


def doubled(array: Array, axis: int) -> Array:
    """Return an array with room for twice as many along an axis."""
    return np.concatenate([array, np.empty_like(array)], axis=axis)


def grown(boxes: CellBoxes, tables: Tables) -> tuple[CellBoxes, Tables]:
    """Return boxes and tables of cells with room for twice as many."""
    return CellBoxes(doubled(boxes.sides, 0), np.tile(boxes.faces, 2)), tables._replace(
        free=np.tile(tables.free, (1, 2, 1)),
        lengths=doubled(tables.lengths, 1),
        node_free=np.tile(tables.node_free, (1, 2, 1)),
    )
