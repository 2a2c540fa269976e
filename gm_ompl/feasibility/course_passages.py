"""What is free along many screws, and at the nodes they lead to: compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled
from gm_ompl.geometry.flat import summed
from gm_ompl.geometry.packed import Drive, Hulls, placed
from gm_ompl.geometry.swept import body_clear, tips_clear
from gm_ompl.motion.courses import Courses


class Crossing(NamedTuple):
    """What moves, and what is in its way.

    Attributes:
        body: the object, object frame.
        obstacles: world frame.
        floor: whether there is one.
        depth: how far the object may penetrate.
        centres: (F, P, 3), of fingertips of each radius at every placement, object frame.
        apart: (F, P), which of them do not penetrate the object.
        gaps: (F, 1 + k), how near they may come to the floor, and to each obstacle.
    """

    body: Hulls
    obstacles: Hulls
    floor: bool
    depth: float
    centres: Array
    apart: BoolArray
    gaps: Array


@compiled
def pass_along(
    courses: Courses, crossing: Crossing, object_free: BoolArray, free: BoolArray
) -> None:
    """Write whether the object (m,) and which fingertips (m, F, P) are free all along.

    Nodes at which screws end are part of them.
    """
    # Taken apart once: numba counts every use of every array of a tuple.
    rotations, positions, by, axes, angles, ends_rotations, ends_positions, _, _ = courses
    body, obstacles, floor, depth, centres, apart, gaps = crossing
    none, up, here = np.zeros(3), np.array([0.0, 0.0, 1.0]), np.empty(centres.shape[1:])
    for k in range(len(angles)):
        R, p, end = rotations[k], positions[k], ends_positions[k]
        motion, still = Drive(by[k], axes[k], angles[k], none), Drive(end, up, 0.0, none)
        if angles[k] == 0.0:
            motion = Drive(p, up, 0.0, by[k])
        object_free[k] = body_clear(placed(body, R, p), motion, obstacles, floor, depth)
        if object_free[k]:
            there = placed(body, ends_rotations[k], end)
            object_free[k] = body_clear(there, still, obstacles, floor, depth)
        for f in range(len(centres)):
            free[k, f] = apart[f] & object_free[k]
            if object_free[k]:
                _move(centres[f], R, p, here)
                tips_clear(here, motion, obstacles, floor, gaps[f], free[k, f])
                _move(centres[f], ends_rotations[k], end, here)
                tips_clear(here, still, obstacles, floor, gaps[f], free[k, f])


@compiled
def _move(points: Array, R: Array, p: Array, into: Array) -> None:
    """Write points (n, 3) at a pose (3, 3), (3,)."""
    for i in range(len(points)):
        for c in range(3):
            into[i, c] = summed(points[i], R[c]) + p[c]
