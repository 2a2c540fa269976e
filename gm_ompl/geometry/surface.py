"""The discrete fingertip placements on a body's faces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray, fix
from gm_ompl.errors import GeometryError, did_you_mean
from gm_ompl.geometry.polygon import convex_hull, plane_basis, rectangle_around
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.triangles import PlanarFace


@dataclass(frozen=True, eq=False)
class PlacementTable:
    """All discrete fingertip placements, object frame; a placement is its row number.

    Attributes:
        points: (P, 3), the contact point on the surface.
        normals: (P, 3), unit, pointing into the object.
        face: (P,), index into ``labels``.
        cell: (P, 2), the grid cell on that face; (-1, -1) where the placement is on no grid.
        piece: (P,), the convex piece of the body that the face belongs to.
        labels: the faces' names ("+x", ... for a box, "0", "1", ... for a hull).
    """

    points: Array
    normals: Array
    face: IntArray
    cell: IntArray
    piece: IntArray
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        fix(self, points=(None, 3), normals=(None, 3))
        for name in ("face", "cell", "piece"):
            whole = np.array(getattr(self, name), dtype=np.int64)
            whole.flags.writeable = False
            object.__setattr__(self, name, whole)

    def __len__(self) -> int:
        return len(self.points)

    def centres(self, radius: float) -> Array:
        """Return the fingertip centres (P, 3), object frame: one radius out along the normal."""
        outward: Array = self.points - radius * self.normals
        return outward

    def find(self, label: str, cell: Sequence[int]) -> int | None:
        """Return the placement on face ``label`` at ``cell``, or None if there is none."""
        if label not in self.labels or min(cell) < 0:
            return None
        hits = np.flatnonzero(
            (self.face == self.labels.index(label)) & (self.cell == np.asarray(cell)).all(axis=1)
        )
        return int(hits[0]) if len(hits) else None

    def find_point(self, label: str, point: Sequence[float]) -> int | None:
        """Return the placement on face ``label`` at a point that is on no grid, or None."""
        if label not in self.labels:
            return None
        loose = (self.face == self.labels.index(label)) & (self.cell < 0).all(axis=1)
        hits = np.flatnonzero(loose & (self.points == np.asarray(point)).all(axis=1))
        return int(hits[0]) if len(hits) else None

    def joined(self, other: PlacementTable) -> PlacementTable:
        """Return these placements, and behind them those of another table of the same body."""
        return PlacementTable(
            np.concatenate([self.points, other.points]),
            np.concatenate([self.normals, other.normals]),
            np.concatenate([self.face, other.face]),
            np.concatenate([self.cell, other.cell]),
            np.concatenate([self.piece, other.piece]),
            self.labels,
        )

    def at(self, rows: Sequence[int]) -> PlacementTable:
        """Return some of the placements, in this order."""
        some = np.array(rows, dtype=np.int64)
        return PlacementTable(
            self.points[some], self.normals[some], self.face[some], self.cell[some],
            self.piece[some], self.labels,
        )  # fmt: skip


INSIDE = 1e-9
"""A cell's centre this close to its face's border, relative to D, still lies on the face."""


def placements(
    body: Body,
    grid: tuple[int, int],
    faces: Literal["all"] | Sequence[str] = "all",
    margin: float = 0.0,
) -> PlacementTable:
    """Return the placements on a grid over each face, rows by face, then cell, row-major.

    On a face, the grid covers the bounding rectangle of least area with a side along one of the
    edges of the face's convex hull; cells with their centre off the face, in a hole or nearer to
    the rim than ``margin`` are left out, and so are those that another piece of the body covers.
    The rectangle's sides are taken in the order of the axes that they are closest to (x, y, z),
    each pointing along its axis: on a box, the two remaining axes.

    Args:
        body: the object, object frame.
        grid: cells along the rectangle's first and second side.
        faces: labels of the faces to use, or "all". Labels are a box's "+x", "-x", ..., "-z", a
            hull's or mesh's "0", "1", ...; a body of several pieces numbers all its faces on.
        margin: least distance of a placement from its face's rim.

    Raises:
        GeometryError: an unknown label, or a grid without cells.
    """
    if min(grid) < 1:
        raise GeometryError(f"a grid needs at least one cell each way, not {tuple(grid)}")
    labels = face_labels(body)
    none = np.zeros(0, dtype=np.int64)
    points, normals, face = [np.zeros((0, 3))], [np.zeros((0, 3))], [none]
    cell, piece = [none.reshape(0, 2)], [none]
    for number, patch, spots in _spots(body, grid, faces):
        kept = np.flatnonzero(usable(body, patch, spots, margin))
        points.append(spots[kept])
        normals.append(np.tile(-patch.normal, (len(kept), 1)))
        face.append(np.full(len(kept), number))
        cell.append(np.stack(np.divmod(kept, grid[1]), axis=1))
        piece.append(owners(body, spots[kept]) if patch.owner is None
                     else np.full(len(kept), patch.owner))  # fmt: skip
    return PlacementTable(
        points=np.concatenate(points),
        normals=np.concatenate(normals) + 0.0,  # no negative zeros
        face=np.concatenate(face),
        cell=np.concatenate(cell),
        piece=np.concatenate(piece),
        labels=labels,
    )


def room(body: Body, grid: tuple[int, int], faces: Literal["all"] | Sequence[str]) -> float | None:
    """Return the largest margin that leaves a placement; None where none is left without one.

    Args:
        body: the object, object frame.
        grid: as for ``placements``.
        faces: as for ``placements``.
    """
    found: list[float] = []
    for _, patch, spots in _spots(body, grid, faces):
        kept = spots[usable(body, patch, spots, 0.0)]
        found += patch.region.distance_to_rim(kept).tolist()
    return max(found, default=None)


def _spots(
    body: Body, grid: tuple[int, int], faces: Literal["all"] | Sequence[str]
) -> Iterator[tuple[int, Face, Array]]:
    """Yield per wanted face its number, itself and its cells' centres (k, 3)."""
    for number, patch in named_faces(body, faces):
        yield number, patch, rectangle_around(patch.ring, patch.normal).cells(grid)


