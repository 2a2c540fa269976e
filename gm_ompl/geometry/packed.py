"""Convex pieces and motions as compiled code reads them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.geometry.solids import ConvexPiece
from gm_ompl.geometry.sweep import Sweep


class Hull(NamedTuple):
    """A convex piece, all in one frame.

    Attributes:
        vertices: (v, 3).
        normals: (f, 3), of its faces, unit, outward.
        offsets: (f,), distances of the faces' planes from the origin, along the normals.
        edges: (e, 3), unit directions of its edges.
        starts: (s, 3), one end of each edge.
        spans: (s, 3), from there to its other end.
    """

    vertices: Array
    normals: Array
    offsets: Array
    edges: Array
    starts: Array
    spans: Array


class Hulls(NamedTuple):
    """Convex pieces, one behind the other.

    Attributes:
        all: all of them in one.
        ends: (k + 1, 4), where each begins among the vertices, faces, directions and edges.
        low: (k, 3), least coordinates of each.
        high: (k, 3), greatest.
    """

    all: Hull
    ends: IntArray
    low: Array
    high: Array


class Drive(NamedTuple):
    """A ``Sweep`` without the pose where it begins."""

    pivot: Array
    axis: Array
    angle: float
    drift: Array


def packed(pieces: Sequence[ConvexPiece]) -> Hulls:
    """Return pieces as compiled code reads them."""
    parts = [
        (p.vertices, p.face_normals, p.face_offsets, p.edge_directions, *p.edge_ends)
        for p in pieces
    ]
    counts = [[len(part[k]) for k in (0, 1, 3, 4)] for part in parts]
    ends = np.cumsum([[0] * 4, *counts], axis=0)
    none = np.zeros((0, 3))
    columns = list(zip(*parts, strict=True)) or [(none,), (none,), (np.zeros(0),), *[(none,)] * 3]
    whole = Hull(*(np.ascontiguousarray(np.concatenate(column)) for column in columns))
    low = np.array([p.vertices.min(axis=0) for p in pieces]).reshape(-1, 3)
    high = np.array([p.vertices.max(axis=0) for p in pieces]).reshape(-1, 3)
    return Hulls(whole, np.ascontiguousarray(ends, dtype=np.int64), low, high)


def drive(sweep: Sweep) -> Drive:
    """Return a sweep as compiled code reads it.

    Arrays are copied: they are read-only, and code for such would be compiled besides.
    """
    return Drive(sweep.pivot.copy(), sweep.axis.copy(), float(sweep.angle), sweep.drift.copy())


@inlined
def piece(hulls: Hulls, k: int) -> Hull:
    """Return piece ``k``."""
    a, b, h = hulls.ends[k], hulls.ends[k + 1], hulls.all
    return Hull(
        h.vertices[a[0] : b[0]],
        h.normals[a[1] : b[1]],
        h.offsets[a[1] : b[1]],
        h.edges[a[2] : b[2]],
        h.starts[a[3] : b[3]],
        h.spans[a[3] : b[3]],
    )


@lean
def turn(vectors: Array, R: Array, into: Array) -> None:
    """Write vectors (n, 3) turned by R (3, 3)."""
    for i in range(len(vectors)):
        for k in range(3):
            into[i, k] = R[k, 0] * vectors[i, 0] + R[k, 1] * vectors[i, 1] + R[k, 2] * vectors[i, 2]


@compiled
def placed(hulls: Hulls, R: Array, p: Array) -> Hulls:
    """Return pieces turned by ``R`` (3, 3) and moved by ``p`` (3,)."""
    h = hulls.all
    new = Hull(
        np.empty_like(h.vertices),
        np.empty_like(h.normals),
        h.offsets.copy(),
        np.empty_like(h.edges),
        np.empty_like(h.starts),
        np.empty_like(h.spans),
    )
    turn(h.vertices, R, new.vertices)
    turn(h.normals, R, new.normals)
    turn(h.edges, R, new.edges)
    turn(h.starts, R, new.starts)
    turn(h.spans, R, new.spans)
    for i in range(len(h.offsets)):
        n = new.normals[i]
        new.offsets[i] += n[0] * p[0] + n[1] * p[1] + n[2] * p[2]
    low, high = np.full_like(hulls.low, np.inf), np.full_like(hulls.high, -np.inf)
    for j in range(len(low)):
        for k in range(3):
            for i in range(hulls.ends[j, 0], hulls.ends[j + 1, 0]):
                new.vertices[i, k] += p[k]
                low[j, k] = min(low[j, k], new.vertices[i, k])
                high[j, k] = max(high[j, k], new.vertices[i, k])
            for i in range(hulls.ends[j, 3], hulls.ends[j + 1, 3]):
                new.starts[i, k] += p[k]
    return Hulls(new, hulls.ends, low, high)


@lean
def write_rotation(axis: Array, angle: float, R: Array) -> None:
    """Write (3, 3), the rotation about a unit axis (3,) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    t = 1.0 - c
    R[0, 0], R[0, 1], R[0, 2] = c + t * x * x, t * x * y - s * z, t * x * z + s * y
    R[1, 0], R[1, 1], R[1, 2] = t * x * y + s * z, c + t * y * y, t * y * z - s * x
    R[2, 0], R[2, 1], R[2, 2] = t * x * z - s * y, t * y * z + s * x, c + t * z * z


