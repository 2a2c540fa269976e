"""Convex figures in a plane, told apart up to a tolerance, and rectangles around them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array

Point2 = tuple[float, float]


def plane_basis(normal: Array) -> Array:
    """Return (2, 3) orthonormal directions e1, e2 of a plane with e1 x e2 = ``normal`` (unit)."""
    x, y, z = (float(c) for c in normal)
    # The axis least along the normal leaves the longest projection: no cancellation.
    axis = min(range(3), key=lambda k: (abs((x, y, z)[k]), k))
    e1 = np.zeros(3)
    e1[axis] = 1.0
    e1 -= (x, y, z)[axis] * normal
    e1 /= np.sqrt(e1 @ e1)
    a, b, c = (float(t) for t in e1)
    return np.array([[a, b, c], [y * c - z * b, z * a - x * c, x * b - y * a]])


def side(p: Point2, q: Point2, x: Point2) -> float:
    """Return twice the area of the triangle p, q, x: positive where x lies left of p -> q."""
    return (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])


def distance(p: Point2, q: Point2) -> float:
    """Return the distance between two points."""
    return math.hypot(q[0] - p[0], q[1] - p[1])


def convex_hull(points: Sequence[Point2], tolerance: float) -> list[int]:
    """Return the numbers of the hull's corners, counter-clockwise.

    One number: all points lie within ``tolerance`` of it. Two: within ``tolerance`` of the
    segment between them. Corners within ``tolerance`` of the chord of their neighbours are left
    out.
    """
    chain = _monotone_chain(points)
    first = chain[0]
    far = max(chain, key=lambda i: distance(points[first], points[i]))
    length = distance(points[first], points[far])
    if length <= tolerance:
        return [first]
    p, q = points[first], points[far]
    if all(abs(side(p, q, points[i])) <= tolerance * length for i in chain):
        return [first, far]
    return _without_flat_corners(points, chain, tolerance)


def _monotone_chain(points: Sequence[Point2]) -> list[int]:
    order = sorted(range(len(points)), key=lambda i: (points[i], i))
    chain: list[int] = []
    for sweep in (order, order[::-1]):
        base = len(chain)
        for i in sweep:
            while len(chain) >= base + 2 and (
                side(points[chain[-2]], points[chain[-1]], points[i]) <= 0.0
            ):
                chain.pop()
            chain.append(i)
        chain.pop()
    return chain or [order[0]]


def _without_flat_corners(
    points: Sequence[Point2], chain: list[int], tolerance: float
) -> list[int]:
    kept = chain.copy()
    k = 0
    while k < len(kept) and len(kept) > 3:
        p, x, q = (points[kept[(k + step) % len(kept)]] for step in (-1, 0, 1))
        if _distance_to_segment(p, q, x) <= tolerance:
            del kept[k]
            k = max(k - 1, 0)
        else:
            k += 1
    return kept


def _distance_to_segment(p: Point2, q: Point2, x: Point2) -> float:
    dx, dy = q[0] - p[0], q[1] - p[1]
    square = dx * dx + dy * dy
    t = 0.0 if square == 0.0 else ((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / square
    t = min(max(t, 0.0), 1.0)
    return distance((p[0] + t * dx, p[1] + t * dy), x)


def depth_inside(polygon: Sequence[Point2], x: Point2) -> float:
    """Return the distance from ``x`` to the nearest edge line; negative outside."""
    return min(
        side(p, q, x) / distance(p, q)
        for p, q in zip(polygon, (*polygon[1:], polygon[0]), strict=True)
    )


def clip(subject: Sequence[Point2], window: Sequence[Point2]) -> list[Point2]:
    """Return the part of a convex polygon or segment inside a convex polygon (Sutherland-Hodgman).

    Args:
        subject: corners, a polygon in either sense or the two ends of a segment.
        window: corners, counter-clockwise.
    """
    part = list(subject)
    closed = len(part) > 2
    for p, q in zip(window, (*window[1:], window[0]), strict=True):
        heights = [side(p, q, x) for x in part]
        kept: list[Point2] = []
        for i, (x, h) in enumerate(zip(part, heights, strict=True)):
            if h >= 0.0:
                kept.append(x)
            following = (i + 1) % len(part)
            if (closed or following > i) and h * heights[following] < 0.0:
                y, t = part[following], h / (h - heights[following])
                kept.append((x[0] + t * (y[0] - x[0]), x[1] + t * (y[1] - x[1])))
        part = kept
    return part


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
