"""The discrete fingertip placements on a body's faces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.errors import GeometryError, did_you_mean
from gm_ompl.geometry.placements import PlacementTable
from gm_ompl.geometry.solids import Body, ConvexPiece

TIE = 1e-9
"""Relative difference below which two bounding rectangles have equal areas."""

INSIDE = 1e-9
"""A cell's centre this close to its face's border, relative to D, still lies on the face."""


@dataclass(frozen=True, eq=False)
class Rectangle:
    """A rectangle in space: ``centre`` +- ``half[k] * axes[k]``; shapes (3,), (2, 3), (2,)."""

    centre: Array
    axes: Array
    half: Array

    def cells(self, grid: tuple[int, int]) -> Array:
        """Return the cell centres (m1 * m2, 3) of a cell-centred grid, row-major."""
        first, second = ((np.arange(m) + 0.5) / m * 2.0 - 1.0 for m in grid)
        steps = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1).reshape(-1, 2)
        points: Array = self.centre + (steps * self.half) @ self.axes
        return points


def placements(
    body: Body, grid: tuple[int, int], faces: Literal["all"] | Sequence[str] = "all"
) -> PlacementTable:
    """Return the placements on a grid over each face, rows by face, then cell, row-major.

    On a face, the grid covers the bounding rectangle of least area with a side along one of the
    face's edges; cells with their centre off the face are left out, and so are those that another
    piece of the body covers. The rectangle's sides are taken in the order of the axes that they
    are closest to (x, y, z), each pointing along its axis: on a box, the two remaining axes.

    Args:
        body: the object, object frame.
        grid: cells along the rectangle's first and second side.
        faces: labels of the faces to use, or "all". Labels are a box's "+x", "-x", ..., "-z", a
            hull's "0", "1", ...; a body of several pieces numbers all its faces on.

    Raises:
        GeometryError: an unknown label, or a grid without cells.
    """
    if min(grid) < 1:
        raise GeometryError(f"a grid needs at least one cell each way, not {tuple(grid)}")
    labels = face_labels(body)
    wanted = _wanted(labels, faces)
    points, normals, face, cell, piece = [], [], [], [], []
    for number, (owner, index) in enumerate(_faces_of(body)):
        if number not in wanted:
            continue
        part = body.pieces[owner]
        spots = bounding_rectangle(part, index).cells(grid)
        on = _on_face(part, spots, INSIDE * body.diagonal) & ~_covered(body, owner, spots)
        kept = np.flatnonzero(on)
        points.append(spots[kept])
        normals.append(np.tile(-part.face_normals[index], (len(kept), 1)))
        face.append(np.full(len(kept), number))
        cell.append(np.stack(np.divmod(kept, grid[1]), axis=1))
        piece.append(np.full(len(kept), owner))
    return PlacementTable(
        points=np.concatenate(points),
        normals=np.concatenate(normals) + 0.0,  # no negative zeros
        face=np.concatenate(face),
        cell=np.concatenate(cell),
        piece=np.concatenate(piece),
        labels=labels,
    )


def face_labels(body: Body) -> tuple[str, ...]:
    """Return the names of the body's faces: its piece's own, or numbers over several pieces."""
    if len(body.pieces) == 1:
        return body.pieces[0].labels
    return tuple(str(k) for k, _ in enumerate(_faces_of(body)))


def bounding_rectangle(piece: ConvexPiece, face: int) -> Rectangle:
    """Return the rectangle of least area around a face with a side along one of its edges.

    Among equal areas the one whose first side is closest to x wins, then y, then z.
    """
    corners = piece.vertices[list(piece.faces[face])]
    normal = piece.face_normals[face]
    edges = np.roll(corners, -1, axis=0) - corners
    candidates = []
    for edge in edges / np.linalg.norm(edges, axis=1, keepdims=True):
        axes = _oriented(np.stack([edge, np.cross(normal, edge)]))
        reach = (corners - corners[0]) @ axes.T
        low, high = reach.min(axis=0), reach.max(axis=0)
        centre = corners[0] + (low + high) / 2 @ axes
        candidates.append(Rectangle(centre, axes, (high - low) / 2))
    least = min(float(r.half.prod()) for r in candidates)
    tied = [r for r in candidates if r.half.prod() <= least * (1.0 + TIE)]
    return min(tied, key=lambda r: tuple(-np.round(np.abs(r.axes[0]), 9)))


def _oriented(axes: Array) -> Array:
    """Point each of two directions along the axis it is closest to; lower axis first."""
    sizes = np.round(np.abs(axes), 9)  # rounded: equal components must not be told apart by noise
    closest = sizes.argmax(axis=1)
    signed = axes * np.sign(axes[[0, 1], closest])[:, None]
    first, second = (tuple(row) for row in sizes)
    swap = (closest[1], [-c for c in second]) < (closest[0], [-c for c in first])
    ordered: Array = signed[::-1] if swap else signed
    return ordered


def _faces_of(body: Body) -> Iterator[tuple[int, int]]:
    for owner, piece in enumerate(body.pieces):
        for index in range(len(piece.faces)):
            yield owner, index


def _wanted(labels: tuple[str, ...], faces: Literal["all"] | Sequence[str]) -> set[int]:
    if faces == "all":
        return set(range(len(labels)))
    for name in faces:
        if name not in labels:
            raise GeometryError(
                f"no face {name!r}{did_you_mean(name, labels)}; faces are: {', '.join(labels)}"
            )
    return {labels.index(name) for name in faces}


def _on_face(piece: ConvexPiece, spots: Array, slack: float) -> BoolArray:
    """Whether points (k, 3) in a face's plane lie on that face, that is in the piece."""
    heights: Array = spots @ piece.face_normals.T - piece.face_offsets
    inside: BoolArray = heights.max(axis=1) <= slack
    return inside


def _covered(body: Body, owner: int, spots: Array) -> BoolArray:
    """Whether points (k, 3) on one piece lie in another, its surface included."""
    covered = np.zeros(len(spots), dtype=bool)
    for number, piece in enumerate(body.pieces):
        if number != owner:
            covered |= _on_face(piece, spots, INSIDE * body.diagonal)
    return covered
