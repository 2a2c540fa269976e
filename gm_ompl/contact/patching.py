"""Contact patches of convex pieces, compiled: what ``patch`` says, equal in every bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled_as_written
from gm_ompl.geometry.flat import (
    basis,
    clipped,
    combined,
    inside_by,
    outline,
    picked,
    summed,
)
from gm_ompl.geometry.solids import ConvexPiece
from gm_ompl.geometry.vectors import dot

EDGES: Final = 10_000
"""So many points: an edge of either may cross one of the other."""


class Shapes(NamedTuple):
    """Convex pieces, all in one frame, in as few arrays as may be: that compiles fast.

    Attributes:
        rows: (n, 3), of each piece the vertices, the faces' unit normals, the edges' directions.
        offsets: (n,), of the faces' planes, in their normals' rows.
        ends: (k, 4), where each piece's vertices, normals and edges begin, and where these end.
        boxes: (k, 2, 3), least and greatest coordinates.
    """

    rows: Array
    offsets: Array
    ends: IntArray
    boxes: Array


def shapes(pieces: Sequence[ConvexPiece]) -> Shapes:
    """Return pieces as the compiled functions here read them."""
    rows, offsets, ends, boxes = [np.zeros((0, 3))], [np.zeros(0)], list[list[int]](), list[Array]()
    n = 0
    for p in pieces:
        parts = p.vertices, p.face_normals, p.edge_directions
        rows += parts
        offsets += [np.zeros(len(parts[0])), p.face_offsets, np.zeros(len(parts[2]))]
        ends.append([n + sum(map(len, parts[:k])) for k in range(4)])
        n = ends[-1][-1]
        boxes.append(np.array([p.vertices.min(axis=0), p.vertices.max(axis=0)]))
    return Shapes(
        np.concatenate(rows), np.concatenate(offsets),
        np.array(ends, dtype=np.int64).reshape(-1, 4), np.array(boxes).reshape(-1, 2, 3),
    )  # fmt: skip


@compiled_as_written
def placed_at(own: Shapes, R: Array, p: Array) -> Shapes:
    """Return pieces at a pose (3, 3), (3,)."""
    rows, offsets = np.empty((len(own.rows), 3)), np.empty(len(own.rows))
    boxes = np.empty((len(own.ends), 2, 3))
    for j in range(len(own.ends)):
        for c in range(3):
            boxes[j, 0, c], boxes[j, 1, c] = np.inf, -np.inf
        for i in range(own.ends[j, 0], own.ends[j, 3]):
            for c in range(3):
                rows[i, c] = summed(own.rows[i], R[c])
                if i < own.ends[j, 1]:
                    rows[i, c] += p[c]
                    boxes[j, 0, c] = min(boxes[j, 0, c], rows[i, c])
                    boxes[j, 1, c] = max(boxes[j, 1, c], rows[i, c])
            offsets[i] = own.offsets[i] + dot(rows[i], p)
    return Shapes(rows, offsets, own.ends, boxes)


@compiled_as_written
def _reach(direction: Array, s: Shapes, k: int, sign: float) -> float:
    """Return how far piece ``k`` reaches along a direction (3,); back, and less, for -1."""
    found = -np.inf
    for i in range(s.ends[k, 0], s.ends[k, 1]):
        found = max(found, sign * summed(s.rows[i], direction))
    return sign * found


@compiled_as_written
def patch_of(a: Shapes, k: int, b: Shapes, j: int, tolerance: float, normal: Array) -> Array:
    """Return the points (m, 3) where a piece of ``a`` touches one of ``b``; none: nowhere.

    Their normal (3,), into ``a``, is written. Where faces do not tell, ``EDGES`` points of no
    meaning come back: that is rare, and ``contact_patch`` must be asked.
    """
    f, past, best = b.ends[j, 1], b.ends[j, 2], -np.inf
    faces = past - f + a.ends[k, 2] - a.ends[k, 1]
    gaps = np.empty(faces)
    for n in range(faces):
        if f + n < past:
            gaps[n] = _reach(b.rows[f + n], a, k, -1.0) - b.offsets[f + n]
        else:
            i = a.ends[k, 1] + f + n - past
            gaps[n] = _reach(a.rows[i], b, j, -1.0) - a.offsets[i]
        best = max(best, gaps[n])
    if best > tolerance:
        return np.empty((0, 3))
    least = max(best - tolerance, -tolerance)
    for n in range(faces if best >= -tolerance else 0):
        if gaps[n] < least:
            continue
        mine, i = f + n >= past, a.ends[k, 1] + f + n - past
        points = _on_face(a, k, b, j, i, tolerance) if mine else (
            _on_face(b, j, a, k, f + n, tolerance)
        )  # fmt: skip
        if len(points):
            for c in range(3):
                normal[c] = -a.rows[i, c] if mine else b.rows[f + n, c]
            for i in range(len(points) // 2 if mine else 0):  # seen from the other side
                for c in range(3):
                    last = len(points) - 1 - i
                    points[i, c], points[last, c] = points[last, c], points[i, c]
            return points
    return np.empty((EDGES, 3))


@compiled_as_written
def _corners(s: Shapes, k: int, plane: tuple[Array, float], chart: Array, near: float) -> Array:
    """Return the corners (c, 2) of the hull of a piece's vertices in a plane."""
    first, count = s.ends[k, 0], 0
    points = np.empty((s.ends[k, 1] - first, 2))
    for i in range(first, s.ends[k, 1]):
        if abs(dot(s.rows[i], plane[0]) - plane[1]) <= near:
            points[count, 0], points[count, 1] = (
                summed(s.rows[i], chart[0]),
                summed(s.rows[i], chart[1]),
            )
            count += 1
    points = points[:count]
    return picked(points, outline(points, near)) if count else points


@compiled_as_written
def _lifted(flat: Array, plane: tuple[Array, float], chart: Array) -> Array:
    """Return points (k, 2) of a plane in space, (k, 3)."""
    points = np.empty((len(flat), 3))
    for i in range(len(flat)):
        for c in range(3):
            along = combined(flat[i, 0], chart[0, c], flat[i, 1], chart[1, c])
            points[i, c] = along + plane[1] * plane[0][c]
    return points


@compiled_as_written
def _on_face(owner: Shapes, k: int, other: Shapes, j: int, face: int, tolerance: float) -> Array:
    """Return the patch on one of the owner's faces, seen from outside; none: it has no extent."""
    plane, none = (owner.rows[face], owner.offsets[face]), np.empty((0, 3))
    chart = basis(plane[0])
    window = _corners(owner, k, plane, chart, tolerance)
    foot = _corners(other, j, plane, chart, tolerance)
    if len(window) < 3 or len(foot) == 0:
        return none
    if len(foot) == 1:
        inside = inside_by(window, foot[0, 0], foot[0, 1]) > tolerance
        return _lifted(foot, plane, chart) if inside else none
    part = clipped(foot, window)
    if len(part) < 2:
        return none
    corners = picked(part, outline(part, tolerance))
    if len(corners) == 1 or (len(corners) == 2 and len(foot) > 2):
        return none
    if len(corners) == 2:
        x, y = (corners[0, 0] + corners[1, 0]) / 2.0, (corners[0, 1] + corners[1, 1]) / 2.0
        if inside_by(window, x, y) <= tolerance:
            return none
    return _lifted(corners, plane, chart)
