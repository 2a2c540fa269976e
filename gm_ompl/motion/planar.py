"""Planar motion: x, y and yaw at a fixed height; its arcs change all three linearly at once."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np

from gm_ompl.arrays import Array, read_only
from gm_ompl.caches import Memo
from gm_ompl.geometry.pose import Pose, Twist, rotation_about
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import POSE_BYTES, Arc, Motion
from gm_ompl.motion.lattice import Lattice
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
        ends: whether it is judged from end to end, as ``Arc`` has it.
    """

    tail: tuple[float, float, float]
    head: tuple[float, float, float]
    height: float
    attitude: Array = field(default_factory=lambda: UPRIGHT)
    ends: bool = False

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


FULL_TURN = 2.0 * math.pi

ON_GRID = 1e-6
"""A range that is a whole number of steps up to this many steps ends on the lattice."""


@final
class PlanarMotion(Motion):
    """The object moves in a horizontal plane and turns about the vertical.

    The coordinates are the centre of mass's x and y and the yaw [rad]; yaw has a period where
    its range is a full turn.

    Attributes:
        height: z of the centre of mass, world frame.
        attitude: (3, 3), how the object is turned at yaw 0, object to world.
    """

    def __init__(
        self,
        low: Sequence[float],
        high: Sequence[float],
        height: float,
        attitude: Array = UPRIGHT,
    ) -> None:
        self.names = ("x", "y", "yaw")
        self.low = (float(low[0]), float(low[1]), float(low[2]))
        self.high = (float(high[0]), float(high[1]), float(high[2]))
        whole = math.isclose(self.high[2] - self.low[2], FULL_TURN, rel_tol=1e-9)
        self.periods = (None, None, FULL_TURN if whole else None)
        self.breakpoints = ((), (), ())
        self.height = height
        self.attitude = read_only(attitude, (3, 3), "attitude")
        self._known = Memo[tuple[float, float, float], Pose](POSE_BYTES)

    def pose(self, q: Sequence[float] | Array) -> Pose:
        """Return the object's pose at ``q = [x, y, yaw]``; the latest are remembered."""
        x, y, yaw = float(q[0]), float(q[1]), float(q[2])
        return self._known.of((x, y, yaw), lambda: heading([x, y, self.height], yaw, self.attitude))

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Straight:
        """Return the straight motion from ``tail`` to ``head``, both [x, y, yaw]."""
        start, end = ((float(q[0]), float(q[1]), float(q[2])) for q in (tail, head))
        return Straight(start, end, self.height, self.attitude, self.ends)

    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:  # noqa: ARG002
        """Return the derivative of the pose at ``q`` in the direction ``dq`` (3,)."""
        return Twist(
            np.array([float(dq[0]), float(dq[1]), 0.0]), np.array([0.0, 0.0, float(dq[2])])
        )

    def wrap(self, q: Sequence[float]) -> tuple[float, ...]:
        """Return ``q`` with a periodic yaw brought into [low, low + period)."""
        x, y, yaw = (float(value) for value in q)
        period = self.periods[2]
        if period is not None and not self.low[2] <= yaw <= self.high[2]:
            yaw = self.low[2] + (yaw - self.low[2]) % period
        return (x, y, yaw)


def planar_lattice(motion: PlanarMotion, steps: Sequence[float]) -> Lattice:
    """Return the lattice low + k * step per coordinate, within the bounds.

    A periodic yaw has as many equal steps as fit a full turn best; the caller has checked that
    ``steps[2]`` divides it.
    """
    axes = []
    for low, high, step, period in zip(motion.low, motion.high, steps, motion.periods, strict=True):
        if period is None:
            count = math.floor((high - low) / step + ON_GRID) + 1
            values = low + step * np.arange(count)
        else:
            count = round(period / step)
            values = low + period * np.arange(count) / count
        axes.append(read_only(values, (None,), "axis"))
    return Lattice(tuple(axes), motion.periods)
