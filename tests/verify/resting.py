"""Bodies in their resting poses, and how high scipy and trimesh say that they lie."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.spatial
import trimesh

import gm_ompl
from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about

Heights = tuple[float, float, float]
"""The height that ``rest`` finds, the exact one, and the body's size."""


def hull_in_resting_poses(seed: int) -> Iterator[Heights]:
    """Yield the heights of a random hull on each of its sides that it can lie on."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(6, 30)), 3)) * rng.uniform(0.01, 10.0)
    points += rng.normal(size=3) * 3.0
    yield from _lying({"hull": points}, points, _centre(points))


def notched_bar_in_resting_poses(seed: int) -> Iterator[Heights]:
    """Yield the heights of a sheared L-shaped bar, a mesh of two convex pieces, likewise."""
    rng = np.random.default_rng(seed)
    a, b, c, d, length = rng.uniform(0.5, 2.0, size=5)
    rim = np.array([[0, 0], [a + c, 0], [a + c, b], [a, b], [a, b + d], [0, b + d]])
    ends = [np.column_stack([rim, np.full(6, z)]) for z in (0.0, length)]
    shear = np.eye(3) + 0.3 * rng.normal(size=(3, 3))
    vertices = np.concatenate(ends) @ shear.T
    if np.linalg.det(shear) < 0:
        vertices[:, 0] *= -1.0
    caps = [(0, 1, 3), (1, 2, 3), (0, 3, 5), (3, 4, 5)]
    faces = [(i, k, j) for i, j, k in caps] + [(i + 6, j + 6, k + 6) for i, j, k in caps]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    solid = trimesh.Trimesh(vertices, faces, process=False)
    mesh = {"mesh": {"vertices": vertices, "faces": np.array(faces)}}
    yield from _lying(mesh, vertices, np.array(solid.center_mass))


def _centre(points: Array) -> Array:
    """Return the centre of mass of a hull: tetrahedra from its middle to scipy's triangles."""
    found = scipy.spatial.ConvexHull(points)
    middle, total, centre = points[found.vertices].mean(axis=0), 0.0, np.zeros(3)
    for triangle in points[found.simplices]:
        volume = abs(float(np.linalg.det(triangle - middle)))
        total, centre = total + volume, centre + volume * (triangle.sum(axis=0) + middle) / 4.0
    mean: Array = centre / total
    return mean


def _lying(shape: dict[str, Any], points: Array, centre: Array) -> Iterator[Heights]:
    found = scipy.spatial.ConvexHull(points)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    for equation, simplex in zip(found.equations, found.simplices, strict=True):
        normal, height = equation[:3], -float(equation[:3] @ centre + equation[3])
        foot = centre + height * normal
        if not _inside(points[simplex], foot, normal):
            continue
        turn = rotation_about([0, 0, 1], float(normal[0])) @ _down(normal)
        yield _rest(shape, turn, size), height, size


def _inside(triangle: Array, foot: Array, normal: Array) -> bool:
    """Whether the foot of the centre of mass lies in a triangle, on which the body can then lie."""
    sides = [np.cross(triangle[(k + 1) % 3] - triangle[k], foot - triangle[k]) for k in range(3)]
    signs = np.array([side @ normal for side in sides])
    return bool((signs > 0).all() or (signs < 0).all())


def _down(normal: Array) -> Array:
    """Return the rotation that turns ``normal`` downwards."""
    axis = np.cross(normal, [0.0, 0.0, -1.0])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        return np.diag([1.0, np.sign(-normal[2]), np.sign(-normal[2])])
    return rotation_about(axis, math.atan2(sine, -float(normal[2])))


def _rest(shape: dict[str, Any], turn: Array, size: float) -> float:
    quaternion = Pose(turn, np.zeros(3)).quaternion()
    scenario = gm_ompl.load({
        "object": {"shape": shape, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {
            "count": 0, "radius": 1, "max_normal_force": 1,
            "placements": {"grid": [1, 1], "faces": [0]},
        },
        "motion": {
            "start": {"position": [0.3, -2, "rest"], "rotation": {"quaternion": quaternion}},
            "path": [{"slide": {"by": [size, 0, 0]}}],
        },
        "lattice": {"segments": 1},
    })  # fmt: skip
    height: float = scenario.resolved()["motion"]["start"]["position"][2]
    return height
