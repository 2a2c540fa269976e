"""Which configurations penetrate nothing: the door to FCL.

Touching is allowed, and FCL's answer for touching bodies is a coin flip. So FCL decides where
bodies clearly overlap or clearly do not, and exact tests decide in between.
"""

from __future__ import annotations

from collections.abc import Sequence

import fcl
import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import TOUCHING, PlacedPiece, gap, penetrates
from gm_ompl.geometry.solids import Body, ConvexPiece

EXACT = 1e-9
"""Penetration allowed between fingertips and boxes, floor or fingertips, relative to D."""

COARSE = 1e-6
"""Penetration allowed between a fingertip and a hull, relative to D."""

CLEAR = 1e-4
"""Gap or overlap, relative to D, beyond which FCL is trusted: far above its own tolerances."""

FAR = 4.0
"""The same in contact tolerances, where those are wider."""

UNIT = 10.0
"""D inside FCL, whose tolerances are absolute."""

PAIRS = 300_000
"""Pairs of fingertips looked at at once, in some 10 MB."""

POINT = 1e-9
"""Radius of a sphere that stands for a point inside FCL."""

_PLAIN = fcl.CollisionRequest()


def allowed_depth(diagonal: float, piece: ConvexPiece) -> float:
    """Return how deep a fingertip may penetrate ``piece``."""
    return (EXACT if piece.is_box else COARSE) * diagonal


