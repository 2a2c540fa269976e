"""Convex figures in a plane, told apart up to a tolerance, and rectangles around them.

What is asked for at every pose is compiled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined


@compiled
def plane_basis(normal: Array) -> Array:
    """Return (2, 3) orthonormal directions e1, e2 of a plane with e1 x e2 = ``normal`` (unit)."""
    # The axis least along the normal leaves the longest projection: no cancellation.
    axis = 0
    for k in (1, 2):
        if abs(normal[k]) < abs(normal[axis]):
            axis = k
    e = np.empty((2, 3))
    for k in range(3):
        e[0, k] = (1.0 if k == axis else 0.0) - normal[axis] * normal[k]
    length = np.sqrt(e[0, 0] * e[0, 0] + e[0, 1] * e[0, 1] + e[0, 2] * e[0, 2])
    for k in range(3):
        e[0, k] /= length
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        e[1, k] = normal[i] * e[0, j] - normal[j] * e[0, i]
    return e


@inlined
def side(p: Array, q: Array, x: Array) -> float:
    """Return twice the area of the triangle p, q, x (2,): positive where x lies left of p -> q."""
    return float((q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0]))


@inlined
def distance(p: Array, q: Array) -> float:
    """Return the distance between two points (2,)."""
    return float(np.hypot(q[0] - p[0], q[1] - p[1]))


@compiled
def convex_hull(points: Array, tolerance: float) -> IntArray:
    """Return the numbers of the corners of the hull of points (k, 2), counter-clockwise.

    One number: all points lie within ``tolerance`` of it. Two: within ``tolerance`` of the
    segment between them. Corners within ``tolerance`` of the chord of their neighbours are left
    out.
    """
    chain = _monotone_chain(points)
    first = far = chain[0]
    for i in chain:
        if distance(points[first], points[i]) > distance(points[first], points[far]):
            far = i
    length = distance(points[first], points[far])
    if length <= tolerance:
        return chain[:1].copy()
    flat = True
    for i in chain:
        flat &= abs(side(points[first], points[far], points[i])) <= tolerance * length
    if flat:
        return np.array([first, far])
    return _without_flat_corners(points, chain, tolerance)


@compiled
def _monotone_chain(points: Array) -> IntArray:
    count = len(points)
    order = np.arange(count)
    for i in range(1, count):  # by x, then y
        one, k = order[i], i
        while k > 0 and _comes_first(points, one, order[k - 1]):
            order[k] = order[k - 1]
            k -= 1
        order[k] = one
    chain, size = np.empty(2 * count + 1, dtype=np.int64), 0
    for sweep in range(2):
        base = size
        for step in range(count):
            i = order[step if sweep == 0 else count - 1 - step]
            while size >= base + 2 and (
                side(points[chain[size - 2]], points[chain[size - 1]], points[i]) <= 0.0
            ):
                size -= 1
            chain[size] = i
            size += 1
        size -= 1
    if size == 0:
        size = 1
        chain[0] = order[0]
    return chain[:size].copy()


@inlined
def _comes_first(points: Array, i: int, j: int) -> bool:
    """Whether a point has the lesser x, or then y, than one of a lesser number."""
    if points[i, 0] == points[j, 0]:
        return bool(points[i, 1] < points[j, 1])
    return bool(points[i, 0] < points[j, 0])


@compiled
def _without_flat_corners(points: Array, chain: IntArray, tolerance: float) -> IntArray:
    kept, size, k = chain.copy(), len(chain), 0
    while k < size and size > 3:
        p, x, q = (
            points[kept[k - 1 if k else size - 1]],
            points[kept[k]],
            points[kept[(k + 1) % size]],
        )
        if _distance_to_segment(p, q, x) <= tolerance:
            kept[k : size - 1] = kept[k + 1 : size].copy()
            size, k = size - 1, max(k - 1, 0)
        else:
            k += 1
    return kept[:size].copy()


@inlined
def _distance_to_segment(p: Array, q: Array, x: Array) -> float:
    dx, dy = q[0] - p[0], q[1] - p[1]
    square = dx * dx + dy * dy
    t = 0.0
    if square > 0.0:
        t = min(max(((x[0] - p[0]) * dx + (x[1] - p[1]) * dy) / square, 0.0), 1.0)
    return float(np.hypot(x[0] - p[0] - t * dx, x[1] - p[1] - t * dy))


@compiled
def depth_inside(polygon: Array, x: Array) -> float:
    """Return the distance of x (2,) from the nearest edge line (k, 2); negative outside."""
    least = np.inf
    for i in range(len(polygon)):
        p, q = polygon[i], polygon[(i + 1) % len(polygon)]
        least = min(least, side(p, q, x) / distance(p, q))
    return float(least)


@compiled
def clip(subject: Array, window: Array) -> Array:
    """Return the part of a convex polygon or segment inside a convex polygon (Sutherland-Hodgman).

    Args:
        subject: corners (k, 2), a polygon in either sense or the two ends of a segment.
        window: corners (m, 2), counter-clockwise.
    """
    part, size, closed = subject.copy(), len(subject), len(subject) > 2
    for w in range(len(window)):
        p, q = window[w], window[(w + 1) % len(window)]
        kept, count = np.empty((2 * size, 2)), 0
        for i in range(size):
            h = side(p, q, part[i])
            if h >= 0.0:
                kept[count] = part[i]
                count += 1
            following = (i + 1) % size
            ahead = side(p, q, part[following])
            if (closed or following > i) and h * ahead < 0.0:
                t = h / (h - ahead)
                for c in range(2):
                    kept[count, c] = part[i, c] + t * (part[following, c] - part[i, c])
                count += 1
        part, size = kept[:count].copy(), count
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
