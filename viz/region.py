"""The part of the world that is drawn, and from where to look at it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import ConvexPiece, hull

from .animation import Animation

MARGIN: Final = 0.35  # room around everything that moves, in D


@dataclass(frozen=True, eq=False)
class View:
    """An axis-parallel box, world frame."""

    low: Array  # (3,), least coordinates
    high: Array  # (3,), greatest coordinates

    @property
    def centre(self) -> Array:
        """The middle, (3,)."""
        middle: Array = 0.5 * (self.low + self.high)
        return middle

    @property
    def diagonal(self) -> float:
        """Distance between opposite corners."""
        return float(np.linalg.norm(self.high - self.low))

    def with_(self, other: View) -> View:
        """Return the least box around both."""
        return View(np.minimum(self.low, other.low), np.maximum(self.high, other.high))


def neighbourhood(animation: Animation) -> View:
    """Return the region that the object and its fingertips sweep, and a margin."""
    problem = animation.problem
    first = animation.segments[0].poses[0] if animation.segments else animation.rest_pose()
    points = [_pose(first).apply(problem.body.vertices)]
    for segment in animation.segments:  # without gaps: each begins where the one before ends
        pose = _pose(segment.poses[-1])
        points.append(pose.apply(problem.body.vertices))
        for i, place in enumerate(segment.placements):
            centre, radius = animation.centre(i, place), float(problem.fingers.radius[i])
            tip = pose.apply(centre)
            points.append(np.array([tip - radius, tip + radius]))
    every = np.concatenate(points)
    margin = MARGIN * problem.body.diagonal
    low, high = every.min(axis=0) - margin, every.max(axis=0) + margin
    if problem.environment.floor:
        low[2] = 0.0
    return View(low, high)


def _pose(row: Array) -> Pose:
    return Pose.from_quaternion(row[:3], row[3:])


def clipped(piece: ConvexPiece, region: View) -> ConvexPiece | None:
    """Return the part of ``piece`` inside ``region``; None where they do not overlap."""
    normals = np.vstack([piece.face_normals, np.eye(3), -np.eye(3)])
    offsets = np.concatenate([piece.face_offsets, region.high, -region.low])
    # The largest ball inside both; its middle is what the intersection is found from.
    ball = linprog(
        [0.0, 0.0, 0.0, -1.0],
        np.column_stack([normals, np.ones(len(normals))]),
        offsets,
        bounds=[(None, None)] * 3 + [(0.0, None)],
    )
    if not ball.success or ball.x[3] <= 1e-9 * region.diagonal:
        return None
    planes = np.column_stack([normals, -offsets])
    return hull(HalfspaceIntersection(planes, ball.x[:3]).intersections)


def triangles_of(faces: tuple[tuple[int, ...], ...], corners: Array) -> Array:
    """Return the faces as triangles (t, 3, 3)."""
    fans = [(face[0], b, c) for face in faces for b, c in itertools.pairwise(face[1:])]
    triangles: Array = corners[np.array(fans)]
    return triangles


def edges_of(faces: tuple[tuple[int, ...], ...], corners: Array) -> Array:
    """Return each edge of the faces once, (e, 2, 3)."""
    pairs = {
        (min(a, b), max(a, b))
        for face in faces
        for a, b in zip(face, face[1:] + face[:1], strict=True)
    }
    edges: Array = corners[np.array(sorted(pairs))]
    return edges


def viewpoint(animation: Animation, elevation: float = 24.0) -> Array:
    """Return the unit vector (3,) towards the viewer.

    Of sixteen directions round the vertical: the one with fewest obstacles in front of the
    object, and of these the one that sees the motion most from its side.
    """
    first, last = (
        animation.segments[k].poses[k][:3] if animation.segments else np.zeros(3) for k in (0, -1)
    )
    travel = last - first
    heading = np.arctan2(travel[1], travel[0]) if np.hypot(*travel[:2]) > 0 else 0.0
    middle = 0.5 * (first + last) if animation.segments else animation.rest_pose()[:3]
    side = heading - np.pi / 2 + np.deg2rad(28.0)  # a little from ahead: three faces are seen
    azimuths, up = side + np.arange(16) * np.pi / 8, np.deg2rad(elevation)
    level = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    directions = np.column_stack([np.cos(up) * level, np.full(16, np.sin(up))])
    worth = [_hiding(animation, middle, d) + min(k, 16 - k) / 16 for k, d in enumerate(directions)]
    best: Array = directions[int(np.argmin(worth))]
    return best


def _hiding(animation: Animation, middle: Array, direction: Array) -> int:
    """Return how many obstacle pieces stand between the viewer and ``middle``."""
    steps = np.linspace(0.0, 4.0 * animation.problem.body.diagonal, 60)[:, None]
    ray = middle + steps * direction
    return sum(
        bool((ray @ piece.face_normals.T < piece.face_offsets).all(axis=1).any())
        for obstacle in animation.problem.environment.obstacles
        for piece in obstacle.body.pieces
    )