class Scene:
    """The object, its environment, and whether they penetrate each other at a pose.

    Args:
        body: the object, object frame.
        obstacles: fixed bodies, world frame.
        floor: whether the half space z < 0 is solid.
        touching: how deep object and environment may overlap, relative to D.

    Attributes:
        obstacles: their pieces.
        depth: how deep object and environment may overlap.
    """

    def __init__(
        self, body: Body, obstacles: Sequence[Body], floor: bool, touching: float = TOUCHING
    ) -> None:
        self.body, self.floor = body, floor
        self._D = body.diagonal
        self._scale = UNIT / self._D
        self.depth = touching * self._D
        clear = max(CLEAR, FAR * touching)
        self.obstacles = [piece for other in obstacles for piece in other.pieces]
        self._low = np.array([piece.bounds[0] for piece in self.obstacles]).reshape(-1, 3)
        self._high = np.array([piece.bounds[1] for piece in self.obstacles]).reshape(-1, 3)
        self._models = [self._model(piece) for piece in self.obstacles]
        self._own_models = [self._model(piece) for piece in body.pieces]
        self._grown = [self._model(piece, +clear) for piece in body.pieces]
        self._shrunk = [self._model(piece, -clear) for piece in body.pieces]

    def object_free(self, pose: Pose) -> bool:
        """Whether the object penetrates neither floor nor obstacles at ``pose``."""
        for k, piece in enumerate(self.body.pieces):
            here = PlacedPiece(piece, pose)
            low, high = here.bounds
            if self.floor and low[2] < -self.depth:
                return False
            for j in self.near(low, high):
                if self._overlaps(k, here, pose, int(j)):
                    return False
        return True

    def stays_clear(self, pose: Pose, shifts: Array) -> bool:
        """Whether the object stays off floor and obstacles wherever it is near a pose.

        Args:
            pose: where it is.
            shifts: (3,), none of its points is farther from there along the world's axes.
        """
        fixed = [PlacedPiece(piece) for piece in self.obstacles]
        for own in (PlacedPiece(piece, pose) for piece in self.body.pieces):
            low, high = own.bounds
            if self.floor and low[2] <= shifts[2]:
                return False
            beside = np.maximum(low - self._high, self._low - high) > shifts
            for j in np.flatnonzero(~beside.any(axis=1)):
                best = gap(own, fixed[j])
                if best.width <= float(np.abs(best.normal) @ shifts):
                    return False
        return True

    def free_placements(
        self, pose: Pose, centres: Array, radius: float, piece: IntArray
    ) -> BoolArray:
        """Return which fingertips (P,) penetrate neither environment nor object.

        Args:
            pose: where the object is.
            centres: (P, 3), the fingertips' centres, object frame.
            radius: their radius.
            piece: (P,), the object's piece that each touches; it is not tested against that one.
        """
        world = pose.apply(centres)
        free = np.ones(len(centres), dtype=bool)
        if not len(centres):
            return free
        if self.floor:
            free &= world[:, 2] >= radius - EXACT * self._D
        for j in self.near(world.min(axis=0) - radius, world.max(axis=0) + radius):
            rows = np.flatnonzero(free)
            free[rows] = self._clear(self.obstacles[j], self._models[j], world[rows], radius)
        return free & self.clear_of_object(centres, radius, piece)

    def clear_of_object(self, centres: Array, radius: float, piece: IntArray) -> BoolArray:
        """Return which fingertips (P,) do not penetrate the object; see ``free_placements``."""
        free = np.ones(len(centres), dtype=bool)
        if len(self.body.pieces) > 1:
            for k, own in enumerate(self.body.pieces):
                rows = np.flatnonzero(free & (piece != k))
                free[rows] = self._clear(own, self._own_models[k], centres[rows], radius)
        return free

    def tips_apart(
        self, centres_a: Array, radius_a: float, centres_b: Array, radius_b: float
    ) -> BoolArray:
        """Return (A, B), which fingertips at (A, 3) and (B, 3) do not penetrate each other."""
        least = self.least_distance(radius_a, radius_b)
        apart = np.empty((len(centres_a), len(centres_b)), dtype=bool)
        at_once = max(1, PAIRS // max(1, len(centres_b)))
        for first in range(0, len(centres_a), at_once):
            limits.check()
            part = slice(first, first + at_once)
            # An axis at a time: four times as fast as on the vectors between them.
            ways = (np.subtract.outer(centres_a[part, k], centres_b[:, k]) for k in range(3))
            apart[part] = sum(way * way for way in ways) >= least**2
        return apart

    def least_distance(self, radius_a: float, radius_b: float) -> float:
        """Return how far apart the centres of two fingertips are that do not penetrate."""
        return max(radius_a + radius_b - EXACT * self._D, 0.0)

    def near(self, low: Array, high: Array) -> IntArray:
        """Return the obstacle pieces whose bounding box reaches into the given one."""
        near: IntArray = np.flatnonzero(((self._low < high) & (self._high > low)).all(axis=1))
        return near

    def _overlaps(self, k: int, here: PlacedPiece, pose: Pose, j: int) -> bool:
        """Whether the object's piece ``k`` penetrates the obstacle piece ``j``."""
        transform = fcl.Transform(
            np.ascontiguousarray(pose.rotation), np.array(pose.position) * self._scale
        )
        self._grown[k].setTransform(transform)
        if not _collide(self._grown[k], self._models[j]):
            return False
        self._shrunk[k].setTransform(transform)
        if _collide(self._shrunk[k], self._models[j]):
            return True
        return penetrates(here, PlacedPiece(self.obstacles[j]), self.depth)

    def _clear(
        self, piece: ConvexPiece, model: fcl.CollisionObject, centres: Array, radius: float
    ) -> BoolArray:
        """Return which spheres (P,) do not penetrate a piece, all in one frame."""
        least = radius - allowed_depth(self._D, piece)
        heights = centres @ piece.face_normals.T - piece.face_offsets
        if piece.is_box:
            # At most one face of each opposite pair is below the point: Pythagoras.
            beyond = np.maximum(heights, 0.0)
            on_box: BoolArray = np.einsum("pf,pf->p", beyond, beyond) >= least**2
            return on_box
        highest = heights.max(axis=1)
        clear: BoolArray = highest >= least
        undecided = np.flatnonzero(~clear & (highest > 0.0))
        if len(undecided):
            tip = fcl.CollisionObject(fcl.Sphere(least * self._scale))
            for row, centre in zip(undecided, centres[undecided] * self._scale, strict=True):
                tip.setTranslation(centre)
                clear[row] = not _collide(tip, model)
        return clear

    def _model(self, piece: ConvexPiece, margin: float = 0.0) -> fcl.CollisionObject:
        """Return a piece in FCL's units, scaled about its middle to move every face by ``margin``.

        The margin is relative to D; a thin piece shrinks to no less than half its size.
        """
        middle = piece.vertices.mean(axis=0)
        least = float((piece.face_offsets - piece.face_normals @ middle).min())
        factor = max(1.0 + margin * self._D / least, 0.5)
        corners = (middle + factor * (piece.vertices - middle)) * self._scale
        faces = np.array([n for face in piece.faces for n in (len(face), *face)])
        return fcl.CollisionObject(fcl.Convex(corners, len(piece.faces), faces))


def surface_distances(corners: Array, points: Array) -> Array:
    """Return how far points (n, 3) are from the nearest of triangles (t, 3, 3), (n,)."""
    cloud = corners.reshape(-1, 3)
    middle = (cloud.max(axis=0) + cloud.min(axis=0)) / 2
    scale = UNIT / float(np.linalg.norm(np.ptp(cloud, axis=0)))
    surface = fcl.BVHModel()
    surface.beginModel(len(corners), len(cloud))
    surface.addSubModel((cloud - middle) * scale, np.arange(len(cloud)).reshape(-1, 3))
    surface.endModel()
    model, point = fcl.CollisionObject(surface), fcl.CollisionObject(fcl.Sphere(POINT))
    distances = []
    for place in (points - middle) * scale:
        limits.check()
        point.setTranslation(place)
        distances.append(fcl.distance(model, point, fcl.DistanceRequest(), fcl.DistanceResult()))
    return np.maximum(np.array(distances) + POINT, 0.0) / scale


def _collide(a: fcl.CollisionObject, b: fcl.CollisionObject) -> bool:
    # A used result accumulates answers: each query gets its own.
    return bool(fcl.collide(a, b, _PLAIN, fcl.CollisionResult()))
