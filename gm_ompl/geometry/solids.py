"""Solid bodies as lists of convex pieces."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from gm_ompl.arrays import Array, fix, read_only
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.facets import polyhedron
from gm_ompl.geometry.triangles import PlanarFace

BOX_LABELS = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Names of a box's faces, in order."""

_BOX_FACES = ((4, 6, 7, 5), (0, 1, 3, 2), (2, 3, 7, 6), (0, 4, 5, 1), (1, 5, 7, 3), (0, 2, 6, 4))
"""Corners of a box's faces; a corner's number has bits x, y, z (4, 2, 1), 1 on the high side."""


@dataclass(frozen=True, eq=False)
class ConvexPiece:
    """A convex polyhedron.

    Attributes:
        vertices: (v, 3), its corners.
        faces: per face, the corners' numbers, counter-clockwise seen from outside; coplanar
            triangles are merged.
        face_normals: (f, 3), unit, outward.
        face_offsets: (f,), so that ``face_normals @ p <= face_offsets`` inside.
        edge_directions: (e, 3), unit, one per set of parallel edges.
        is_box: whether it is a box (a rectangular cuboid, at any orientation).
        labels: the faces' names ("+x", ... or "0", "1", ...).
    """

    vertices: Array
    faces: tuple[tuple[int, ...], ...]
    face_normals: Array
    face_offsets: Array
    edge_directions: Array
    is_box: bool = False
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        f = len(self.faces)
        fix(self, vertices=(None, 3), face_normals=(f, 3), face_offsets=(f,))
        fix(self, edge_directions=(None, 3))

    @cached_property
    def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Least and greatest coordinates of the axis-parallel bounding box."""
        return tuple(self.vertices.min(axis=0).tolist()), tuple(self.vertices.max(axis=0).tolist())

    @cached_property
    def edge_ends(self) -> tuple[Array, Array]:
        """One end of every edge, and the vector to its other end, (e, 3) each."""
        pairs = sorted({
            (min(a, b), max(a, b))
            for face in self.faces
            for a, b in zip(face, (*face[1:], face[0]), strict=True)
        })  # fmt: skip
        ends = self.vertices[np.array(pairs)]
        return ends[:, 0], ends[:, 1] - ends[:, 0]

    def nearest_on_edges(self, points: Array) -> Array:
        """Return the points (n, 3) of the edges that are nearest to ``points`` (n, 3)."""
        starts, spans = self.edge_ends
        along = points @ spans.T - np.einsum("ij,ij->i", starts, spans)
        share = np.clip(along / np.einsum("ij,ij->i", spans, spans), 0.0, 1.0)
        candidates = starts + share[:, :, None] * spans
        ways = points[:, None] - candidates
        best = np.einsum("ijk,ijk->ij", ways, ways).argmin(axis=1)
        nearest: Array = candidates[np.arange(len(points)), best]
        return nearest


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body: the union of its convex pieces, all in one frame.

    Attributes:
        pieces: they do not overlap; faces where two of them meet are inside the body.
        surface: the planar faces of a mesh's true surface; empty where the pieces' own faces are
            the surface.
    """

    pieces: tuple[ConvexPiece, ...]
    surface: tuple[PlanarFace, ...] = ()

    @cached_property
    def vertices(self) -> Array:
        """All pieces' corners, (v, 3)."""
        return read_only(
            np.concatenate([piece.vertices for piece in self.pieces]), (None, 3), "vertices"
        )

    @cached_property
    def diagonal(self) -> float:
        """D, the diagonal of the bounding box along the body's own axes."""
        corners = self.vertices
        return float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))


def box(low: ArrayLike, high: ArrayLike) -> ConvexPiece:
    """Return the axis-parallel box between two corners; faces in the order +x, -x, ..., -z.

    Raises:
        GeometryError: a side is not positive.
    """
    corners = np.array([low, high], dtype=np.float64)
    if corners.shape != (2, 3):
        raise GeometryError(f"a box needs two corners of 3 numbers each, not {low!r}, {high!r}")
    if not np.isfinite(corners).all():
        raise GeometryError(f"a box's corners must be finite, not {low!r}, {high!r}")
    if not (corners[1] > corners[0]).all():
        raise GeometryError(
            f"a box's sides must be positive, but from {corners[0].tolist()} "
            f"to {corners[1].tolist()} they are {(corners[1] - corners[0]).tolist()}"
        )
    bits = np.array(list(itertools.product((0, 1), repeat=3)))
    normals = np.repeat(np.eye(3), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]
    return ConvexPiece(
        vertices=corners[bits, np.arange(3)],
        faces=_BOX_FACES,
        face_normals=normals + 0.0,  # no negative zeros
        face_offsets=np.stack([corners[1], -corners[0]], axis=1).ravel(),
        edge_directions=np.eye(3),
        is_box=True,
        labels=BOX_LABELS,
    )


