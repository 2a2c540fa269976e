"""How far the surface of a shape is from the triangles that it stands for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.collision import surface_distances
from gm_ompl.geometry.solids import hull
from gm_ompl.geometry.triangles import TriangleMesh

SAMPLES = 1500
"""Points of either surface, and as many of its corners, at which their distance is taken."""


def deviation(before: Array, meshes: Sequence[TriangleMesh]) -> float:
    """Return the largest distance found between triangles (t, 3, 3) and the surface of a shape.

    What of the shape's pieces lies in other pieces is no surface.
    """
    after = np.concatenate([mesh.corners for mesh in meshes])
    rng = np.random.default_rng(0)
    there = surface_distances(after, _spots(before, rng))
    spots = [_spots(mesh.corners, rng) for mesh in meshes]
    if len(meshes) > 1:
        pieces = [hull(mesh.vertices) for mesh in meshes]
        slack = 1e-6 * float(np.linalg.norm(np.ptp(after.reshape(-1, 3), axis=0)))
        for k in range(len(spots)):
            for piece in pieces[:k] + pieces[k + 1 :]:
                heights = spots[k] @ piece.face_normals.T - piece.face_offsets
                spots[k] = spots[k][heights.max(axis=1, initial=-np.inf) > slack]
    back = surface_distances(before, np.concatenate(spots))
    return float(max(there.max(), back.max(initial=0.0)))


def _spots(corners: Array, rng: np.random.Generator) -> Array:
    """Return points of triangles: their corners, and some at random, by area."""
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    rows = rng.choice(len(corners), SAMPLES, p=areas / areas.sum())
    u, v = rng.random((2, SAMPLES, 1))
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
    cloud = np.unique(corners.reshape(-1, 3), axis=0)
    if len(cloud) > SAMPLES:
        cloud = cloud[rng.choice(len(cloud), SAMPLES, replace=False)]
    inner: Array = a[rows] + u * (b - a)[rows] + v * (c - a)[rows]
    return np.concatenate([cloud, inner])
