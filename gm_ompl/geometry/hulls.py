"""Facets that files have bent are made plane; hulls of points; how a body can lie on its hull.

What follows, contacts above all, needs faces that are plane to much less than a file's rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray, fix
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.facets import CrowdedError, facets_of, neighbours_of
from gm_ompl.geometry.solids import Body, ConvexPiece, hull
from gm_ompl.geometry.triangles import TriangleMesh
from gm_ompl.geometry.welding import FINEST, used, welded

PLANE = 1e-9
"""Facets are plane once their vertices are this close to one, relative to the extent."""

ROUNDS = 60
"""Most rounds of fitting planes and moving vertices."""

FARTHEST = 20.0
"""A vertex moves no farther than this many times ``flat``, however flat its planes cross."""


@dataclass(frozen=True, eq=False)
class _Incidence:
    """Which vertices lie in which facet: row i says vertex[i] lies in facet[i]."""

    vertex: IntArray
    facet: IntArray
    count: int
    axis: IntArray
    """(count,), the axis along which the facet's normal points exactly, or -1."""


def flattened(mesh: TriangleMesh, flat: float) -> TriangleMesh:
    """Return the mesh with its facets made plane.

    Neighbouring triangles that lie within ``flat`` of one plane are a facet. A facet within
    ``flat`` of a plane across a coordinate axis is given that plane.
    """
    facets = facets_of(mesh.corners, neighbours_of(mesh.faces), flat)
    vertices = np.array(mesh.vertices)
    members = [np.unique(mesh.faces[rows]) for rows in facets]
    axis = np.array([_axis(vertices[m], flat) for m in members], dtype=np.int64)
    kept = [k for k, m in enumerate(members) if len(m) > 3 or axis[k] >= 0]
    if not kept:
        return mesh
    rows = _Incidence(
        vertex=np.concatenate([members[k] for k in kept]),
        facet=np.repeat(np.arange(len(kept)), [len(members[k]) for k in kept]),
        count=len(kept),
        axis=axis[kept],
    )
    for _ in range(ROUNDS):
        normals, gaps = _planes(vertices, rows)
        if np.abs(gaps).max() <= PLANE * mesh.extent:
            break
        vertices -= _steps(normals, gaps, rows, len(vertices), FARTHEST * flat)
    return TriangleMesh(vertices, mesh.faces)


def _axis(points: Array, flat: float) -> int:
    spread = np.ptp(points, axis=0)
    axis = int(spread.argmin())
    return axis if spread[axis] <= 2.0 * flat and spread[axis] < 1e-3 * spread.max() else -1


def _planes(vertices: Array, rows: _Incidence) -> tuple[Array, Array]:
    """Return the facets' normals (f, 3), and per row how far its vertex is above the plane."""
    points, counts = vertices[rows.vertex], np.bincount(rows.facet)
    middle = np.zeros((rows.count, 3))
    np.add.at(middle, rows.facet, points)
    local = points - (middle / counts[:, None])[rows.facet]
    spread = np.zeros((rows.count, 3, 3))
    np.add.at(spread, rows.facet, local[:, :, None] * local[:, None, :])
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    across = rows.axis >= 0
    normals[across] = np.eye(3)[rows.axis[across]]
    return normals, np.einsum("ij,ij->i", local, normals[rows.facet])


def _steps(normals: Array, gaps: Array, rows: _Incidence, count: int, farthest: float) -> Array:
    """Return the least steps (v, 3) that bring every vertex nearest to all its planes."""
    n = normals[rows.facet]
    gram, pull = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(gram, rows.vertex, n[:, :, None] * n[:, None, :])
    np.add.at(pull, rows.vertex, n * gaps[:, None])
    values, frames = np.linalg.eigh(gram)
    along = np.einsum("vij,vi->vj", frames, pull)
    steps = np.where(values > 1e-9, along / np.where(values > 1e-9, values, 1.0), 0.0)
    steps[np.abs(steps) > farthest] = 0.0
    moved: Array = np.einsum("vij,vj->vi", frames, steps)
    return moved


