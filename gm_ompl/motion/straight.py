"""Straight arcs: x, y and yaw change linearly at once."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np

from gm_ompl.arrays import Array, read_only
from gm_ompl.geometry.pose import Pose, Twist, rotation_about
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.screw import UP

UPRIGHT = read_only(np.eye(3), (3, 3), "upright")
"""An object as its shape stands in its own coordinates."""


def heading(position: Sequence[float], yaw: float, attitude: Array = UPRIGHT) -> Pose:
    """Return the pose of an object turned like ``attitude`` (3, 3), and by ``yaw`` after that."""
    if np.array_equal(attitude, UPRIGHT):
        return Pose.from_yaw(position, yaw)
    return Pose(rotation_about(UP, yaw) @ attitude, np.array(position))


@final
@dataclass(frozen=True, eq=False)
class Straight(Arc):
    """A motion in a horizontal plane.

    Attributes:
        tail: x, y and yaw [rad] at t = 0.
        head: at t = 1.
        height: z of the centre of mass.
        attitude: (3, 3), how the object is turned at yaw 0, object to world.
    """

    tail: tuple[float, float, float]
    head: tuple[float, float, float]
    height: float
    attitude: Array = field(default_factory=lambda: UPRIGHT)

    def pose(self, t: float) -> Pose:
        """Return the pose at ``t``."""
        if t == 1.0:
            x, y, yaw = self.head
        else:
            x, y, yaw = (a + t * (b - a) for a, b in zip(self.tail, self.head, strict=True))
        return heading([x, y, self.height], yaw, self.attitude)

    def twist(self, t: float) -> Twist:  # noqa: ARG002 (the same throughout)
        """Return the derivative of the pose."""
        x, y, yaw = (b - a for a, b in zip(self.tail, self.head, strict=True))
        return Twist(np.array([x, y, 0.0]), np.array([0.0, 0.0, yaw]))

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        """A turn about the vertical through the centre of mass, and a drift."""
        x, y, yaw = (b - a for a, b in zip(self.tail, self.head, strict=True))
        return (Sweep(self.start, self.start.position, UP, yaw, np.array([x, y, 0.0])),)

    @property
    def key(self) -> Hashable:
        """Equal for the two ways between the same coordinates."""
        return frozenset((self.tail, self.head)), self.height