def named_faces(body: Body, faces: Literal["all"] | Sequence[str]) -> Iterator[tuple[int, Face]]:
    """Yield the number and the extent of every face that is named.

    Raises:
        GeometryError: an unknown label.
    """
    wanted = _wanted(face_labels(body), faces)
    for number, patch in enumerate(_faces_of(body)):
        if number in wanted:
            yield number, patch


def faces_of(body: Body) -> Iterator[tuple[str, Face]]:
    """Yield the name and the extent of every face of the body."""
    yield from zip(face_labels(body), _faces_of(body), strict=True)


def face_areas(body: Body) -> Array:
    """Return the area of every face of the body, in the order of ``face_labels``, (f,)."""
    return np.array([patch.region.area for patch in _faces_of(body)])


def face_labels(body: Body) -> tuple[str, ...]:
    """Return the names of the body's faces: its piece's own, or numbers over all its faces."""
    if len(body.pieces) == 1:
        return body.pieces[0].labels
    count = len(body.surface) or sum(len(piece.faces) for piece in body.pieces)
    return tuple(str(k) for k in range(count))


@dataclass(frozen=True, eq=False)
class Face:
    """One face of a body.

    Attributes:
        region: its exact extent.
        ring: (k, 3), the corners of its convex hull, counter-clockwise from outside.
        owner: the number of the piece whose face it is; None for a mesh's surface.
    """

    region: PlanarFace
    ring: Array
    owner: int | None = None

    @property
    def normal(self) -> Array:
        """Its unit normal (3,), outward."""
        return self.region.normal


def _faces_of(body: Body) -> Iterator[Face]:
    for plane in body.surface:
        yield Face(plane, _outline(plane, body.diagonal))
    if body.surface:
        return
    for owner, piece in enumerate(body.pieces):
        for corners, normal in zip(piece.faces, piece.face_normals, strict=True):
            ring = piece.vertices[list(corners)]
            fan = np.array([(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)])
            rim = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
            yield Face(PlanarFace(fan, rim, normal), ring, owner)


def _outline(plane: PlanarFace, D: float) -> Array:
    """Return the corners of a planar face's convex hull, counter-clockwise from outside."""
    corners = plane.rim[:, 0]
    flat = [(float(x), float(y)) for x, y in corners @ plane_basis(plane.normal).T]
    ring: Array = corners[convex_hull(flat, INSIDE * D)]
    return ring


def usable(body: Body, patch: Face, spots: Array, margin: float) -> BoolArray:
    """Whether points (k, 3) in a face's plane may be placements."""
    usable = patch.region.contains(spots, margin, INSIDE * body.diagonal)
    return usable if patch.owner is None else usable & ~_covered(body, patch, spots)


def owners(body: Body, spots: Array) -> IntArray:
    """Return per point (k, 3) on the surface the piece that it lies on."""
    depths = [
        (spots @ piece.face_normals.T - piece.face_offsets).max(axis=1) for piece in body.pieces
    ]
    owners: IntArray = np.argmin(np.array(depths), axis=0)
    return owners


def _wanted(labels: tuple[str, ...], faces: Literal["all"] | Sequence[str]) -> set[int]:
    if faces == "all":
        return set(range(len(labels)))
    for name in faces:
        if name not in labels:
            raise GeometryError(
                f"no face {name!r}{did_you_mean(name, labels)}; faces are: {', '.join(labels)}"
            )
    return {labels.index(name) for name in faces}


def _covered(body: Body, patch: Face, spots: Array) -> BoolArray:
    """Whether another piece covers points (k, 3) on one piece's face, its surface included.

    Where the faces of two pieces lie in one plane, a point on their seam belongs to the first.
    """
    covered = np.zeros(len(spots), dtype=bool)
    slack = INSIDE * body.diagonal
    for number, piece in enumerate(body.pieces):
        if number == patch.owner:
            continue
        heights = spots @ piece.face_normals.T - piece.face_offsets
        flush = (piece.face_normals @ patch.normal >= 1.0 - INSIDE) & (np.abs(heights) <= slack)
        if patch.owner is not None and number > patch.owner:
            covered |= (heights.max(axis=1) <= slack) & ~flush.any(axis=1)
        else:
            covered |= heights.max(axis=1) <= slack
    return covered
