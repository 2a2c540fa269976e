"""How a regrasping finger is drawn: lifted off, carried round the object, set down.

The plan does not say how a finger gets to its new place. The way shown here keeps clear of the
object; of a few such ways, the one that meets fewest obstacles.
"""

from __future__ import annotations

import itertools
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, unit
from gm_ompl.geometry.pose import Pose
from gm_ompl.plan.model import PlacementRecord
from gm_ompl.problem import Problem

MARGIN: Final = 0.08
"""Room between object and fingertip on the way round, relative to where they would touch."""

LIFT_POINTS: Final = 9
ROUND_POINTS: Final = 31
"""Points stored for lifting (and again for setting down) and for the way round."""

UP: Final = np.array([0.0, 0.0, 1.0])


def transit(
    problem: Problem, pose: Pose, finger: int, old: PlacementRecord, new: PlacementRecord
) -> Array:
    """Return the way (k, 3) of the fingertip's centre, object frame.

    It leaves along the old face's normal up to a sphere that the object cannot reach, follows
    that sphere, and comes down along the new face's normal.
    """
    radius = float(problem.fingers.radius[finger])
    touch = float(np.linalg.norm(problem.body.vertices, axis=1).max()) + radius
    sphere = (1.0 + MARGIN) * touch
    lift = _lift(old, radius, sphere)
    drop = _lift(new, radius, sphere)[::-1]
    up = UP @ pose.rotation
    # The least z on the sphere, as a share of it, at which the fingertip clears the floor.
    lowest = (radius - pose.position[2]) / sphere if problem.environment.floor else -1.0
    ways = [
        _round(lift[-1], drop[0], via, pose, floor, sphere)
        for via in (None, up, unit(lift[-1] + drop[0] + sphere * up))
        for floor in (lowest, -1.0)
    ]

    def faults(way: Array) -> tuple[bool, int, float]:
        return _nearest(way) < touch, _obstructed(problem, pose, way, radius), _length(way)

    best = min(ways, key=faults)
    return np.concatenate([lift, best[1:-1], drop])


def _lift(place: PlacementRecord, radius: float, sphere: float) -> Array:
    """Return points from the placement outwards along its normal to the sphere."""
    out = -np.asarray(place.normal)
    start = np.asarray(place.point) + radius * out
    along = float(start @ out)
    room = max(sphere**2 - float(start @ start), 0.0)
    height = -along + np.sqrt(along**2 + room)
    return np.array([start + height * f * out for f in np.linspace(0.0, 1.0, LIFT_POINTS)])


def _round(
    start: Array, end: Array, via: Array | None, pose: Pose, lowest: float, sphere: float
) -> Array:
    """Return points on the sphere from ``start`` to ``end``, raised to ``lowest`` if below."""
    stops = [unit(start), *([] if via is None else [unit(via)]), unit(end)]
    arcs = [_great_arc(a, b) for a, b in itertools.pairwise(stops)]
    directions = np.concatenate(arcs)
    directions = directions[np.linspace(0, len(directions) - 1, ROUND_POINTS).round().astype(int)]
    way = sphere * np.array([_above(direction, lowest, pose) for direction in directions])
    way[0], way[-1] = start, end
    return way


def _great_arc(a: Array, b: Array) -> Array:
    """Return unit vectors (k, 3) from ``a`` to ``b`` along the sphere."""
    angle = float(np.arccos(np.clip(a @ b, -1.0, 1.0)))
    side = b - (a @ b) * a
    if np.linalg.norm(side) < 1e-9:  # equal or opposite: any direction will do
        side = np.cross(a, np.eye(3)[int(np.abs(a).argmin())])
    side = unit(side)
    turns = np.linspace(0.0, angle, ROUND_POINTS)[:, None]
    arc: Array = np.cos(turns) * a + np.sin(turns) * side
    return arc


def _above(direction: Array, lowest: float, pose: Pose) -> Array:
    """Return ``direction`` (object frame) raised so that its world z is at least ``lowest``."""
    world = pose.rotation @ direction
    flat = float(np.hypot(world[0], world[1]))
    if world[2] >= lowest or lowest >= 1.0 or flat < 1e-9:
        return direction
    world[:2] *= np.sqrt(1.0 - lowest**2) / flat
    world[2] = lowest
    raised: Array = world @ pose.rotation
    return raised


def _nearest(way: Array) -> float:
    """Return how near the straight lines between points come to the centre of mass."""
    ends = way[1:] - way[:-1]
    lengths = np.maximum((ends**2).sum(axis=1), np.finfo(float).tiny)
    along = np.clip(-(way[:-1] * ends).sum(axis=1) / lengths, 0.0, 1.0)
    return float(np.linalg.norm(way[:-1] + along[:, None] * ends, axis=1).min())


def _obstructed(problem: Problem, pose: Pose, way: Array, radius: float) -> int:
    """Return how many points of ``way`` penetrate the floor or come near an obstacle's planes."""
    points = pose.apply(way)
    blocked = np.zeros(len(points), dtype=bool)
    if problem.environment.floor:
        blocked |= points[:, 2] < (1.0 - 1e-6) * radius
    for obstacle in problem.environment.obstacles:
        for piece in obstacle.body.pieces:
            gaps = points @ piece.face_normals.T - piece.face_offsets
            blocked |= gaps.max(axis=1) < radius
    return int(blocked.sum())


def _length(way: Array) -> float:
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
