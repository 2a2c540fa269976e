"""Which straight ways a sphere can take through the air: swept, exact beside edges and corners."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.geometry.collision import EXACT, allowed_depth
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece

SAFE = 0.5
"""Share of the allowed depth that a way may use: who checks it finds it clear with the whole."""

AT_ONCE = 200_000
"""Pairs of a stretch and an edge looked at together, in some 20 MB."""

TINY = 1e-12
"""Beside a face by at most this, relative to D, is over it."""


class Solid(NamedTuple):
    """A convex piece in the object's frame, and how far a sphere's centre keeps from it.

    Attributes:
        normals: (f, 3), outward, unit.
        offsets: (f,), of the faces' planes.
        starts: (e, 3), one end of every edge.
        spans: (e, 3), from there to its other end.
        least: the distance kept.
    """

    normals: Array
    offsets: Array
    starts: Array
    spans: Array
    least: float

    @classmethod
    def of(cls, piece: ConvexPiece, least: float, pose: Pose | None = None) -> Solid:
        """Return a piece; one of the world's where the object is at ``pose``."""
        starts, spans = piece.edge_ends
        if pose is None:
            return cls(piece.face_normals, piece.face_offsets, starts, spans, least)
        turn = pose.rotation
        offsets = piece.face_offsets - piece.face_normals @ pose.position
        return cls(piece.face_normals @ turn, offsets, pose.to_object(starts), spans @ turn, least)


