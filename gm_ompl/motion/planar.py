"""Planar motion: x, y and yaw at a fixed height."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array, read_only
from gm_ompl.caches import Memo
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.lattice import Lattice
from gm_ompl.motion.motion import POSE_BYTES, Motion
from gm_ompl.motion.straight import UPRIGHT, Straight, heading

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
        known = self._known.get((x, y, yaw))
        if known is None:
            known = self._known[x, y, yaw] = heading([x, y, self.height], yaw, self.attitude)
        return known

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Straight:
        """Return the straight motion from ``tail`` to ``head``, both [x, y, yaw]."""
        start, end = ((float(q[0]), float(q[1]), float(q[2])) for q in (tail, head))
        return Straight(start, end, self.height, self.attitude)

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
