"""What a hand's links look like, and where they are along joint paths: for pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from gm_ompl.arrays import Array
from gm_ompl.hand.model import HandModel


class LinkLook(NamedTuple):
    """A link's solid, as it collides.

    Attributes:
        triangles: (t, 3, 3), its convex hull, in the solid's own frame.
    """

    triangles: Array


def looks(model: HandModel) -> tuple[LinkLook, ...]:
    """Return a hand's solids."""
    return tuple(LinkLook(_hull(points)) for points in model.solids())


def poses(model: HandModel, rows: Sequence[Sequence[float]]) -> Array:
    """Return (m, s, 7), positions and quaternions (w, x, y, z) of solids in joint rows (m, k)."""
    found = []
    for q in rows:
        model.place(np.array(q))
        found.append(model.solid_poses())
    return np.array(found)


def _hull(points: Array) -> Array:
    hull = ConvexHull(points)
    triangles: Array = points[hull.simplices]
    middle = points[hull.vertices].mean(axis=0)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = np.einsum("ij,ij->i", normals, triangles[:, 0] - middle) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles
