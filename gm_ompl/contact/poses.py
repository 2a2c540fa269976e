"""Poses numbered as they are found; the first one stands for all near it. Compiled."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.geometry.pose import Pose

SAME: Final = 1e-6
"""Poses are one up to this, relative to D and in radians."""

CELL: Final = 1e-3
"""Width of the cells in which poses are looked up, relative to D."""

OFFSET: Final = 0.3819660112501051
"""Where cells begin, in cells: on a lattice poses lie at whole multiples, not near a cell's end."""

WEIGHTS = np.array([0.61, -0.37, 0.83, 0.29, 0.71, -0.53, -0.47, 0.59, 0.43]) / 4.0
"""Tell rotations apart, no two alike; the sum changes by less than the angle turned."""

EQUAL: Final = 1e-9
"""Rotations and heights that differ by at most this are made equal in every bit: then what holds
for one is found again by the other."""

FEATURES: Final = 4
"""A pose is looked up by x, y, z and the weighted sum of its rotation."""

FIRST: Final = 256
"""Poses there is room for at first."""


class Book(NamedTuple):
    """Poses and where to find them.

    Attributes:
        rotations: (room, 3, 3).
        positions: (room, 3).
        attitudes: (room,), the number of each rotation.
        heights: (room,), the number of each height.
        turned: (room, 3, 3), the rotations, none twice.
        levels: (room,), the heights, none twice.
        places: (slots,), numbers of poses by the cells where they lie; -1: none.
        turns: (slots,), of rotations, likewise.
        floors: (slots,), of heights, likewise.
        counts: (3,), how many poses, rotations and heights there are.
    """

    rotations: Array
    positions: Array
    attitudes: IntArray
    heights: IntArray
    turned: Array
    levels: Array
    places: IntArray
    turns: IntArray
    floors: IntArray
    counts: IntArray


@final
class NumberedPoses:
    """Numbers poses.

    Args:
        diagonal: D.

    Attributes:
        book: them, as compiled code reads it; another one once it has grown.
    """

    def __init__(self, diagonal: float) -> None:
        self._D = diagonal
        self.book = _new_book(FIRST)
        self._poses: dict[int, Pose] = {}

    def reserve(self, more: int) -> Book:
        """Return the book with room for so many more poses."""
        wanted, room = self.book.counts[0] + more, len(self.book.positions)
        if wanted > room:
            grown = _new_book(max(2 * room, int(wanted)))
            copy_book(self.book, grown, self._D)
            self.book = grown
        return self.book

    def number(self, rotation: Array, position: Array) -> int:
        """Return the number of a pose."""
        return int(number(self.reserve(1), rotation.copy(), position.copy(), self._D))

    def pose(self, place: int) -> Pose:
        """Return the pose of a number."""
        known = self._poses.get(place)
        if known is None:
            known = Pose(self.book.rotations[place], self.book.positions[place])
            self._poses[place] = known
        return known


def _new_book(room: int) -> Book:
    slots = 1 << int(4 * room - 1).bit_length()
    none = np.full(slots, -1)
    turned = np.empty((room, 3, 3))
    return Book(
        turned.copy(), np.empty((room, 3)), np.empty(room, np.int64), np.empty(room, np.int64),
        turned, np.empty(room), none, none.copy(), none.copy(), np.zeros(3, np.int64),
    )  # fmt: skip


@compiled
def copy_book(old: Book, new: Book, D: float) -> None:
    """Write all poses of a book into a larger one, by the same numbers."""
    for k in range(old.counts[0]):
        number(new, old.rotations[k], old.positions[k], D)


