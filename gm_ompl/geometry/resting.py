"""How a body can lie on a floor: the faces of its hull that its weight holds down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, read_only
from gm_ompl.geometry.hulls import whole_hull
from gm_ompl.geometry.solids import Body


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
        object.__setattr__(self, "down", read_only(self.down, (3,), "down"))

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
