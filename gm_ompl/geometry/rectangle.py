"""Rectangles around faces: what grids of placements cover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array

TIE = 1e-9
"""Relative difference below which two bounding rectangles have equal areas."""


@dataclass(frozen=True, eq=False)
class Rectangle:
    """A rectangle in space: ``centre`` +- ``half[k] * axes[k]``; shapes (3,), (2, 3), (2,)."""

    centre: Array
    axes: Array
    half: Array

    def cells(self, grid: tuple[int, int]) -> Array:
        """Return the cell centres (m1 * m2, 3) of a cell-centred grid, row-major."""
        first, second = ((np.arange(m) + 0.5) / m * 2.0 - 1.0 for m in grid)
        steps = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1).reshape(-1, 2)
        points: Array = self.centre + (steps * self.half) @ self.axes
        return points


def rectangle_around(corners: Array, normal: Array) -> Rectangle:
    """Return the least rectangle around a convex ring of corners (k, 3)."""
    edges = np.roll(corners, -1, axis=0) - corners
    candidates = []
    for edge in edges / np.linalg.norm(edges, axis=1, keepdims=True):
        axes = _oriented(np.stack([edge, np.cross(normal, edge)]))
        reach = (corners - corners[0]) @ axes.T
        low, high = reach.min(axis=0), reach.max(axis=0)
        centre = corners[0] + (low + high) / 2 @ axes
        candidates.append(Rectangle(centre, axes, (high - low) / 2))
    least = min(float(r.half.prod()) for r in candidates)
    tied = [r for r in candidates if r.half.prod() <= least * (1.0 + TIE)]
    return min(tied, key=lambda r: tuple(-np.round(np.abs(r.axes[0]), 9)))


def _oriented(axes: Array) -> Array:
    """Point each of two directions along the axis it is closest to; lower axis first."""
    sizes = np.round(np.abs(axes), 9)  # rounded: equal components must not be told apart by noise
    closest = sizes.argmax(axis=1)
    signed = axes * np.sign(axes[[0, 1], closest])[:, None]
    first, second = (tuple(row) for row in sizes)
    swap = (closest[1], [-c for c in second]) < (closest[0], [-c for c in first])
    ordered: Array = signed[::-1] if swap else signed
    return ordered
