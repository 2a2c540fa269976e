"""What penetrates nothing anywhere along a motion, not at some places of it alone.

Two convex bodies are clear of each other over a stretch of time where one plane, a face's of either
or one spanned by an edge of each, separates them throughout. Where no plane does, the stretch is
halved, until the bodies penetrate each other in its middle or every part is clear.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray, cross
from gm_ompl.geometry.collision import EXACT, Scene, allowed_depth
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
            best = np.flatnonzero(gaps >= -depth)
            best = best[np.argsort(-gaps[best])[:TRIED]]
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


SHORTEST = 1e-9
"""A stretch of time so short that is still undecided counts as blocked."""

MOST_STRETCHES = 500
"""Stretches looked at for one pair: a contact that no plane keeps would take them without end."""


class SweptScene:
    """The object, its environment, and whether they penetrate each other along a motion.

    Args:
        scene: the same at single poses.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene, self._D = scene, scene.body.diagonal

    def object_free(self, sweep: Sweep) -> bool:
        """Whether the object penetrates neither floor nor obstacles along ``sweep``."""
        for piece in self._scene.body.pieces:
            arms = sweep.arms(piece.vertices)
            if self._scene.floor and float(_heights(sweep, arms).min()) < -self._scene.depth:
                return False
            mover: MovingPiece | None = None
            for j in self._near(sweep, arms, 0.0).tolist():
                mover = mover or MovingPiece(piece, sweep)
                other = self._scene.obstacles[j]
                if not _pair_clear(mover, other, self._scene.depth):
                    return False
        return True

    def free_placements(self, sweep: Sweep, centres: Array, radius: float) -> BoolArray:
        """Return which fingertips (P,) do not penetrate the environment along ``sweep``.

        Args:
            sweep: how the object moves.
            centres: (P, 3), the fingertips' centres, object frame.
            radius: their radius.
        """
        free = np.ones(len(centres), dtype=bool)
        if not len(centres):
            return free
        arms = sweep.arms(centres)
        if self._scene.floor:
            free &= _heights(sweep, arms) >= radius - EXACT * self._D
        for j in self._near(sweep, arms, radius).tolist():
            rows, piece = np.flatnonzero(free), self._scene.obstacles[j]
            least = radius - allowed_depth(self._D, piece)
            free[rows] = _tips_clear(sweep, arms[rows], piece, least)
        return free

    def _near(self, sweep: Sweep, arms: Array, margin: float) -> IntArray:
        """Return the obstacle pieces in whose bounding box points with ``arms`` may come."""
        if not len(self._scene.obstacles):
            return np.zeros(0, dtype=np.int64)
        ends = np.concatenate([sweep.moved(arms, 0.0), sweep.moved(arms, 1.0)])
        margin += sweep.sagitta(arms)
        low, high = ends.min(axis=0) - margin, ends.max(axis=0) + margin
        return self._scene.near(low, high)


def _heights(sweep: Sweep, arms: Array) -> Array:
    """Return the least heights (n,) over the floor along ``sweep``."""
    over = heights(sweep, arms, np.array([[0.0, 0.0, 1.0]]), np.zeros(1))
    least: Array = over.least(0.0, 1.0)[0]
    return least


def _pair_clear(mover: MovingPiece, other: ConvexPiece, depth: float) -> bool:
    """Whether the object's piece penetrates ``other`` nowhere by more than ``depth``."""
    planes = mover.planes(other)
    left: list[Stretch] = [(0.0, 1.0)]
    for _ in range(MOST_STRETCHES):
        if not left:
            return True
        first, last = left.pop()
        clear = planes.clear((first, last), depth)
        if clear is None and last - first > SHORTEST:
            middle = (first + last) / 2.0
            left += [(first, middle), (middle, last)]
        elif not clear:
            return False
    return not left


def _tips_clear(sweep: Sweep, arms: Array, piece: ConvexPiece, least: float) -> BoolArray:
    """Return which points (P,) with ``arms`` stay at least ``least`` away from a piece."""
    clear = np.ones(len(arms), dtype=bool)
    waves = heights(sweep, arms, piece.face_normals, piece.face_offsets)
    left: list[tuple[Stretch, IntArray]] = [((0.0, 1.0), np.arange(len(arms)))]
    for _ in range(MOST_STRETCHES):
        if not left:
            return clear
        (first, last), rows = left.pop()
        rows = rows[waves.columns(rows).least(first, last).max(axis=0, initial=-np.inf) < least]
        if not len(rows):
            continue
        middle = (first + last) / 2.0
        highest = waves.columns(rows).at(middle).max(axis=0)
        undecided, hit = _by_nearest(sweep, arms[rows], piece, highest, (first, last), least)
        clear[rows[hit]] = False
        rows = rows[undecided]
        if last - first <= SHORTEST:
            clear[rows] = False
        elif len(rows):
            left += [((first, middle), rows), ((middle, last), rows)]
    for _, rows in left:
        clear[rows] = False
    return clear


def _by_nearest(
    sweep: Sweep, arms: Array, piece: ConvexPiece, highest: Array, stretch: Stretch, least: float
) -> tuple[BoolArray, BoolArray]:
    """Return which points (k,) stay undecided over ``stretch``, and which are hit in its middle.

    Looked at is the plane through the point of the piece's edges that is nearest in the middle.
    """
    first, last = stretch
    middle = (first + last) / 2.0
    places = sweep.moved(arms, middle)
    ways = places - piece.nearest_on_edges(places)
    lengths = np.sqrt(np.einsum("ij,ij->i", ways, ways))
    normals = ways / np.maximum(lengths, np.finfo(float).tiny)[:, None]
    support = (normals @ piece.vertices.T).max(axis=1)
    over = np.einsum("ij,ij->i", normals, places) - support
    hit = np.maximum(highest, over) < least
    waves = heights(sweep, arms, normals, support, each=True)
    return ~hit & (waves.least(first, last) < least), hit