@final
class FreeAir:
    """Where a fingertip's centre may go while the object rests, object frame.

    Args:
        body: the object.
        obstacles: the environment's pieces, world frame.
        floor: whether the half space z < 0 is solid.
        pose: where the object rests.
        radius: the fingertip's.

    Attributes:
        up: (3,), the world's vertical.
        radius: the fingertip's.
        extent: nothing is further than this from the object's origin, the floor left aside.
    """

    def __init__(
        self,
        body: Body,
        obstacles: Sequence[ConvexPiece],
        floor: bool,
        pose: Pose,
        radius: float,
    ) -> None:
        D = body.diagonal

        def least(piece: ConvexPiece) -> float:
            return radius - SAFE * allowed_depth(D, piece)

        self._own = [Solid.of(piece, least(piece)) for piece in body.pieces]
        self._others = [Solid.of(piece, least(piece), pose) for piece in obstacles]
        self.up: Array = np.ascontiguousarray(pose.rotation[2])
        self._over = float(pose.position[2]) - radius + SAFE * EXACT * D if floor else np.inf
        self._tiny = TINY * D
        self.radius, self._allowed = radius, SAFE * EXACT * D
        self._tips, self._apart = np.zeros((0, 3)), np.zeros(0)
        reach = [float(np.linalg.norm(body.vertices, axis=1).max())]
        reach += [float(np.linalg.norm(s.starts, axis=1).max()) for s in self._others]
        self.extent = max(reach)

    def wider(self, margin: float) -> FreeAir:
        """Return this air for a fingertip whose radius is larger by ``margin``."""
        air = copy.copy(self)
        air.radius = self.radius + margin
        air._own, air._others = (
            [solid._replace(least=solid.least + margin) for solid in solids]
            for solids in (self._own, self._others)
        )
        air._over, air._apart = self._over - margin, self._apart + margin
        return air

    def beside(self, tips: Array, radii: Array) -> FreeAir:
        """Return this air with other fingertips in it, at centres (k, 3), of radii (k,)."""
        air = copy.copy(self)
        air._tips, air._apart = tips, radii + self.radius - self._allowed
        return air

    def clear(self, a: Array, b: Array, touching: IntArray | None = None) -> BoolArray:
        """Return which straight ways from ``a`` to ``b`` (n, 3) are free, (n,).

        Args:
            a: where they start.
            b: where they end.
            touching: (n,), a piece of the object that each is not tested against.
        """
        free: BoolArray = self.clear_of_tips(a, b)
        free &= np.minimum(a @ self.up, b @ self.up) + self._over >= 0.0
        for k, solid in enumerate(self._own):
            rows = np.flatnonzero(free if touching is None else free & (touching != k))
            free[rows] = self._clear_of(solid, a[rows], b[rows])
        for solid in self._others:
            rows = np.flatnonzero(free)
            free[rows] = self._clear_of(solid, a[rows], b[rows])
        return free

    def room(self, points: Array) -> Array:
        """Return how far at least each of ``points`` (n, 3) is from where it is not free, (n,)."""
        room: Array = points @ self.up + self._over
        for solid in (*self._own, *self._others):
            over = (points @ solid.normals.T - solid.offsets).max(axis=1, initial=-np.inf)
            np.minimum(room, over - solid.least, out=room)
        for tip, apart in zip(self._tips, self._apart, strict=True):
            away = points - tip
            np.minimum(room, np.sqrt(np.einsum("ij,ij->i", away, away)) - apart, out=room)
        return room

    def clear_of_tips(self, a: Array, b: Array) -> BoolArray:
        """Return which ways from ``a`` to ``b`` (n, 3) are clear of the other fingertips, (n,)."""
        free = np.ones(len(a), dtype=bool)
        span = b - a
        length = np.maximum(np.einsum("ij,ij->i", span, span), np.finfo(float).tiny)
        for tip, apart in zip(self._tips, self._apart, strict=True):
            share = np.clip(((tip - a) * span).sum(axis=1) / length, 0.0, 1.0)
            away = a + share[:, None] * span - tip
            free &= np.einsum("ij,ij->i", away, away) >= apart**2
        return free

    def _clear_of(self, solid: Solid, a: Array, b: Array) -> BoolArray:
        if not len(a):
            return np.ones(0, dtype=bool)
        over_a = a @ solid.normals.T - solid.offsets
        over_b = b @ solid.normals.T - solid.offsets
        clear: BoolArray = np.minimum(over_a, over_b).max(axis=1) >= solid.least
        left, at_once = np.flatnonzero(~clear), max(1, AT_ONCE // len(solid.starts))
        for first in range(0, len(left), at_once):
            rows = left[first : first + at_once]
            hit = _crosses(over_a[rows], over_b[rows])
            for ends, over in ((a[rows], over_a[rows]), (b[rows], over_b[rows])):
                hit |= self._over_face(solid, ends, over)
            rest = np.flatnonzero(~hit)
            near = edge_distances(a[rows[rest]], b[rows[rest]], solid.starts, solid.spans)
            clear[rows[rest]] = near.min(axis=1) >= solid.least
        return clear

    def _over_face(self, solid: Solid, points: Array, over: Array) -> BoolArray:
        """Return which points are too near to the face that they are over."""
        highest = over.argmax(axis=1)
        height = over[np.arange(len(points)), highest]
        feet = points - height[:, None] * solid.normals[highest]
        inside = (feet @ solid.normals.T - solid.offsets).max(axis=1) <= self._tiny
        low: BoolArray = (height < solid.least) & (inside | (height < 0.0))
        return low


def _crosses(over_a: Array, over_b: Array) -> BoolArray:
    """Return which ways, of heights (n, f) over a piece's faces at their ends, pass inside it."""
    fall = over_a - over_b
    with np.errstate(divide="ignore", invalid="ignore"):
        share = over_a / fall
    first = np.where(fall > 0.0, share, -np.inf).max(axis=1)
    last = np.where(fall < 0.0, share, np.inf).min(axis=1)
    beside = ((fall == 0.0) & (over_a >= 0.0)).any(axis=1)
    inside: BoolArray = ~beside & (np.maximum(first, 0.0) < np.minimum(last, 1.0))
    return inside


def edge_distances(a: Array, b: Array, starts: Array, spans: Array) -> Array:
    """Return how far ways from ``a`` to ``b`` (n, 3) are from segments, (n, e)."""
    way = b - a
    A, E = np.einsum("ij,ij->i", way, way)[:, None], np.einsum("ij,ij->i", spans, spans)
    B = way @ spans.T
    C = np.einsum("ij,ij->i", way, a)[:, None] - way @ starts.T
    F = a @ spans.T - np.einsum("ij,ij->i", spans, starts)
    A = np.maximum(A, np.finfo(float).tiny)
    level = np.maximum(A * E - B * B, 0.0)
    skew = level > 1e-14 * A * E
    s = np.where(skew, np.clip((B * F - C * E) / np.where(skew, level, 1.0), 0.0, 1.0), 0.0)
    t = np.clip((B * s + F) / E, 0.0, 1.0)
    s = np.clip((B * t - C) / A, 0.0, 1.0)
    between = a[:, None] + s[:, :, None] * way[:, None] - starts - t[:, :, None] * spans
    distances: Array = np.sqrt(np.einsum("ijk,ijk->ij", between, between))
    return distances
