"""How far fingertips go along many screws at once: |dq_finger i,j| of Eq. (9), in two factors.

In a segment of a translation each fingertip goes as far as the object; in one of a rotation, along
a chord that is as long as the fingertip is far from the line.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.motion.courses import Courses


def chords(courses: Courses, parts: int, *, ends: bool) -> Array:
    """Return how long segments are at arm 1, (m, parts): of a translation, as they are; 0 behind.

    Args:
        courses: screws.
        parts: the most segments that one of them has.
        ends: whether they are judged from end to end, as ``Arc.ends`` has it.
    """
    number, count = np.arange(parts + 1), courses.parts[:, None]
    bounds = number * courses.pitches[:, None]
    if ends:
        bounds = (number - 0.5) / np.maximum(count - 1, 1)
        bounds[:, 0] = 0.0
    bounds = np.where(number < count, bounds, 1.0)
    shares = np.diff(bounds, axis=1)
    ways = np.linalg.norm(courses.by, axis=1)[:, None]
    turns = courses.angles[:, None]
    found: Array = np.where(turns == 0.0, shares * ways, np.abs(2.0 * np.sin(shares * turns / 2.0)))
    return found


def lines(courses: Courses) -> Array:
    """Return a point and the unit direction of rotations' lines (m, 2, 3), as the object sees them.

    Zeros for translations.
    """
    found = np.stack([courses.by - courses.positions, courses.axes], axis=1) @ courses.rotations
    found[courses.angles == 0.0] = 0.0
    return np.ascontiguousarray(found)
