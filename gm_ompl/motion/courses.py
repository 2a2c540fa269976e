"""Many screws at once, as compiled code reads them."""

from __future__ import annotations

from typing import NamedTuple

from gm_ompl.arrays import Array, IntArray


class Courses(NamedTuple):
    """Screws, one per row, and how they are divided.

    Attributes:
        rotations: (m, 3, 3), of the object where each begins.
        positions: (m, 3), its centre of mass there.
        by: (m, 3), the whole translation; of a rotation, a point of its line, world frame.
        axes: (m, 3), unit, the lines' directions; of a translation any.
        angles: (m,), the whole rotation [rad]; 0: a translation.
        ends_rotations: (m, 3, 3), at the node that each leads to: a little off its own end.
        ends_positions: (m, 3), likewise.
        parts: (m,), segments.
        pitches: (m,), how long a segment is, as ``Arc.pitch`` has it; 1 / parts: all are equal.
    """

    rotations: Array
    positions: Array
    by: Array
    axes: Array
    angles: Array
    ends_rotations: Array
    ends_positions: Array
    parts: IntArray
    pitches: Array

    def some(self, rows: slice | IntArray) -> Courses:
        """Return some of them."""
        return Courses._make(column[rows] for column in self)
