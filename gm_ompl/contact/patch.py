"""The contact patches of convex pieces: where contact forces may act, and along which normal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled
from gm_ompl.geometry.polygon import (
    clip,
    convex_hull,
    depth_inside,
    distance,
    plane_basis,
    side,
)
from gm_ompl.geometry.separation import PlacedPiece, edge_gaps, face_gaps
from gm_ompl.geometry.vectors import dot


class ContactPatch(NamedTuple):
    """Vertices (k, 3) of a contact patch, counter-clockwise about its unit ``normal`` (3,)."""

    points: Array
    normal: Array


def contact_patch(a: PlacedPiece, b: PlacedPiece, tolerance: float) -> ContactPatch | None:
    """Return where ``a`` touches ``b``, its normal pointing into ``a``; None if nowhere.

    The pieces touch where the gap along the best separating axis is at most ``tolerance`` either
    way. The normal is that of ``b``'s face if one takes part, else of ``a``'s, else the cross
    product of the crossed edges. A vertex on a vertex or on an edge, and edges that lie along
    each other without a face, have no normal of their own: no patch.
    """
    of_b, of_a = face_gaps(b, a), face_gaps(a, b)
    best = max(float(of_b.max()), float(of_a.max()))
    if best > tolerance:
        return None
    # A face within the tolerance of the best axis ties with it. Where a face has a patch, the
    # bodies share its points, so no pair of edges can separate them: no need to look.
    if best >= -tolerance:
        for k in np.flatnonzero(of_b >= max(best - tolerance, -tolerance)):
            points = _face_patch(b, a, int(k), tolerance)
            if points is not None:
                return ContactPatch(points, b.normals[k])
        for k in np.flatnonzero(of_a >= max(best - tolerance, -tolerance)):
            points = _face_patch(a, b, int(k), tolerance)
            if points is not None:
                return ContactPatch(points[::-1], -a.normals[k])
    return _edge_patch(a, b, tolerance)


def _face_patch(
    owner: PlacedPiece, other: PlacedPiece, face: int, tolerance: float
) -> Array | None:
    """Return the patch on one of the owner's faces, seen from outside; None if it has no extent."""
    plane = owner.normals[face], float(owner.offsets[face])
    points: Array = face_patch(*plane, owner.vertices, other.vertices, tolerance)
    return points if len(points) else None


@compiled
def face_patch(
    normal: Array, offset: float, owner: Array, other: Array, tolerance: float
) -> Array:  # fmt: skip
    """Return the patch (k, 3) of two convex pieces in the plane of a face; empty: no extent.

    The face's neighbours within the tolerance of its plane belong to it.

    Args:
        normal: (3,), unit, of the face.
        offset: of its plane from the origin, along it.
        owner: vertices of the piece that has the face, (v, 3).
        other: of the other one, (w, 3).
        tolerance: a length.
    """
    basis, none = plane_basis(normal), np.empty((0, 2))
    window = in_plane(owner, normal, offset, basis, tolerance)
    foot = in_plane(other, normal, offset, basis, tolerance)
    corners = none
    if len(window) >= 3 and len(foot) == 1:
        corners = foot if depth_inside(window, foot[0]) > tolerance else none
    elif len(window) >= 3 and len(foot) > 1:
        part = clip(foot, window)
        if len(part) >= 2:
            corners = part[convex_hull(part, tolerance)]
        if len(corners) == 2 and len(foot) == 2:
            middle = (corners[0] + corners[1]) / 2.0
            corners = corners if depth_inside(window, middle) > tolerance else none
        elif len(corners) < 3:
            corners = none
    return lifted(corners, normal, offset, basis)


@compiled
def in_plane(
    vertices: Array, normal: Array, offset: float, basis: Array, tolerance: float
) -> Array:  # fmt: skip
    """Return the hull (k, 2) of the vertices (v, 3) in a plane: a point, segment or polygon."""
    points, count = np.empty((len(vertices), 2)), 0
    for i in range(len(vertices)):
        if abs(dot(vertices[i], normal) - offset) <= tolerance:
            points[count, 0], points[count, 1] = (
                dot(vertices[i], basis[0]),
                dot(vertices[i], basis[1]),
            )
            count += 1
    if count == 0:
        return points[:0].copy()
    return points[:count][convex_hull(points[:count], tolerance)]


@compiled
def lifted(points: Array, normal: Array, offset: float, basis: Array) -> Array:
    """Return points (k, 2) of a plane in space, (k, 3)."""
    found = np.empty((len(points), 3))
    for i in range(len(points)):
        for c in range(3):
            along = points[i, 0] * basis[0, c] + points[i, 1] * basis[1, c]
            found[i, c] = along + offset * normal[c]
    return found


