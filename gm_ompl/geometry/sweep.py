"""A rigid motion as swept tests need it: a turn about a line and a drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, fix
from gm_ompl.geometry.pose import Pose, rotation_about


@dataclass(frozen=True, eq=False)
class Sweep:
    """Where the object goes while t runs from 0 to 1.

    At t it has turned from ``start`` by ``t * angle`` about the line and moved by ``t * drift``.

    Attributes:
        start: the pose at t = 0.
        pivot: (3,), a point of the line, world frame.
        axis: (3,), unit, its direction.
        angle: the whole turn [rad].
        drift: (3,), the whole translation, world frame.
    """

    start: Pose
    pivot: Array
    axis: Array
    angle: float
    drift: Array

    def __post_init__(self) -> None:
        fix(self, pivot=(3,), axis=(3,), drift=(3,))

    @property
    def keeps_level(self) -> bool:
        """Whether heights over the floor stay as they are: it turns and drifts in the plane."""
        x, y, _ = self.axis.tolist()
        return float(self.drift[2]) == 0.0 and (self.angle == 0.0 or x == y == 0.0)

    def pose(self, t: float) -> Pose:
        """Return the pose at ``t``."""
        turn = rotation_about(self.axis, t * self.angle)
        arm = self.start.position - self.pivot
        position = turn @ arm + self.pivot + t * self.drift
        return Pose(turn @ self.start.rotation, position)

    def arms(self, points: Array) -> Array:
        """Map points (n, 3), object frame, to their arms from the pivot at t = 0, world frame."""
        arms: Array = self.start.apply(points) - self.pivot
        return arms

    def moved(self, arms: Array, t: float) -> Array:
        """Return where points with ``arms`` (n, 3) are at ``t``, world frame."""
        places: Array = arms @ rotation_about(self.axis, t * self.angle).T
        places += self.pivot + t * self.drift
        return places

    def sagitta(self, arms: Array) -> float:
        """Return how far points with ``arms`` (n, 3) leave the chords of their ways at most."""
        if self.angle == 0.0 or not len(arms):
            return 0.0
        along = arms @ self.axis
        radius = np.sqrt(np.maximum((arms**2).sum(axis=1) - along**2, 0.0).max())
        half = abs(self.angle) / 2.0
        return float(radius * ((1.0 - np.cos(half)) if half < np.pi / 2 else 2.0))