@compiled
def number(book: Book, R: Array, p: Array, D: float) -> int:
    """Return the number of a pose: a new one on first sight."""
    features = np.empty(FEATURES)
    features[0] = p[0] / D / CELL + OFFSET
    features[1] = p[1] / D / CELL + OFFSET
    features[2] = p[2] / D / CELL + OFFSET
    features[3] = _weighted(R) / CELL + OFFSET
    near = SAME / CELL
    cells = np.empty(FEATURES, dtype=np.int64)
    for corner in range(1 << FEATURES):
        doubled = False
        for k in range(FEATURES):
            up = (corner >> k) & 1
            cells[k] = np.floor(features[k] + (near if up else -near))
            doubled |= up == 1 and cells[k] == np.floor(features[k] - near)
        if not doubled:
            slot = _hash(cells) & (len(book.places) - 1)
            while book.places[slot] >= 0:
                if _same(book, book.places[slot], R, p, D):
                    return int(book.places[slot])
                slot = (slot + 1) & (len(book.places) - 1)
    for k in range(FEATURES):
        cells[k] = np.floor(features[k])
    new = book.counts[0]
    book.counts[0] += 1
    _put(book.places, _hash(cells), new)
    attitude, height = _attitude(book, R), _height(book, p[2], D)
    book.attitudes[new], book.heights[new] = attitude, height
    for i in range(3):
        book.positions[new, i] = p[i]
        for j in range(3):
            book.rotations[new, i, j] = book.turned[attitude, i, j]
    book.positions[new, 2] = book.levels[height]
    return int(new)


@inlined
def _weighted(R: Array) -> float:
    total = 0.0
    for i in range(3):
        for j in range(3):
            total += R[i, j] * WEIGHTS[3 * i + j]
    return total


@compiled
def _hash(cells: IntArray) -> np.int64:
    mixed = np.uint64(1469598103934665603)
    for k in range(len(cells)):
        mixed = (mixed ^ np.uint64(cells[k])) * np.uint64(1099511628211)
        mixed ^= mixed >> np.uint64(29)
    return np.int64(mixed & np.uint64(0x7FFFFFFFFFFFFFFF))


@compiled
def _put(slots: IntArray, home: np.int64, value: int) -> None:
    slot = home & (len(slots) - 1)
    while slots[slot] >= 0:
        slot = (slot + 1) & (len(slots) - 1)
    slots[slot] = value


@inlined
def _same(book: Book, k: int, R: Array, p: Array, D: float) -> bool:
    """Whether a pose is pose ``k``."""
    # The norm of the difference of two rotations is sqrt(8) times the sine of half the angle.
    away = turn = 0.0
    for i in range(3):
        away += (p[i] - book.positions[k, i]) ** 2
        for j in range(3):
            turn += (R[i, j] - book.rotations[k, i, j]) ** 2
    return away <= (SAME * D) ** 2 and turn <= 2.0 * SAME * SAME


@inlined
def _attitude(book: Book, R: Array) -> int:
    """Return the number of a rotation."""
    feature, cell = _weighted(R) / (100.0 * EQUAL) + OFFSET, np.empty(1, dtype=np.int64)
    for side in (-0.01, 0.01):
        cell[0] = np.floor(feature + side)
        slot = _hash(cell) & (len(book.turns) - 1)
        while book.turns[slot] >= 0:
            if _alike(book.turned[book.turns[slot]], R):
                return int(book.turns[slot])
            slot = (slot + 1) & (len(book.turns) - 1)
    new = book.counts[1]
    book.counts[1] += 1
    for i in range(3):
        for j in range(3):
            book.turned[new, i, j] = R[i, j]
    cell[0] = np.floor(feature)
    _put(book.turns, _hash(cell), new)
    return int(new)


@inlined
def _alike(A: Array, B: Array) -> bool:
    """Whether two rotations differ by at most ``EQUAL``."""
    most = 0.0
    for i in range(3):
        for j in range(3):
            most = max(most, abs(A[i, j] - B[i, j]))
    return most <= EQUAL


@inlined
def _height(book: Book, z: float, D: float) -> int:
    """Return the number of a height."""
    feature, cell = z / (100.0 * EQUAL * D) + OFFSET, np.empty(1, dtype=np.int64)
    for side in (-0.01, 0.01):
        cell[0] = np.floor(feature + side)
        slot = _hash(cell) & (len(book.floors) - 1)
        while book.floors[slot] >= 0:
            if abs(book.levels[book.floors[slot]] - z) <= EQUAL * D:
                return int(book.floors[slot])
            slot = (slot + 1) & (len(book.floors) - 1)
    new = book.counts[2]
    book.counts[2] += 1
    book.levels[new] = z
    cell[0] = np.floor(feature)
    _put(book.floors, _hash(cell), new)
    return int(new)
