"""Facets: triangles of a surface that lie in one plane; convex hulls with merged triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.polygon import convex_hull, plane_basis

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull
from gm_ompl.arrays import IntArray

COPLANAR = 1e-7
"""Points this close to a plane, relative to the hull's extent, lie in it: above the rounding of
single-precision mesh files, and the tolerance of a touching contact."""

FLAT = 1e-6
"""A hull thinner than this, relative to its extent, is refused: its faces would merge."""

PARALLEL = 1e-9
"""Directions with a smaller sine between them count as parallel."""


class CrowdedError(GeometryError):
    """Points are so close together that faces cannot be told apart."""


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex polyhedron's corners, faces and edge directions (see ``ConvexPiece``)."""

    vertices: Array
    faces: tuple[tuple[int, ...], ...]
    normals: Array
    offsets: Array
    edge_directions: Array

    @property
    def is_box(self) -> bool:
        """Whether six rectangles meet at right angles."""
        if len(self.vertices) != 8 or len(self.faces) != 6 or len(self.edge_directions) != 3:
            return False
        gram = self.edge_directions @ self.edge_directions.T
        return bool(np.abs(gram - np.eye(3)).max() <= PARALLEL)


def polyhedron(cloud: Array) -> Polyhedron:
    """Return the convex hull of finite points (n, 3), n >= 4.

    Raises:
        GeometryError: the points lie in one plane, or so close together that no clean polyhedron
            comes out.
    """
    centre = (cloud.max(axis=0) + cloud.min(axis=0)) / 2
    extent = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
    if extent == 0.0:
        raise GeometryError("a hull's points all coincide")
    # Qhull's own tolerances are absolute in places: work at unit size about the origin.
    local = (cloud - centre) / extent
    found = _qhull(local)
    width = (-found.equations[:, 3] - (found.equations[:, :3] @ local.T).min(axis=1)).min()
    if width < FLAT:
        raise GeometryError(
            f"a hull's points all lie in one plane, or nearly so: it is {width * extent:.3g} thick "
            f"and {extent:.3g} across"
        )
    return _assemble(cloud, _faces(local, found))


def _qhull(local: Array) -> ConvexHull:
    from scipy.spatial import ConvexHull, QhullError  # takes long to load; boxes need none

    try:
        return ConvexHull(local)
    except QhullError as error:
        raise GeometryError("a hull's points all lie in one plane") from error


def _faces(local: Array, found: ConvexHull) -> list[list[int]]:
    """Return each face's corners, counter-clockwise from outside, flood-filled from triangles."""
    corners = local[found.simplices]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    free = np.ones(len(areas), dtype=bool)
    faces = []
    # Large triangles first: a sliver's own plane is unreliable.
    for seed in np.argsort(-areas, kind="stable"):
        if not free[seed]:
            continue
        limits.check()
        normal, shift = found.equations[seed, :3], found.equations[seed, 3]
        triangles = _flood(int(seed), free, found, local @ normal + shift)
        free[triangles] = False
        members = sorted(set(found.simplices[triangles].ravel()))
        plane = local[members] @ plane_basis(normal).T
        ring = convex_hull([(float(x), float(y)) for x, y in plane], COPLANAR)
        faces.append([int(members[i]) for i in ring])
    return faces


def _flood(seed: int, free: BoolArray, found: ConvexHull, heights: Array) -> list[int]:
    """Return the free triangles around ``seed`` whose corners have no height over its plane."""
    flat = (np.abs(heights) <= COPLANAR).tolist()
    reached, front = {seed}, [seed]
    while front:
        for other in found.neighbors[front.pop()].tolist():
            if other in reached or not free[other]:
                continue
            if all(flat[corner] for corner in found.simplices[other].tolist()):
                reached.add(other)
                front.append(other)
    return sorted(reached)


def _assemble(cloud: Array, rings: list[list[int]]) -> Polyhedron:
    used = sorted({i for ring in rings for i in ring})
    number = {old: new for new, old in enumerate(used)}
    vertices = cloud[used]
    normals = np.array([_normal(cloud[ring]) for ring in rings])
    order = sorted(range(len(rings)), key=lambda f: tuple(-np.round(normals[f], 9)))
    faces = tuple(tuple(number[i] for i in rings[f]) for f in order)
    starts = [face.index(min(face)) for face in faces]
    faces = tuple((*face[k:], *face[:k]) for face, k in zip(faces, starts, strict=True))
    normals = normals[order]
    edges = {(a, b) for face in faces for a, b in zip(face, (*face[1:], face[0]), strict=True)}
    if any(len(face) < 3 for face in faces) or any((b, a) not in edges for a, b in edges):
        raise CrowdedError(
            "a hull's points are too close together to tell its faces apart; leave out points "
            f"nearer than {COPLANAR:g} of its extent to a face or an edge"
        )
    offsets = np.array([
        float((vertices[list(face)] @ normal).mean())
        for face, normal in zip(faces, normals, strict=True)
    ])  # fmt: skip
    tails, heads = np.array(sorted(e for e in edges if e[0] < e[1])).T
    return Polyhedron(
        vertices, faces, normals, offsets, directions(vertices[heads] - vertices[tails])
    )


def _normal(ring: Array) -> Array:
    """Return the unit normal of a polygon (k, 3) by Newell's sum of cross products."""
    local = ring - ring[0]
    x, y, z = local.T
    u, v, w = local[np.arange(1, len(local) + 1) % len(local)].T
    total = np.array([(y * w - z * v).sum(), (z * u - x * w).sum(), (x * v - y * u).sum()])
    normal: Array = total / np.linalg.norm(total)
    return normal


def directions(vectors: Array) -> Array:
    """Return one unit vector (e, 3) per set of parallel ``vectors``, in order of appearance."""
    from scipy.spatial import cKDTree

    units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    tree = cKDTree(units)
    near = [tree.query_ball_point(sign * units, PARALLEL) for sign in (1.0, -1.0)]
    first = [min((*same, *opposite)) for same, opposite in zip(*near, strict=True)]
    distinct: Array = units[np.array(first) == np.arange(len(units))]
    return distinct


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
