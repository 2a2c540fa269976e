"""Closed triangle meshes: what makes one usable, and its planar faces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from gm_ompl.arrays import Array, BoolArray, IntArray, fix, read_only
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.facets import COPLANAR, facets_of, neighbours_of

EMPTY = 1e-9
"""A volume below this times D^3 is none."""


class OpenMeshError(GeometryError):
    """Triangles do not close: something is missing, or comes twice."""


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A closed surface of triangles, outward by the right-hand rule.

    Attributes:
        vertices: (v, 3).
        faces: (t, 3), numbers of the vertices.
    """

    vertices: Array
    faces: IntArray

    def __post_init__(self) -> None:
        fix(self, vertices=(None, 3))
        faces = np.array(self.faces, dtype=np.int64).reshape(-1, 3)
        faces.flags.writeable = False
        object.__setattr__(self, "faces", faces)

    @cached_property
    def corners(self) -> Array:
        """The triangles' corners (t, 3, 3)."""
        return read_only(self.vertices[self.faces], (None, 3, 3), "corners")

    @cached_property
    def extent(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def volume(self) -> float:
        """Enclosed volume; negative where the triangles face inward."""
        local = self.corners - self.vertices.mean(axis=0)
        return float(np.linalg.det(local).sum() / 6.0)


@dataclass(frozen=True, eq=False)
class PlanarFace:
    """A connected plane part of a body's surface; it may have holes.

    Attributes:
        triangles: (t, 3, 3), their union is the face.
        rim: (r, 2, 3), the edges around it and around its holes.
        normal: (3,), unit, outward.
    """

    triangles: Array
    rim: Array
    normal: Array

    def __post_init__(self) -> None:
        fix(self, triangles=(None, 3, 3), rim=(None, 2, 3), normal=(3,))

    @cached_property
    def area(self) -> float:
        """Its area, holes left out."""
        a, b, c = self.triangles.transpose(1, 0, 2)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)

    def contains(self, points: Array, margin: float, slack: float) -> BoolArray:
        """Return which points (k, 3) of its plane lie on it, at least ``margin`` from its rim.

        Args:
            points: in the face's plane.
            margin: least distance from rim and holes.
            slack: a point so close to a triangle still lies on it; taken off the margin, too.
        """
        on = np.zeros(len(points), dtype=bool)
        for corners in self.triangles:
            sides = np.roll(corners, -1, axis=0) - corners
            inward = np.cross(self.normal, sides)
            lengths = np.linalg.norm(inward, axis=1)
            inward = inward / np.where(lengths > 0.0, lengths, 1.0)[:, None]
            heights = points @ inward.T - np.einsum("ij,ij->i", inward, corners)
            on |= heights.min(axis=1) >= -slack
        if margin > 0.0:
            on &= self.distance_to_rim(points) >= margin - slack
        return on

    def distance_to_rim(self, points: Array) -> Array:
        """Return how far points (k, 3) of its plane are from its rim and holes, (k,)."""
        nearest = np.full(len(points), np.inf)
        for tail, head in self.rim:
            along = head - tail
            t = np.clip((points - tail) @ along / (along @ along), 0.0, 1.0)
            gaps = np.linalg.norm(points - tail - t[:, None] * along, axis=1)
            nearest = np.minimum(nearest, gaps)
        return nearest


def checked(vertices: ArrayLike, faces: ArrayLike) -> TriangleMesh:
    """Return the mesh, which must enclose a volume.

    Triangles without area are dropped.

    Raises:
        GeometryError: numbers that are no mesh; open, torn, flat or inside out.
    """
    cloud, rows = np.array(vertices, dtype=np.float64), np.array(faces, dtype=np.int64)
    if cloud.ndim != 2 or cloud.shape[1:] != (3,) or rows.ndim != 2 or rows.shape[1:] != (3,):
        raise GeometryError("a mesh needs vertices and faces of 3 numbers each")
    if not np.isfinite(cloud).all():
        raise GeometryError("a mesh's vertices must be finite")
    if len(rows) < 4:
        raise GeometryError(f"a closed mesh has at least 4 triangles, not {len(rows)}")
    if rows.min() < 0 or rows.max() >= len(cloud):
        wrong = int(rows.min() if rows.min() < 0 else rows.max())
        raise GeometryError(f"a face names vertex {wrong}; there are {len(cloud)}, from 0")
    rows = rows[(rows != np.roll(rows, -1, axis=1)).all(axis=1)]
    mesh = TriangleMesh(cloud, rows)
    _check_closed(mesh)
    size = mesh.volume / mesh.extent**3 if mesh.extent > 0.0 else 0.0
    if abs(size) < EMPTY:
        raise GeometryError(
            f"the mesh encloses no volume ({mesh.volume:.3g} at {mesh.extent:.3g} across)"
        )
    if size < 0.0:
        raise GeometryError(
            "the mesh is inside out: its volume is negative; turn its triangles around"
        )
    return mesh


def _check_closed(mesh: TriangleMesh) -> None:
    """Raise unless every edge joins exactly two triangles that agree on the outside."""
    count = len(mesh.vertices)
    tails, heads = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    there, back = np.sort(tails * count + heads), np.sort(heads * count + tails)
    unpaired = len(np.setdiff1d(there, back))
    if unpaired:
        raise OpenMeshError(
            f"the mesh is not watertight: {unpaired} of its edges have no triangle on the other "
            "side, or one that faces the other way"
        )
    repeated = len(there) - len(np.unique(there))
    if repeated:
        raise OpenMeshError(
            f"the mesh is no surface: {repeated} of its edges are shared by more than two triangles"
        )


def planar_faces(mesh: TriangleMesh) -> tuple[PlanarFace, ...]:
    """Return the planar faces of the surface: neighbouring triangles in one plane, merged.

    Triangles within 1e-7 of the mesh's extent of a plane are a face. Faces are ordered by normal
    (largest x first, then y, then z), then by how far out their plane lies, then by their place.
    """
    crossed = np.cross(
        mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0]
    )
    found: list[PlanarFace] = []
    for members in facets_of(mesh.corners, neighbours_of(mesh.faces), COPLANAR * mesh.extent):
        total = crossed[members].sum(axis=0)
        size = float(np.linalg.norm(total))
        if size > (COPLANAR * mesh.extent) ** 2:  # else a sliver without area
            rim = _rim(mesh.faces[members])
            found.append(PlanarFace(mesh.corners[members], mesh.vertices[rim], total / size))

    def place(face: PlanarFace) -> tuple[float, ...]:
        middle = face.triangles.mean(axis=(0, 1)) / mesh.extent
        out = face.normal @ (face.triangles[0, 0] / mesh.extent)
        return tuple(-np.round([*face.normal, out, *middle], 6))

    return tuple(sorted(found, key=place))


def _rim(faces: IntArray) -> IntArray:
    """Return the edges (r, 2) that only one of the triangles has."""
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    known = {(int(a), int(b)) for a, b in edges}
    kept = [(a, b) for a, b in sorted(known) if (b, a) not in known]
    return np.array(kept, dtype=np.int64).reshape(-1, 2)
