"""Hulls of points as files give them: rounded, crowded, bent; and how bodies lie on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, fix
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.facets import CrowdedError
from gm_ompl.geometry.flattening import flattened
from gm_ompl.geometry.solids import Body, ConvexPiece, hull
from gm_ompl.geometry.triangles import TriangleMesh
from gm_ompl.geometry.welding import FINEST, used, welded

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
        ring = whole.vertices[list(face)]
        sides = np.roll(ring, -1, axis=0) - ring
        inward = np.cross(normal, sides)
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        inside = np.einsum("ij,ij->i", inward, height * normal - ring)
        if inside.min() > 1e-9 * body.diagonal:
            tilt = float(np.arctan2(inside.min(), height))
            found.append(RestingPose(normal, height, tilt, len(face)))
    return tuple(sorted(found, key=lambda pose: -pose.tilt))
