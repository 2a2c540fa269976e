"""Swept tests stated plainly: planes, heights over them, and how fast those bend.

A second opinion on ``geometry.swept``, with which it shares the bodies alone. Over a stretch of
time single planes are looked at: of a face, fixed or carried by the object, or spanned by two
edges in the stretch's middle. A height over a plane is at least the lesser of its values at both
ends, less M h^2 / 8 where its second derivative stays below M and the stretch lasts h.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.collision import EXACT, allowed_depth
from gm_ompl.geometry.separation import TOUCHING, PlacedPiece, edge_gaps, face_gaps
from gm_ompl.geometry.solids import Body, ConvexPiece
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import Arc

Stretch: TypeAlias = tuple[float, float]

MOST = 4000
"""Stretches looked at per pair of bodies; what is then undecided counts as blocked."""


class SweptJudge:
    """What penetrates what along arcs.

    Args:
        body: the object, object frame.
        obstacles: fixed bodies, world frame.
        floor: whether the half space z < 0 is solid.
        touching: how deep object and environment may overlap, relative to D.
    """

    def __init__(
        self, body: Body, obstacles: tuple[Body, ...], floor: bool, touching: float = TOUCHING
    ) -> None:
        self._body, self._floor = body, floor
        self._depth = touching * body.diagonal
        self._obstacles = [piece for other in obstacles for piece in other.pieces]

    def object_blocked(self, arc: Arc) -> float | None:
        """Return a t at or near which the object penetrates floor or obstacle, or None."""
        for sweep, offset, share in _timed(arc):
            for piece in self._body.pieces:
                hit = self._piece(sweep, piece)
                if hit is not None:
                    return offset + share * hit
        return None

    def tip_blocked(self, arc: Arc, centre: Array, radius: float) -> float | None:
        """Return a t at or near which a fingertip penetrates floor or obstacle, or None.

        Args:
            arc: the object's.
            centre: (3,), of the fingertip, object frame.
            radius: its radius.
        """
        point = centre[None]
        for sweep, offset, share in _timed(arc):
            least = radius - EXACT * self._body.diagonal
            hit = self._over_floor(sweep, point, least) if self._floor else None
            for piece in self._obstacles if hit is None else ():
                margin = radius - allowed_depth(self._body.diagonal, piece)
                if not _far(sweep, point, piece, radius):
                    hit = _halved(_Tip(sweep, point, piece, margin))
                if hit is not None:
                    break
            if hit is not None:
                return offset + share * hit
        return None

    def _piece(self, sweep: Sweep, piece: ConvexPiece) -> float | None:
        if self._floor:
            hit = self._over_floor(sweep, piece.vertices, -self._depth)
            if hit is not None:
                return hit
        for other in self._obstacles:
            if _far(sweep, piece.vertices, other, 0.0):
                continue
            hit = _halved(_Pair(sweep, piece, other, self._depth))
            if hit is not None:
                return hit
        return None

    @staticmethod
    def _over_floor(sweep: Sweep, points: Array, least: float) -> float | None:
        return _halved(_Floor(sweep, points, least))


def _timed(arc: Arc) -> Iterator[tuple[Sweep, float, float]]:
    """Yield every sweep of an arc, the t where it begins and the share of t that it takes."""
    sweeps = arc.sweeps
    for k, sweep in enumerate(sweeps):
        yield sweep, k / len(sweeps), 1.0 / len(sweeps)


def _far(sweep: Sweep, points: Array, other: ConvexPiece, margin: float) -> bool:
    """Whether bounding boxes alone keep ``points``, wider by ``margin``, off a piece."""
    arms = sweep.arms(points)
    ends = np.concatenate([sweep.moved(arms, 0.0), sweep.moved(arms, 1.0)])
    margin += sweep.sagitta(arms)
    low, high = other.bounds
    apart = (ends.max(axis=0) + margin < low) | (ends.min(axis=0) - margin > high)
    return bool(apart.any())


class _Question:
    """What is asked over stretches of time; True clear, False blocked, None undecided."""

    def __init__(self, sweep: Sweep, points: Array) -> None:
        self.sweep, self.points = sweep, points
        arms = sweep.arms(points)
        along = arms @ sweep.axis
        self._radii = np.sqrt(np.maximum((arms**2).sum(axis=1) - along**2, 0.0))

    def over(self, stretch: Stretch) -> bool | None:
        raise NotImplementedError

    def _lowest(self, normal: Array, stretch: Stretch) -> float:
        """Return a lower bound on the points' reach along a fixed ``normal`` (3,)."""
        poses = [self.sweep.pose(t) for t in stretch]
        ends = np.minimum(*(pose.apply(self.points) @ normal for pose in poses))
        across = np.linalg.norm(normal - (normal @ self.sweep.axis) * self.sweep.axis)
        bend = self.sweep.angle**2 * self._radii * across
        return float((ends - bend * _square(stretch) / 8.0).min())


