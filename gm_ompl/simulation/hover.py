"""Where a lifted finger stands off, and how it gets from one placement to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.problem import Problem
from gm_ompl.simulation.travel import Clearance, way

TOUCHING = 1e-6
"""Fingertips that touch something are clear of it, up to this [D], as in the plan's geometry."""

HALVINGS = 6
"""How often a height above a placement is halved where something is in the way."""

BEARINGS = 16
"""Directions in the surface in which a finger may leave where it cannot lift."""


@dataclass(frozen=True, eq=False)
class Hover:
    """Fingers about to land, or just lifted, while the object rests and others keep their places.

    Attributes:
        problem: the scenario.
        pose: where the object rests.
        points: (n, 3), the fingers' placements, object frame.
        normals: (n, 3), into the object.
        height: how far a finger stands off where it can.
    """

    problem: Problem
    pose: Pose
    points: Array
    normals: Array
    height: float

    def off(self, i: int, point: Array, normal: Array) -> Array:
        """Return (3,), from where finger ``i`` touches at ``point`` to where it stands off.

        It lifts along the normal, less high where something is in the way. Where it cannot lift at
        all it leaves along the surface, straight, until it is past the object: in a slot as wide
        as a fingertip there is no other way. Object frame.
        """
        radius = float(self.problem.fingers.radius[i])
        touching, clear = point - radius * normal, self.clearance(i, 0.0)
        for height in self.height / 2.0 ** np.arange(HALVINGS):
            if clear.free(self.pose.apply(touching - height * normal)[None])[0]:
                return np.asarray(-height * normal)
        ways = [self._along(i, touching, side) for side in _sideways(normal)]
        found = [side for side in ways if side is not None]
        wanted = np.asarray(-self.height * normal)
        return min(found, key=lambda side: float(np.linalg.norm(side)), default=wanted)

    def _along(self, i: int, touching: Array, side: Array) -> Array | None:
        """Return the way along unit ``side`` until finger ``i`` is past the object, if clear."""
        size, start = self.problem.body.diagonal, self.pose.apply(touching)
        alone = self.clearance(i, self.height / 2.0, object_alone=True)
        for length in np.arange(0.05, 1.5, 0.05) * size:
            end = self.pose.apply(touching + length * side)
            if alone.free(end[None])[0]:
                clear = self.clearance(i, -TOUCHING * size)
                return length * side if clear.line(start, end, self.height / 4.0) else None
        return None

    def way(self, i: int, start: Array, end: Array) -> Array | None:
        """Return the corners (k, 3) of a clear way between two places, world frame; None if none.

        The way keeps as much of a margin as it finds room for.
        """
        span = self.problem.body.diagonal + 4.0 * float(self.problem.fingers.radius.max())
        least = -TOUCHING * self.problem.body.diagonal
        for margin in (self.height / 2.0, self.height / 4.0, 0.0, least):
            corners = way(self.clearance(i, margin), start, end, span)
            if corners is not None:
                return corners
        return None

    def clearance(self, i: int, margin: float, *, object_alone: bool = False) -> Clearance:
        """Return where finger ``i`` may be while the others keep their placements."""
        others = [k for k in range(len(self.points)) if k != i and not object_alone]
        radii = self.problem.fingers.radius[others]
        out = self.points[others] - radii[:, None] * self.normals[others]
        return Clearance(
            self.problem, self.pose, i, self.pose.apply(out), radii, margin,
            object_alone=object_alone,
        )  # fmt: skip


def _sideways(normal: Array) -> Array:
    """Return (BEARINGS, 3), unit directions in the surface, evenly around."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, axis) / np.linalg.norm(np.cross(normal, axis))
    angle = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS
    around: Array = np.outer(np.cos(angle), first) + np.outer(
        np.sin(angle), np.cross(normal, first)
    )
    return around
