"""Volume, centre of mass and inertia of bodies with uniform density."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, read_only
from gm_ompl.geometry.solids import Body, ConvexPiece, shifted


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
        object.__setattr__(self, "centre", read_only(self.centre, (3,), "centre"))
        object.__setattr__(self, "inertia", read_only(self.inertia, (3, 3), "inertia"))


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
