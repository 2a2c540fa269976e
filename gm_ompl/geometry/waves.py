"""Heights of points over planes while one of the two turns and drifts, and their least values.

A point's height over a plane at t is a + b cos(t angle) + c sin(t angle), plus t times another such
sum where the motion drifts. Without a drift, or without a turn, its least value has a closed form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray, cross


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
