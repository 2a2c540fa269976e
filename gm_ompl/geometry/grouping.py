"""Which triangles of a surface are neighbours, and which of them form a plane facet."""

from __future__ import annotations

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray


def neighbours_of(faces: IntArray) -> IntArray:
    """Return per triangle (t, 3) of a closed surface the three on the other side of its edges."""
    count = int(faces.max()) + 1
    tails, heads = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    there, back = tails * count + heads, heads * count + tails
    order = np.argsort(there)
    other = order[np.searchsorted(there[order], back)]
    return np.asarray(other // 3, dtype=np.int64).reshape(-1, 3)


def facets_of(corners: Array, neighbours: IntArray, flat: float) -> list[IntArray]:
    """Return per facet the numbers of its triangles, the facet with the largest triangle first.

    A facet grows from its largest triangle over neighbours that face the same way and lie within
    ``flat`` of its plane, which is fitted to it anew as it grows. Every triangle is in one facet.

    Args:
        corners: (t, 3, 3), the triangles.
        neighbours: (t, 3), as ``neighbours_of`` gives them.
        flat: a length.
    """
    a, b, c = corners.transpose(1, 0, 2)
    crossed = np.cross(b - a, c - a)
    # A sliver within ``flat`` of a line may face any way.
    slack = flat * np.linalg.norm([b - a, c - b, a - c], axis=2).max(axis=0)
    sizes = np.linalg.norm(crossed, axis=1)
    bends = _bends(corners, neighbours, crossed, sizes, slack, flat)
    free = np.ones(len(corners), dtype=bool)
    found = []
    for seed in np.argsort(-sizes, kind="stable").tolist():
        if not free[seed]:
            continue
        limits.check()
        members = [seed]
        if sizes[seed] > 0.0 and not bends[seed]:
            members = _grown(seed, corners, crossed, slack, flat, free, neighbours)
        free[members] = False
        found.append(np.sort(np.array(members)))
    return found


def _bends(
    corners: Array, neighbours: IntArray, crossed: Array, sizes: Array, slack: Array, flat: float
) -> BoolArray:
    """Whether no neighbour of a triangle continues its plane."""
    normals = crossed / np.where(sizes > 0.0, sizes, 1.0)[:, None]
    off = np.einsum("tnki,ti->tnk", corners[neighbours] - corners[:, None, None, 0], normals)
    facing = np.einsum("tni,ti->tn", crossed[neighbours], normals) >= -slack[neighbours]
    bends: BoolArray = ~((np.abs(off).max(axis=2) <= flat) & facing).any(axis=1)
    return bends


def _grown(
    seed: int, corners: Array, crossed: Array, slack: Array, flat: float, free: BoolArray,
    neighbours: IntArray,
) -> list[int]:  # fmt: skip
    """Return the facet around a triangle, grown in rings."""
    normal = crossed[seed] / np.linalg.norm(crossed[seed])
    origin = corners[seed].mean(axis=0)
    taken, last, fitted = {seed}, [seed], 1
    while last:
        ring = np.array(sorted({k for k in neighbours[last].ravel().tolist() if k not in taken}))
        if not len(ring):
            break
        kept = free[ring] & (crossed[ring] @ normal >= -slack[ring])
        kept &= np.abs((corners[ring] - origin) @ normal).max(axis=1) <= flat
        last = ring[kept].tolist()
        taken.update(last)
        if len(taken) >= 1.5 * fitted:  # not worth it for a few more
            fitted = len(taken)
            normal, origin = _fit(corners[list(taken)].reshape(-1, 3), normal)
    return list(taken)


def _fit(points: Array, towards: Array) -> tuple[Array, Array]:
    """Return unit normal and a point of the plane nearest to points, by least squares."""
    origin = points.mean(axis=0)
    local = points - origin
    normal = np.linalg.eigh(local.T @ local)[1][:, 0]
    return normal * (np.sign(normal @ towards) or 1.0), origin