def hull(points: ArrayLike) -> ConvexPiece:
    """Return the convex hull of ``points`` (n, 3), coplanar triangles merged.

    Points within 1e-7 of the hull's extent of a common plane form one face. Corners keep the
    order of ``points``; faces are ordered by their normals, largest x first, then y, then z.

    Raises:
        GeometryError: fewer than four points, or all in one plane, or NaN or infinite.
    """
    cloud = np.array(points, dtype=np.float64)
    if cloud.ndim != 2 or cloud.shape[1:] != (3,):
        raise GeometryError(f"a hull needs points of 3 numbers each, not shape {cloud.shape}")
    if len(cloud) < 4:
        raise GeometryError(f"a hull needs at least 4 points, not {len(cloud)}")
    if not np.isfinite(cloud).all():
        row = int(np.flatnonzero(~np.isfinite(cloud).all(axis=1))[0])
        raise GeometryError(f"a hull's points must be finite; point {row} is {cloud[row].tolist()}")
    found = polyhedron(cloud)
    return ConvexPiece(
        vertices=found.vertices,
        faces=found.faces,
        face_normals=found.normals,
        face_offsets=found.offsets,
        edge_directions=found.edge_directions,
        is_box=found.is_box,
        labels=tuple(str(f) for f in range(len(found.faces))),
    )


def shifted(body: Body, offset: ArrayLike) -> Body:
    """Return ``body`` moved by ``offset`` (3,)."""
    return moved(body, np.eye(3), np.asarray(offset, dtype=np.float64))


def moved(body: Body, rotation: Array, offset: Array) -> Body:
    """Return ``body`` turned by ``rotation`` (3, 3) about the origin, then moved by ``offset``."""

    def points(old: Array) -> Array:
        new: Array = old @ rotation.T + offset
        return new

    def ways(old: Array) -> Array:
        new: Array = old @ rotation.T + 0.0  # no negative zeros
        return new

    pieces = []
    for piece in body.pieces:
        normals = ways(piece.face_normals)
        pieces.append(
            replace(
                piece,
                vertices=points(piece.vertices),
                face_normals=normals,
                face_offsets=piece.face_offsets + normals @ offset,
                edge_directions=ways(piece.edge_directions),
            )
        )
    surface = tuple(
        replace(f, triangles=points(f.triangles), rim=points(f.rim), normal=ways(f.normal))
        for f in body.surface
    )
    return Body(tuple(pieces), surface)


@dataclass(frozen=True, eq=False)
class MassProperties:
    """How a body's mass is spread.

    Attributes:
        volume: the pieces' volumes added up.
        centre: (3,), the centre of mass, in the body's frame.
        inertia: (3, 3), about the centre of mass, along the body's axes.
    """

    volume: float
    centre: Array
    inertia: Array

    def __post_init__(self) -> None:
        fix(self, centre=(3,), inertia=(3, 3))


def mass_properties(body: Body, mass: float) -> MassProperties:
    """Return volume, centre of mass and inertia of a body of uniform density and given mass.

    The integrals are exact for polyhedra. Pieces must not overlap: an overlap would count twice.
    """
    corners = body.vertices
    origin = (corners.max(axis=0) + corners.min(axis=0)) / 2  # near the centre: no cancellation
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for piece in body.pieces:
        v, f, s = _moments(piece, origin)
        volume, first, second = volume + v, first + f, second + s
    offset = first / volume
    spread = (second / volume - np.outer(offset, offset)) * mass
    inertia = np.trace(spread) * np.eye(3) - spread
    return MassProperties(volume, origin + offset, (inertia + inertia.T) / 2)


def volume(piece: ConvexPiece) -> float:
    """Return the volume of one piece."""
    return _moments(piece, piece.vertices.mean(axis=0))[0]


def at_centre_of_mass(body: Body) -> tuple[Body, Array]:
    """Return the body moved so that its centre of mass is the origin, and where that was, (3,)."""
    centre = mass_properties(body, 1.0).centre
    return shifted(body, -centre), centre


def _moments(piece: ConvexPiece, origin: Array) -> tuple[float, Array, Array]:
    """Return the integrals of 1, x and x x^T over a piece, x taken from ``origin``.

    They are sums over the signed tetrahedra between the origin and the triangles of the surface.
    """
    triangles = np.array([
        (face[0], face[k], face[k + 1]) for face in piece.faces for k in range(1, len(face) - 1)
    ])  # fmt: skip
    corners = (piece.vertices - origin)[triangles]
    total = corners.sum(axis=1)
    sixfold = np.linalg.det(corners)
    second = np.einsum("t,tia,tib->ab", sixfold, corners, corners)
    second += np.einsum("t,ta,tb->ab", sixfold, total, total)
    return float(sixfold.sum() / 6.0), sixfold @ total / 24.0, second / 120.0
