"""Many screws at once, as compiled code reads them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import UP, Screw, Slide


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


def is_course(step: GraphArc) -> bool:
    """Whether an arc can be a row of courses: a whole screw."""
    arc = step.arc
    return isinstance(arc, Screw) and (arc.first, arc.last) == (0.0, 1.0)


def courses(steps: Sequence[GraphArc], heads: Sequence[Pose]) -> Courses:
    """Return whole screws, and the poses of the nodes they lead to, as compiled code reads them."""
    m = len(steps)
    made = Courses(
        np.empty((m, 3, 3)), np.empty((m, 3)), np.empty((m, 3)), np.tile(UP, (m, 1)), np.zeros(m),
        np.empty((m, 3, 3)), np.empty((m, 3)), np.empty(m, dtype=np.int64), np.empty(m),
    )  # fmt: skip
    for k, (step, head) in enumerate(zip(steps, heads, strict=True)):
        arc, made.parts[k] = step.arc, step.parts
        assert isinstance(arc, Screw)
        made.rotations[k], made.positions[k] = arc.origin.rotation, arc.origin.position
        if isinstance(arc.whole, Slide):
            made.by[k] = arc.whole.by
        else:
            made.by[k], made.axes[k] = arc.whole.pivot, arc.whole.axis
            made.angles[k] = arc.whole.angle
        made.ends_rotations[k], made.ends_positions[k] = head.rotation, head.position
        made.pitches[k] = 1.0 / step.parts if arc.pitch is None else arc.pitch
    return made
