"""Planes that keep a moving convex piece and a fixed one apart."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.geometry.pose import rotation_about
from gm_ompl.geometry.separation import crossed_edges
from gm_ompl.geometry.solids import ConvexPiece
from gm_ompl.geometry.sweep import Sweep, Waves, heights, turned

Stretch: TypeAlias = tuple[float, float]
"""From one t to another."""

TRIED = 4
"""Planes tried per stretch and kind: those with the widest gap in its middle."""


class MovingPiece:
    """A convex piece of the object along a motion, world frame at its start.

    Args:
        piece: the piece, object frame.
        sweep: the motion.

    Attributes:
        sweep: likewise.
        arms: (v, 3), its corners from the pivot.
        normals: (f, 3), of its faces, outward.
        offsets: (f,), of their planes from the pivot.
        edges: (e, 3), directions.
    """

    def __init__(self, piece: ConvexPiece, sweep: Sweep) -> None:
        turn = sweep.start.rotation.T
        self.sweep, self.arms = sweep, sweep.arms(piece.vertices)
        self.normals = piece.face_normals @ turn
        arm = sweep.start.position - sweep.pivot
        self.offsets = piece.face_offsets + self.normals @ arm
        self.edges = piece.edge_directions @ turn

    def planes(self, other: ConvexPiece) -> Planes:
        """Return the planes between this piece and a fixed one."""
        return Planes(self, other)


class Planes:
    """All planes that may separate one pair; heights are positive on the clear side."""

    def __init__(self, mover: MovingPiece, other: ConvexPiece) -> None:
        self._mover, self._other = mover, other
        over = heights(mover.sweep, mover.arms, other.face_normals, other.face_offsets)
        self._faces = (over, self._moving_faces())

    def clear(self, stretch: Stretch, depth: float) -> bool | None:
        """Whether the pair is clear over ``stretch``; None where its halves must be asked."""
        middle = (stretch[0] + stretch[1]) / 2.0
        deepest = -np.inf
        for waves in self._faces:
            gaps = waves.at(middle).min(axis=1)
            deepest = max(deepest, float(gaps.max()))
            best = _widest(gaps, depth)
            if len(best) and waves.rows(best).least(*stretch).min(axis=1).max() >= -depth:
                return True
        gap, pair = self._widest_edges(middle)
        if max(deepest, gap) < -depth:
            return False
        if gap >= -depth and pair is not None and self._spanned(pair, stretch, depth):
            return True
        return None

    def _moving_faces(self) -> Waves:
        """The fixed corners over the moving faces, (faces, corners)."""
        mover, sweep = self._mover, self._mover.sweep
        a, b, c = turned(sweep.axis, mover.normals, self._other.vertices - sweep.pivot)
        rising = None
        if sweep.drift.any():
            d, e, f = turned(sweep.axis, mover.normals, -sweep.drift[None])
            rising = (d.T, e.T, f.T)
        return Waves(sweep.angle, (a.T - mover.offsets[:, None], b.T, c.T), rising)

    def _widest_edges(self, t: float) -> tuple[float, tuple[Array, Array, Array, Array] | None]:
        """Return the widest gap at ``t`` across a plane of two edges, and how it is spanned.

        That is: the moving edge at the start, signed; the fixed edge; the arm of the moving corner
        and the fixed corner that are nearest to the plane.
        """
        mover, other, sweep = self._mover, self._other, self._mover.sweep
        edges = mover.edges @ rotation_about(sweep.axis, t * sweep.angle).T
        mine, theirs = sweep.moved(mover.arms, t), other.vertices
        widest, found = -np.inf, None
        for numbers, axes in crossed_edges(edges, other.edge_directions):
            if not len(numbers):
                continue
            of_mine, of_theirs = axes @ mine.T, axes @ theirs.T
            ahead = of_mine.min(axis=1) - of_theirs.max(axis=1)
            behind = of_theirs.min(axis=1) - of_mine.max(axis=1)
            k = int(np.maximum(ahead, behind).argmax())
            gap = float(max(ahead[k], behind[k]))
            if gap > widest:
                sign = 1.0 if ahead[k] >= behind[k] else -1.0
                i, j = divmod(int(numbers[k]), len(other.edge_directions))
                near = int((sign * of_mine[k]).argmin()), int((sign * of_theirs[k]).argmax())
                widest, found = gap, (
                    sign * mover.edges[i], other.edge_directions[j],
                    mover.arms[near[0]], theirs[near[1]],
                )  # fmt: skip
        return widest, found

    def _spanned(
        self, pair: tuple[Array, Array, Array, Array], stretch: Stretch, depth: float
    ) -> bool:
        """Whether the plane that two edges span separates throughout ``stretch``.

        Its normal is n = R e x f, R the turn, e the moving edge, f the fixed one. Written out,
        every height over it is linear in R.
        """
        mover, sweep = self._mover, self._mover.sweep
        e, f, _, corner = pair
        axis, lever = sweep.axis, cross(f, sweep.pivot - corner)
        # n . (x - corner) for a moving x = pivot + t drift + R arm.
        one = turned(axis, e[None], lever[None])
        two = turned(axis, cross(mover.arms, e), f[None])
        rising = None
        if sweep.drift.any():
            rising = turned(axis, e[None], cross(f, sweep.drift)[None])
        a, b, c = (u + v for u, v in zip(one, two, strict=True))
        above = Waves(sweep.angle, (a, b, c), rising).least(*stretch).min()
        arms = cross(f, self._other.vertices - corner)
        below = (-Waves(sweep.angle, turned(axis, e[None], arms))).least(*stretch).min()
        along = Waves(sweep.angle, turned(axis, e[None], f[None]))
        cosine = -min(along.least(*stretch).min(), (-along).least(*stretch).min())
        length = np.sqrt(max(0.0, 1.0 - float(cosine) ** 2))
        return bool(above + below >= -depth * length)


def _widest(gaps: Array, depth: float) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Return the rows of the widest gaps that are no penetration."""
    rows = np.flatnonzero(gaps >= -depth)
    return rows if len(rows) <= TRIED else rows[np.argsort(-gaps[rows])[:TRIED]]