def _edge_patch(a: PlacedPiece, b: PlacedPiece, tolerance: float) -> ContactPatch | None:
    """Return the point where an edge of ``a`` crosses one of ``b``, inside both."""
    widths, normals = edge_gaps(a, b)
    best = float(widths.max(initial=-np.inf))
    if abs(best) > tolerance:
        return None
    for k in np.flatnonzero(widths >= max(best - tolerance, -tolerance)):
        normal = normals[k]
        of_a, of_b = (a.vertices @ normal).min(), (b.vertices @ normal).max()
        basis, offset = plane_basis(normal), float(of_a + of_b) / 2.0
        first, second = (in_plane(x.vertices, normal, offset, basis, tolerance) for x in (a, b))
        point: Array = crossing(first, second, tolerance)
        if len(point):
            return ContactPatch(lifted(point, normal, offset, basis), normal)
    return None


@compiled
def crossing(first: Array, second: Array, tolerance: float) -> Array:
    """Return (1, 2) where two segments (2, 2) cross, ``tolerance`` from all ends; empty: not."""
    found, nowhere = np.empty((1, 2)), np.empty((0, 2))
    if len(first) != 2 or len(second) != 2:
        return nowhere
    p, q, r, s = first[0], first[1], second[0], second[1]
    before, after = side(r, s, p), side(r, s, q)
    if before * after >= 0.0 or side(p, q, r) * side(p, q, s) >= 0.0:
        return nowhere
    for c in range(2):
        found[0, c] = p[c] + before / (before - after) * (q[c] - p[c])
    near = min(distance(found[0], p), distance(found[0], q))
    near = min(near, distance(found[0], r), distance(found[0], s))
    return found if near > tolerance else nowhere


SAME_NORMAL = 1e-6
"""Normals that differ by less are one."""


def joined(patches: Sequence[ContactPatch], tolerance: float) -> Iterator[ContactPatch]:
    """Yield the contact patches of two bodies, given those of their convex pieces.

    Patches in one plane that touch each other are parts of one patch: it is replaced by the
    vertices of its convex hull. For a common normal those carry exactly the wrenches that all
    its points carry together.
    """
    left = list(patches)
    while left:
        cluster = [left.pop(0)]
        grown = True
        while grown:
            near = [p for p in left if any(_one_patch(p, q, tolerance) for q in cluster)]
            left = [p for p in left if not any(p is q for q in near)]
            cluster += near
            grown = bool(near)
        yield cluster[0] if len(cluster) == 1 else _hull(cluster, tolerance)


def _one_patch(a: ContactPatch, b: ContactPatch, tolerance: float) -> bool:
    if np.abs(a.normal - b.normal).max() > SAME_NORMAL:
        return False
    if abs(a.normal @ (a.points[0] - b.points[0])) > 2.0 * tolerance:
        return False
    basis = plane_basis(a.normal)
    p, q = a.points @ basis.T, b.points @ basis.T
    axes = np.concatenate([_axes(p), _axes(q), np.eye(2)])
    of_p, of_q = axes @ p.T, axes @ q.T
    ahead = (of_p.min(axis=1) - of_q.max(axis=1)).max()
    behind = (of_q.min(axis=1) - of_p.max(axis=1)).max()
    return bool(max(ahead, behind) <= 2.0 * tolerance)


def _axes(corners: Array) -> Array:
    """Return the separating directions (k, 2) that a point, segment or polygon offers."""
    if len(corners) == 1:
        return np.zeros((0, 2))
    sides = np.roll(corners, -1, axis=0) - corners
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    across = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
    return np.concatenate([across, sides])


def _hull(cluster: Iterable[ContactPatch], tolerance: float) -> ContactPatch:
    parts = list(cluster)
    normal = parts[0].normal
    points = np.concatenate([patch.points for patch in parts])
    flat = points @ plane_basis(normal).T
    return ContactPatch(points[convex_hull(flat, tolerance)], normal)


def points_inside(patch: ContactPatch, fineness: int) -> Array:
    """Return points (k, 3) inside a patch besides its vertices.

    The triangles between the middle and each side are divided into ``fineness`` squared equal
    ones; a segment into twice ``fineness`` parts. A single point has no inside.
    """
    corners = patch.points
    if fineness < 1 or len(corners) < 2:
        return np.zeros((0, 3))
    if len(corners) == 2:
        t = np.arange(1, 2 * fineness)[:, None] / (2 * fineness)
        inner: Array = corners[0] + t * (corners[1] - corners[0])
        return inner
    middle, points = corners.mean(axis=0), []
    x, y = plane_basis(patch.normal) @ (corners - middle).T
    ring = corners[np.argsort(np.arctan2(y, x))]  # a floor patch's corners come in any order
    for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        for i in range(1, fineness + 1):  # steps from the middle towards the side
            for j in range(i):  # steps along it; the last is the next side's first
                if i < fineness or j:
                    points.append(middle + (i * (p - middle) + j * (q - p)) / fineness)
    return np.array([middle, *points])
