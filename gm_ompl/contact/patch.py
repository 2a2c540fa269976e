"""The contact patches of convex pieces: where contact forces may act, and along which normal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.polygon import (
    Point2,
    clip,
    convex_hull,
    depth_inside,
    distance,
    plane_basis,
    side,
)
from gm_ompl.geometry.separation import PlacedPiece, edge_gaps, face_gaps


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
    """Return the patch on one of the owner's faces, seen from outside; None if it has no extent.

    The face's neighbours within the tolerance of its plane belong to it.
    """
    normal, offset = owner.normals[face], owner.offsets[face]
    chart = _Chart(normal, offset)
    window = chart.corners(owner, tolerance)
    foot = chart.corners(other, tolerance)
    if len(window) < 3 or not foot:
        return None
    if len(foot) == 1:
        inside = depth_inside(window, foot[0]) > tolerance
        return chart.lift(foot) if inside else None
    part = clip(foot, window)
    if len(part) < 2:
        return None
    corners = [part[i] for i in convex_hull(part, tolerance)]
    if len(corners) == 1 or (len(corners) == 2 and len(foot) > 2):
        return None
    if len(corners) == 2:
        (ax, ay), (bx, by) = corners
        if depth_inside(window, ((ax + bx) / 2, (ay + by) / 2)) <= tolerance:
            return None
    return chart.lift(corners)


def _edge_patch(a: PlacedPiece, b: PlacedPiece, tolerance: float) -> ContactPatch | None:
    """Return the point where an edge of ``a`` crosses one of ``b``, inside both."""
    widths, normals = edge_gaps(a, b)
    best = float(widths.max(initial=-np.inf))
    if abs(best) > tolerance:
        return None
    for k in np.flatnonzero(widths >= max(best - tolerance, -tolerance)):
        normal = normals[k]
        of_a, of_b = (a.vertices @ normal).min(), (b.vertices @ normal).max()
        chart = _Chart(normal, (of_a + of_b) / 2)
        point = _crossing(chart.corners(a, tolerance), chart.corners(b, tolerance), tolerance)
        if point is not None:
            return ContactPatch(chart.lift([point]), normal)
    return None


def _crossing(first: list[Point2], second: list[Point2], tolerance: float) -> Point2 | None:
    """Return where two segments cross, at least ``tolerance`` from all four ends."""
    if len(first) != 2 or len(second) != 2:
        return None
    (p, q), (r, s) = first, second
    before, after = side(r, s, p), side(r, s, q)
    if before * after >= 0.0 or side(p, q, r) * side(p, q, s) >= 0.0:
        return None
    t = before / (before - after)
    x = (p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]))
    return x if min(distance(x, end) for end in (p, q, r, s)) > tolerance else None


class _Chart:
    """Coordinates in the contact plane ``normal . x = offset``."""

    def __init__(self, normal: Array, offset: float) -> None:
        self.normal, self.offset = normal, offset
        self.basis = plane_basis(normal)

    def corners(self, body: PlacedPiece, tolerance: float) -> list[Point2]:
        """Return the hull of the body's vertices in the plane: a point, segment or polygon."""
        near = np.abs(body.vertices @ self.normal - self.offset) <= tolerance
        points = [(x, y) for x, y in (body.vertices[near] @ self.basis.T).tolist()]
        return [points[i] for i in convex_hull(points, tolerance)] if points else []

    def lift(self, points: list[Point2]) -> Array:
        """Return plane points (k, 2) in space, (k, 3)."""
        lifted: Array = np.array(points) @ self.basis + self.offset * self.normal
        return lifted


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
    flat: list[Point2] = [(float(x), float(y)) for x, y in points @ plane_basis(normal).T]
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