class _Floor(_Question):
    def __init__(self, sweep: Sweep, points: Array, least: float) -> None:
        super().__init__(sweep, points)
        self._least = least

    def over(self, stretch: Stretch) -> bool | None:
        up, t = np.array([0.0, 0.0, 1.0]), sum(stretch) / 2.0
        if self._lowest(up, stretch) >= self._least:
            return True
        low = (self.sweep.pose(t).apply(self.points) @ up).min()
        return None if low >= self._least else False


class _Tip(_Question):
    """A fingertip's centre beside a piece."""

    def __init__(self, sweep: Sweep, point: Array, piece: ConvexPiece, least: float) -> None:
        super().__init__(sweep, point)
        self._piece, self._least = piece, least

    def over(self, stretch: Stretch) -> bool | None:
        piece, place = self._piece, self.sweep.pose(sum(stretch) / 2.0).apply(self.points)
        way = (place - piece.nearest_on_edges(place))[0]
        length = float(np.linalg.norm(way))
        axes = [*piece.face_normals, *([way / length] if length > 0.0 else [])]
        widest = -np.inf
        for axis in axes:
            support = float((piece.vertices @ axis).max())
            gap = float((place @ axis)[0]) - support
            widest = max(widest, gap)
            if gap >= self._least and self._lowest(axis, stretch) - support >= self._least:
                return True
        return None if widest >= self._least else False


class _Pair(_Question):
    """One convex piece of the object beside one of the environment."""

    def __init__(self, sweep: Sweep, piece: ConvexPiece, other: ConvexPiece, depth: float) -> None:
        super().__init__(sweep, piece.vertices)
        self._piece, self._other, self._depth = piece, other, depth
        self._fixed = PlacedPiece(other)

    def over(self, stretch: Stretch) -> bool | None:
        here = PlacedPiece(self._piece, self.sweep.pose(sum(stretch) / 2.0))
        fixed, own = face_gaps(self._fixed, here), face_gaps(here, self._fixed)
        for k in np.flatnonzero(fixed >= -self._depth):
            if self._fixed_axis(self._other.face_normals[k], stretch):
                return True
        for k in np.flatnonzero(own >= -self._depth):
            if self._turning_axis(int(k), stretch):
                return True
        widths, axes = edge_gaps(here, self._fixed)
        if len(widths) and widths.max() >= -self._depth:
            if self._fixed_axis(axes[int(widths.argmax())], stretch):
                return True
        elif max(fixed.max(), own.max()) < -self._depth:
            return False
        return None

    def _fixed_axis(self, axis: Array, stretch: Stretch) -> bool:
        """Whether a plane with outward normal ``axis`` (3,), world frame, separates throughout."""
        reach = float((self._other.vertices @ axis).max())
        return self._lowest(axis, stretch) - reach >= -self._depth

    def _turning_axis(self, face: int, stretch: Stretch) -> bool:
        """Whether the plane of the object's ``face`` separates throughout."""
        normal, offset = self._piece.face_normals[face], self._piece.face_offsets[face]
        corners, sweep = self._other.vertices, self.sweep
        heights = [sweep.pose(t).to_object(corners) @ normal - offset for t in stretch]
        arms = np.linalg.norm(corners - sweep.pivot, axis=1)
        drift = float(np.linalg.norm(sweep.drift))
        bend = sweep.angle**2 * (arms + stretch[1] * drift) + 2.0 * abs(sweep.angle) * drift
        if abs(sweep.angle) > 0.0 and drift == 0.0:
            bend = sweep.angle**2 * self._lever(normal, corners)
        lowest = np.minimum(*heights) - bend * _square(stretch) / 8.0
        return bool(lowest.min() >= -self._depth)

    def _lever(self, normal: Array, corners: Array) -> Array:
        """Return how far heights of ``corners`` over a turning plane swing, (v,)."""
        axis = self.sweep.axis
        turned = self.sweep.start.rotation @ normal
        arms = corners - self.sweep.pivot
        across = np.linalg.norm(turned - (turned @ axis) * axis)
        lever: Array = across * np.linalg.norm(arms - np.outer(arms @ axis, axis), axis=1)
        return lever


def _square(stretch: Stretch) -> float:
    return (stretch[1] - stretch[0]) ** 2


def _halved(question: _Question) -> float | None:
    """Return a t where the answer is no, or where none was found; None where all is clear."""
    left: list[Stretch] = [(0.0, 1.0)]
    for _ in range(MOST):
        if not left:
            return None
        first, last = left.pop()
        middle, answer = (first + last) / 2.0, question.over((first, last))
        if answer is False:
            return middle
        if answer is None:
            left += [(middle, last), (first, middle)]
    return left[-1][0] if left else None
