"""Convex figures in a plane, compiled: what ``polygon`` says of them, for arrays of points."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, compiled_as_written, inlined


@compiled
def summed(a: Array, b: Array) -> float:
    """Return a . b for (3,), added up from the first term on, as in numpy's products of matrices.

    What is equal in every bit there is so here.
    """
    total: float = a[1] * b[1] + a[0] * b[0] + a[2] * b[2]
    return total


@compiled
def combined(a: float, u: float, b: float, v: float) -> float:
    """Return a u + b v, likewise."""
    total: float = b * v + a * u
    return total


@compiled_as_written
def basis(normal: Array) -> Array:
    """Return (2, 3), the directions of a plane as ``polygon.plane_basis`` has them."""
    axis = 0
    for k in range(1, 3):
        if abs(normal[k]) < abs(normal[axis]):
            axis = k
    found = np.zeros((2, 3))
    for k in range(3):
        found[0, k] = (1.0 if k == axis else 0.0) - normal[axis] * normal[k]
    length = np.sqrt(summed(found[0], found[0]))
    for k in range(3):
        found[0, k] /= length
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        found[1, k] = normal[i] * found[0, j] - normal[j] * found[0, i]
    return found


@compiled_as_written
def picked(points: Array, which: IntArray) -> Array:
    """Return some of points (n, 2)."""
    found = np.empty((len(which), 2))
    for i in range(len(which)):
        found[i, 0], found[i, 1] = points[which[i], 0], points[which[i], 1]
    return found


@compiled_as_written
def beside(points: Array, p: int, q: int, x: float, y: float) -> float:
    """Return twice the area of the triangle of points p and q and a place."""
    px, py = points[p, 0], points[p, 1]
    return float((points[q, 0] - px) * (y - py) - (points[q, 1] - py) * (x - px))


@inlined
def _chain(points: Array) -> IntArray:
    """Return the numbers (c,) of the corners of points (n, 2), and of what lies on the sides."""
    n = len(points)
    order, chain, count = np.empty(n, dtype=np.int64), np.empty(2 * n + 1, dtype=np.int64), 0
    for a in range(n):
        i, b = a, a
        while b > 0:
            j = order[b - 1]
            if points[j, 0] < points[i, 0] or (
                points[j, 0] == points[i, 0] and points[j, 1] <= points[i, 1]
            ):
                break
            order[b], b = j, b - 1
        order[b] = i
    for way in range(2):
        base = count
        for a in range(n):
            i = order[a] if way == 0 else order[n - 1 - a]
            x, y = points[i, 0], points[i, 1]
            while count >= base + 2 and (
                beside(points, chain[count - 2], chain[count - 1], x, y) <= 0.0
            ):
                count -= 1
            chain[count] = i
            count += 1
        count -= 1
    if count == 0:
        chain[0], count = order[0], 1
    return chain[:count]


@compiled_as_written
def outline(points: Array, tolerance: float) -> IntArray:
    """Return the numbers of the hull's corners, as ``polygon.convex_hull`` does."""
    chain = _chain(points)
    first = far = chain[0]
    length, level = 0.0, True
    for i in chain:
        away = np.hypot(points[i, 0] - points[first, 0], points[i, 1] - points[first, 1])
        if away > length:
            far, length = i, away
    if length <= tolerance:
        return chain[:1]
    for i in chain:
        off = beside(points, first, far, points[i, 0], points[i, 1])
        level &= abs(off) <= tolerance * length
    if level:
        chain[1] = far
        return chain[:2]
    k, count = 0, len(chain)
    while k < count and count > 3:
        before, after = chain[(k + count - 1) % count], chain[(k + 1) % count]
        if _from_segment(points, before, after, chain[k]) <= tolerance:
            for i in range(k, count - 1):
                chain[i] = chain[i + 1]
            count, k = count - 1, max(k - 1, 0)
        else:
            k += 1
    return chain[:count]


@inlined
def _from_segment(points: Array, p: int, q: int, i: int) -> float:
    """Return how far point ``i`` is from a segment between two others."""
    px, py, x, y = points[p, 0], points[p, 1], points[i, 0], points[i, 1]
    dx, dy = points[q, 0] - px, points[q, 1] - py
    square, t = dx * dx + dy * dy, 0.0
    if square != 0.0:
        t = ((x - px) * dx + (y - py) * dy) / square
    t = min(max(t, 0.0), 1.0)
    return float(np.hypot(x - (px + t * dx), y - (py + t * dy)))


@compiled_as_written
def inside_by(polygon: Array, x: float, y: float) -> float:
    """Return the distance from a place to the nearest edge line; negative outside."""
    least, n = np.inf, len(polygon)
    for p in range(n):
        q = (p + 1) % n
        length = np.hypot(polygon[q, 0] - polygon[p, 0], polygon[q, 1] - polygon[p, 1])
        least = min(least, beside(polygon, p, q, x, y) / length)
    return least


@compiled_as_written
def clipped(subject: Array, window: Array) -> Array:
    """Return the part of a polygon or segment inside a polygon, as ``polygon.clip`` does."""
    part, closed = subject, len(subject) > 2
    for p in range(len(window)):
        q, n, count = (p + 1) % len(window), len(part), 0
        kept, heights = np.empty((2 * n, 2)), np.empty(n)
        for i in range(n):
            heights[i] = beside(window, p, q, part[i, 0], part[i, 1])
        for i in range(n):
            if heights[i] >= 0.0:
                kept[count, 0], kept[count, 1] = part[i, 0], part[i, 1]
                count += 1
            j = (i + 1) % n
            if (closed or j > i) and heights[i] * heights[j] < 0.0:
                t = heights[i] / (heights[i] - heights[j])
                for k in range(2):
                    kept[count, k] = part[i, k] + t * (part[j, k] - part[i, k])
                count += 1
        part = kept[:count]
    return part
