"""Where fingers may be placed on a body's faces, between the points of any grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.geometry.polygon import Rectangle, rectangle_around
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.surface import INSIDE, Face, PlacementTable, named_faces, owners, usable


@dataclass(frozen=True)
class Anywhere:
    """That fingers may be placed anywhere on faces, not on a grid's points alone.

    Attributes:
        faces: names of the faces.
        margin: least distance from a face's rim.
        gap: by how much a plan may be dearer than any other, relatively, to count as optimal.
    """

    faces: tuple[str, ...]
    margin: float
    gap: float


@dataclass(frozen=True, eq=False)
class Patch:
    """The part of a face where fingers may be placed: at least ``margin`` from its rim.

    Attributes:
        number: the face's, as ``surface.face_labels`` counts.
        rectangle: around the part; its axes are those of the face's grid.
        margin: least distance from the rim.
    """

    number: int
    rectangle: Rectangle
    margin: float
    _body: Body
    _face: Face

    @property
    def normal(self) -> Array:
        """Unit normal (3,), into the object."""
        inward: Array = -self._face.normal + 0.0  # no negative zeros
        return inward

    def points(self, places: Array) -> Array:
        """Return the points (k, 3) at places (k, 2) along the axes, from the middle on."""
        found: Array = self.rectangle.centre + places @ self.rectangle.axes
        return found

    def places(self, points: Array) -> Array:
        """Return where points (k, 3) of the plane are, as ``points`` takes them (k, 2)."""
        found: Array = (points - self.rectangle.centre) @ self.rectangle.axes.T
        return found

    def height(self, points: Array) -> Array:
        """Return how far points (k, 3) are above the plane, (k,)."""
        found: Array = (points - self.rectangle.centre) @ self._face.normal
        return found

    def offers(self, points: Array) -> BoolArray:
        """Return which points (k, 3) of the plane fingers may be placed at."""
        return usable(self._body, self._face, points, self.margin)

    def owners(self, points: Array) -> IntArray:
        """Return the piece of the body that each point (k, 3) belongs to."""
        if self._face.owner is None:
            return owners(self._body, points)
        return np.full(len(points), self._face.owner)

    def empty(self, points: Array, arm: float) -> BoolArray:
        """Return around which points (k, 3), as far as ``arm``, no finger may be placed.

        Where a placement is that near, the point's own distance from the rim tells: inside by the
        margin less ``arm`` at least, or outside by no more than ``arm`` less the margin.
        """
        region, slack = self._face.region, INSIDE * self._body.diagonal
        on, rim = region.contains(points, 0.0, slack), region.distance_to_rim(points)
        depth = np.where(on, rim, -rim)
        return np.asarray(depth < self.margin - arm - 2.0 * slack)


def patches(body: Body, faces: Literal["all"] | Sequence[str], margin: float) -> tuple[Patch, ...]:
    """Return where fingers may be placed on faces, those left out that are too narrow.

    Args:
        body: the object, object frame.
        faces: as for ``surface.placements``.
        margin: least distance from a face's rim.

    Raises:
        GeometryError: an unknown label.
    """
    found = []
    for number, face in named_faces(body, faces):
        around = rectangle_around(face.ring, face.normal)
        half = around.half - margin
        if (half >= 0.0).all():
            inner = Rectangle(around.centre, around.axes, half)
            found.append(Patch(number, inner, margin, body, face))
    return tuple(found)


def loose(
    found: Sequence[Patch], which: Sequence[int], points: Array, labels: tuple[str, ...]
) -> PlacementTable:
    """Return placements on no grid: points (k, 3), each on one of the patches."""
    spots = [points[i : i + 1] for i in range(len(points))]
    here = [found[f] for f in which]
    piece = [patch.owners(spot)[0] for patch, spot in zip(here, spots, strict=True)]
    return PlacementTable(
        points=points,
        normals=np.array([patch.normal for patch in here]).reshape(-1, 3),
        face=np.array([patch.number for patch in here], dtype=np.int64),
        cell=np.full((len(points), 2), -1),
        piece=np.array(piece, dtype=np.int64),
        labels=labels,
    )


def frames(found: Sequence[Patch], labels: tuple[str, ...]) -> PlacementTable:
    """Return three placements per patch, its middle and a unit along either axis.

    What is affine in the placement follows from them; they need not be on the face.
    """
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    middle = [patch.owners(patch.points(corner[:1]))[0] for patch in found]
    return PlacementTable(
        points=np.concatenate([patch.points(corner) for patch in found]),
        normals=np.repeat([patch.normal for patch in found], 3, axis=0),
        face=np.repeat([patch.number for patch in found], 3),
        cell=np.tile(corner.astype(np.int64), (len(found), 1)),
        piece=np.repeat(middle, 3),
        labels=labels,
    )