GROWN = 6
"""How often ``flat`` grows tenfold where a hull's corners are crowded."""


def hull_mesh(points: Array) -> TriangleMesh:
    """Return the convex hull of points (n, 3) as triangles that face outward.

    Raises:
        GeometryError: they lie in one plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    middle = points.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    local = (points - middle) / size
    try:
        found = ConvexHull(local)
    except (QhullError, ValueError):
        raise GeometryError("the points all lie in one plane, or nearly so") from None
    triangles = found.simplices.astype(np.int64)
    a, b, c = local[triangles].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return TriangleMesh(*used(points, triangles))


def clean_hull(mesh: TriangleMesh, flat: float) -> ConvexPiece:
    """Return a convex surface as a piece, its facets within ``flat`` of a plane made plane.

    Where its corners are too close together to tell faces apart, or to tell the same ones when
    they are read again, those are joined and ``flat`` grows, tenfold each time.

    Raises:
        GeometryError: they stay too close.
    """
    for k in range(GROWN):
        grown = 10.0**k * flat
        try:
            if k > 0:
                mesh = hull_mesh(welded(mesh.vertices, mesh.faces, grown)[0])
            once = hull(flattened(mesh, grown).vertices)
            twice = hull(once.vertices)
        except CrowdedError:
            continue
        if len(once.faces) == len(twice.faces):
            return twice
    raise GeometryError(f"points within {grown:.3g} of each other leave no faces that can be told")


def whole_hull(body: Body) -> ConvexPiece:
    """Return the convex hull of a body, however close together corners of its pieces lie."""
    if len(body.pieces) == 1:
        return body.pieces[0]
    return clean_hull(hull_mesh(body.vertices), FINEST * body.diagonal)


def triangulated(piece: ConvexPiece) -> TriangleMesh:
    """Return a piece's surface as triangles."""
    fans = [
        (face[0], face[k], face[k + 1]) for face in piece.faces for k in range(1, len(face) - 1)
    ]
    return TriangleMesh(piece.vertices, np.array(fans))


@dataclass(frozen=True, eq=False)
class RestingPose:
    """A way to lie.

    Attributes:
        down: (3,), unit, the direction of the body's frame that points down.
        height: of the origin, the centre of mass, above the floor.
        tilt: the angle by which the body can be tilted before it falls over, in radians.
        corners: how many corners it stands on.
    """

    down: Array
    height: float
    tilt: float
    corners: int

    def __post_init__(self) -> None:
        fix(self, down=(3,))

    @property
    def rotation(self) -> Array:
        """The least turn from the body's frame to the world's, as a quaternion (w, x, y, z)."""
        x, y, z = self.down.tolist()
        if z > 1.0 - 1e-12:
            return np.array([0.0, 1.0, 0.0, 0.0])
        # From ``down`` to (0, 0, -1): half-way between the two.
        turn = np.array([1.0 - z, -y, x, 0.0])
        unit: Array = turn / np.linalg.norm(turn) + 0.0
        return unit


def resting_poses(body: Body) -> tuple[RestingPose, ...]:
    """Return the stable ways in which a body lies on a floor, the steadiest first.

    Args:
        body: its centre of mass is the origin.
    """
    whole = whole_hull(body)
    found = []
    for face, normal, height in zip(
        whole.faces, whole.face_normals, whole.face_offsets.tolist(), strict=True
    ):
        limits.check()
        ring = whole.vertices[list(face)]
        sides = np.roll(ring, -1, axis=0) - ring
        inward = np.cross(normal, sides)
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        inside = np.einsum("ij,ij->i", inward, height * normal - ring)
        if inside.min() > 1e-9 * body.diagonal:
            tilt = float(np.arctan2(inside.min(), height))
            found.append(RestingPose(normal, height, tilt, len(face)))
    return tuple(sorted(found, key=lambda pose: -pose.tilt))
