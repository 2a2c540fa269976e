"""Patches of bodies made of several convex pieces, and points inside patches."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.patch import Patch
from gm_ompl.geometry.polygon import Point2, convex_hull, plane_basis

SAME_NORMAL = 1e-6
"""Normals that differ by less are one."""


def joined(patches: Sequence[Patch], tolerance: float) -> Iterator[Patch]:
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


def _one_patch(a: Patch, b: Patch, tolerance: float) -> bool:
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


def _hull(cluster: Iterable[Patch], tolerance: float) -> Patch:
    parts = list(cluster)
    normal = parts[0].normal
    points = np.concatenate([patch.points for patch in parts])
    flat: list[Point2] = [(float(x), float(y)) for x, y in points @ plane_basis(normal).T]
    return Patch(points[convex_hull(flat, tolerance)], normal)


def points_inside(patch: Patch, fineness: int) -> Array:
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
