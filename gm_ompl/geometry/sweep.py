"""A rigid motion as swept tests need it: a turn about a line and a drift; heights over planes.

A point's height over a plane at t is a + b cos(t angle) + c sin(t angle), plus t times another such
sum where the motion drifts. Without a drift, or without a turn, its least value has a closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray, cross, fix
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


@dataclass(frozen=True, eq=False)
class Waves:
    """Heights as functions of t, in arrays of any shape.

    Attributes:
        angle: the whole turn [rad].
        still: the three coefficients 1, cos, sin.
        rising: the three that t multiplies; None where all are zero.
    """

    angle: float
    still: tuple[Array, Array, Array]
    rising: tuple[Array, Array, Array] | None = None

    def rows(self, chosen: IntArray) -> Waves:
        """Return the chosen rows (first axis)."""
        still = _chosen(self.still, chosen)
        return Waves(self.angle, still, self.rising and _chosen(self.rising, chosen))

    def columns(self, chosen: IntArray) -> Waves:
        """Return the chosen columns (second axis)."""
        a, b, c = (part[:, chosen] for part in self.still)
        return Waves(self.angle, (a, b, c), self.rising)

    def __neg__(self) -> Waves:
        a, b, c = self.still
        if self.rising is None:
            return Waves(self.angle, (-a, -b, -c))
        d, e, f = self.rising
        return Waves(self.angle, (-a, -b, -c), (-d, -e, -f))

    def at(self, t: float) -> Array:
        """Return the heights at ``t``."""
        cos, sin = np.cos(t * self.angle), np.sin(t * self.angle)
        a, b, c = self.still
        heights: Array = a + cos * b + sin * c
        if self.rising is not None:
            d, e, f = self.rising
            heights = heights + t * (d + cos * e + sin * f)
        return heights

    def least(self, first: float, last: float) -> Array:
        """Return the heights' least values for t from ``first`` to ``last``, or a lower bound.

        Exact unless the motion turns and drifts at once.
        """
        ends = np.minimum(self.at(first), self.at(last))
        if self.angle == 0.0:
            return ends
        a, b, c = self.still
        swing = np.hypot(b, c)
        if self.rising is None:
            lowest = np.arctan2(-c, -b) - first * self.angle
            turned = abs(self.angle) * (last - first)
            inside = np.mod(lowest * np.sign(self.angle), 2.0 * np.pi) < turned
            return np.where(inside, np.minimum(a - swing, ends), ends)
        _, e, f = self.rising
        swell = np.hypot(e, f)
        bend = self.angle**2 * (swing + last * swell) + 2.0 * abs(self.angle) * swell
        return ends - bend * ((last - first) ** 2 / 8.0)


def _chosen(parts: tuple[Array, Array, Array], chosen: IntArray) -> tuple[Array, Array, Array]:
    a, b, c = (part[chosen] for part in parts)
    return a, b, c


def turned(axis: Array, moving: Array, fixed: Array) -> tuple[Array, Array, Array]:
    """Return the coefficients of (turned ``moving``) . ``fixed``, (f, m).

    Args:
        axis: (3,), unit, of the turn.
        moving: (m, 3), vectors that turn.
        fixed: (f, 3), vectors that do not.
    """
    still = (fixed @ axis)[:, None] * (moving @ axis)
    return still, fixed @ moving.T - still, fixed @ cross(axis, moving).T


def turned_each(axis: Array, moving: Array, fixed: Array) -> tuple[Array, Array, Array]:
    """Return the coefficients of (turned ``moving``) . ``fixed`` row by row, (m,)."""
    still = (fixed @ axis) * (moving @ axis)
    return (
        still,
        np.einsum("ij,ij->i", fixed, moving) - still,
        np.einsum("ij,ij->i", fixed, cross(axis, moving)),
    )


def heights(
    sweep: Sweep, arms: Array, normals: Array, offsets: Array, *, each: bool = False
) -> Waves:
    """Return the heights of moving points over fixed planes, (f, m).

    Args:
        sweep: how the points move.
        arms: (m, 3), the points, from the pivot at t = 0.
        normals: (f, 3), of the planes.
        offsets: (f,), of the planes.
        each: whether point k is over plane k alone: (m,).
    """
    a, b, c = (turned_each if each else turned)(sweep.axis, arms, normals)
    level, rates = normals @ sweep.pivot - offsets, normals @ sweep.drift
    if not each:
        level, rates = level[:, None], rates[:, None]
    still = np.zeros_like(rates)
    return Waves(sweep.angle, (a + level, b, c), (rates, still, still) if rates.any() else None)