@compiled
def rotation(axis: Array, angle: float) -> Array:
    """Return (3, 3), the rotation about a unit axis (3,) [rad]."""
    R = np.empty((3, 3))
    write_rotation(axis, angle, R)
    return R


@lean
def write_moved(points: Array, motion: Drive, t: float, R: Array, places: Array) -> None:
    """Write where points (n, 3), given at t = 0, are at ``t``; the turn up to there is R (3, 3)."""
    pivot, drift = motion.pivot, motion.drift
    for i in range(len(points)):
        x, y, z = points[i, 0] - pivot[0], points[i, 1] - pivot[1], points[i, 2] - pivot[2]
        for k in range(3):
            arm = R[k, 0] * x + R[k, 1] * y + R[k, 2] * z
            places[i, k] = arm + (pivot[k] + t * drift[k])


class HullRoom(NamedTuple):
    """Where a piece is written that has moved.

    Attributes:
        hull: room for the largest piece.
        R: (3, 3), the rotation.
        box: (2, 3), around where a piece stays.
    """

    hull: Hull
    R: Array
    box: Array


@compiled
def hull_room(hulls: Hulls) -> HullRoom:
    """Return room for any of some pieces."""
    v, f, e, none = 0, 0, 0, np.empty((0, 3))
    for k in range(len(hulls.low)):
        v = max(v, hulls.ends[k + 1, 0] - hulls.ends[k, 0])
        f = max(f, hulls.ends[k + 1, 1] - hulls.ends[k, 1])
        e = max(e, hulls.ends[k + 1, 2] - hulls.ends[k, 2])
    hull = Hull(np.empty((v, 3)), np.empty((f, 3)), np.empty(f), np.empty((e, 3)), none, none)
    return HullRoom(hull, np.empty((3, 3)), np.empty((2, 3)))


@inlined
def moved_hull(hull: Hull, motion: Drive, t: float, room: HullRoom) -> Hull:
    """Return where a piece, given at t = 0, is at ``t``; its edges' places are left out."""
    write_moved_hull(hull, motion, t, room)
    v, f, e, h = len(hull.vertices), len(hull.normals), len(hull.edges), room.hull
    return Hull(h.vertices[:v], h.normals[:f], h.offsets[:f], h.edges[:e], hull.starts, hull.spans)


@lean
def write_moved_hull(hull: Hull, motion: Drive, t: float, room: HullRoom) -> None:
    """Write where a piece, given at t = 0, is at ``t``."""
    into, R, p, d = room.hull, room.R, motion.pivot, motion.drift
    write_rotation(motion.axis, t * motion.angle, R)
    turn(hull.normals, R, into.normals)
    turn(hull.edges, R, into.edges)
    for i in range(len(hull.offsets)):
        n, m = hull.normals[i], into.normals[i]
        offset = hull.offsets[i] - (n[0] * p[0] + n[1] * p[1] + n[2] * p[2])
        for k in range(3):
            offset += m[k] * (p[k] + t * d[k])
        into.offsets[i] = offset
    write_moved(hull.vertices, motion, t, R, into.vertices)


@lean
def write_way_box(points: Array, motion: Drive, share: float, room: HullRoom) -> None:
    """Write a box in which points (n, 3), given at t = 0, stay up to t = ``share``."""
    low, high, R, axis, widest = room.box[0], room.box[1], room.R, motion.axis, 0.0
    write_rotation(axis, share * motion.angle, R)
    pivot, drift = motion.pivot, motion.drift
    for k in range(3):
        low[k], high[k] = np.inf, -np.inf
    for i in range(len(points)):
        x, y, z = points[i, 0] - pivot[0], points[i, 1] - pivot[1], points[i, 2] - pivot[2]
        along = x * axis[0] + y * axis[1] + z * axis[2]
        widest = max(widest, x * x + y * y + z * z - along * along)
        for k in range(3):
            end = R[k, 0] * x + R[k, 1] * y + R[k, 2] * z + pivot[k] + share * drift[k]
            low[k] = min(low[k], points[i, k], end)
            high[k] = max(high[k], points[i, k], end)
    half = abs(motion.angle) / 2.0
    bulge = np.sqrt(widest) * ((1.0 - np.cos(half)) if half < np.pi / 2 else 2.0)
    for k in range(3):
        low[k] -= bulge
        high[k] += bulge
