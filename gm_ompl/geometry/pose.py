"""Poses of the object and their velocities.

``Pose`` maps object coordinates to world coordinates (``T_world_object``); the object frame's
origin is the centre of mass.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from gm_ompl.arrays import Array, fix, unit


def rotation_about(axis: ArrayLike, angle: float) -> Array:
    """Return the 3x3 rotation by ``angle`` [rad] about ``axis`` (Rodrigues' formula)."""
    by = _turning(unit(axis)).T
    rotation: Array = np.eye(3) + np.sin(angle) * by + (1.0 - np.cos(angle)) * (by @ by)
    return rotation


@dataclass(frozen=True, eq=False)
class Pose:
    """Where the object is: ``p_world = rotation @ p_object + position``.

    Attributes:
        rotation: (3, 3), proper orthogonal, object to world.
        position: (3,), the centre of mass in the world frame.
    """

    rotation: Array
    position: Array

    def __post_init__(self) -> None:
        fix(self, rotation=(3, 3), position=(3,))

    @classmethod
    def from_yaw(cls, position: ArrayLike, yaw: float = 0.0) -> Pose:
        """Return the pose at ``position``, turned by ``yaw`` [rad] about the world's z axis."""
        return cls(rotation_about([0.0, 0.0, 1.0], yaw), np.asarray(position, dtype=np.float64))

    @classmethod
    def from_quaternion(cls, position: ArrayLike, quaternion: ArrayLike) -> Pose:
        """Return the pose with the given position and quaternion (w, x, y, z), normalised here."""
        w, x, y, z = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
        rotation = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return cls(np.array(rotation), np.asarray(position, dtype=np.float64))

    @cached_property
    def key(self) -> bytes:
        """Equal where two poses are the same in every bit: a memo's key."""
        return self.rotation.tobytes() + self.position.tobytes()

    def apply(self, points: Array) -> Array:
        """Map points (n, 3) or (3,) from the object frame to the world frame."""
        mapped: Array = points @ self.rotation.T + self.position
        return mapped

    def to_object(self, points: Array) -> Array:
        """Map points (n, 3) or (3,) from the world frame to the object frame."""
        mapped: Array = (points - self.position) @ self.rotation
        return mapped

    def turned(self, pivot: ArrayLike, axis: ArrayLike, angle: float) -> Pose:
        """Return this pose after a rotation by ``angle`` [rad] about a line in the world."""
        turn = rotation_about(axis, angle)
        centre = np.asarray(pivot, dtype=np.float64)
        return Pose(turn @ self.rotation, turn @ (self.position - centre) + centre)

    def quaternion(self) -> Array:
        """Return the unit quaternion (w, x, y, z) with w >= 0, shape (4,)."""
        r = self.rotation
        # The largest of the four squared components divides the others: no cancellation.
        squares = np.array([
            1.0 + r[0, 0] + r[1, 1] + r[2, 2],
            1.0 + r[0, 0] - r[1, 1] - r[2, 2],
            1.0 - r[0, 0] + r[1, 1] - r[2, 2],
            1.0 - r[0, 0] - r[1, 1] + r[2, 2],
        ])  # fmt: skip
        k = int(np.argmax(squares))
        rows = np.array([
            [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], squares[1], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[1, 0] + r[0, 1], squares[2], r[2, 1] + r[1, 2]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], squares[3]],
        ])  # fmt: skip
        q: Array = rows[k] / np.linalg.norm(rows[k])
        return -q if q[0] < 0 else q


@dataclass(frozen=True, eq=False)
class Twist:
    """Velocity of the object per unit of motion, world frame, taken at the centre of mass.

    Attributes:
        linear: (3,), velocity of the centre of mass.
        angular: (3,), angular velocity [rad per unit of motion].
    """

    linear: Array
    angular: Array

    def __post_init__(self) -> None:
        fix(self, linear=(3,), angular=(3,))

    @cached_property
    def direction(self) -> tuple[float, ...]:
        """The six components, the greatest scaled to 1: equal for equal motions of any speed."""
        values = (*self.linear.tolist(), *self.angular.tolist())
        greatest = max(map(abs, values)) or 1.0
        return tuple(value / greatest + 0.0 for value in values)  # no negative zeros

    def at(self, arms: Array) -> Array:
        """Return velocities (n, 3), world frame, of points at ``arms`` (n, 3) from the centre.

        The arms are world-frame vectors from the centre of mass to the points.
        """
        velocities: Array = self.linear + arms @ self._turn
        return velocities

    @cached_property
    def _turn(self) -> Array:
        return _turning(self.angular)

    def fastest(self, arms: Array) -> float:
        """Return the greatest speed of points at ``arms`` (n, 3)."""
        if not self.angular.any():
            return float(np.sqrt(self.linear @ self.linear))
        velocities = self.at(arms)
        return float(np.sqrt(np.einsum("ij,ij->i", velocities, velocities).max()))


def _turning(angular: Array) -> Array:
    """Return the (3, 3) matrix that takes an arm r, as a row, to w x r."""
    x, y, z = angular.tolist()
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
