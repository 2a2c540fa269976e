"""Where a motion must end: at what is in the way, and where a new contact closes.

The gap of every pair of convex pieces, along the best of all separating axes, is looked at on a
fine sampling of the motion, and its roots and dips are then closed in on by finer ones: nothing
here knows what kind of contact closes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.contact.environment import Environment
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece
from gm_ompl.motion.screw import Piece, Tumble

Gap: TypeAlias = Callable[[Array], Array]
"""How far two convex pieces are apart at times (k,), as (k,); negative: they penetrate."""
Stretch: TypeAlias = tuple[float, float]

FINE = math.radians(0.5)
"""Turn between two samples: what dips and rises between them dips by 1e-5 D at most."""
COARSE = 16
"""Samples of a translation, where gaps are convex functions of t."""
ZOOM, ROUNDS = 32, 10
"""Parts of a stretch that is looked at closer, and how often."""
CLOSED = 1e-13
"""Gap, relative to D and the distance from the origin, that rounding leaves of none."""
TOUCH = 1e-9
"""Gap, relative to D, from which on pieces that were apart touch."""
AHEAD, AHEAD_PARTS, STAYS = 2e-3, 2048, 1e-4
"""How far ahead, in t, a closing gap is followed, in how many parts; for how long one that grazes
stays as near."""
PROBE = 1e-9
"""Depths, relative to D, at this and at twice this, tell where a contact begins to sink."""
FLAT = 1e-9
"""Falls between two samples, relative to the way between them, that are rounding."""
WHOLE = 1e-9
"""What a motion may lack, in t, to be the whole of it."""
LEAST = 1e-4
"""A motion on which no corner goes farther than this, relative to D, is none."""
AT_ONCE = 1_000_000
"""Products of corners and pairs of edges looked at together, in some 10 MB."""
ALONG = 1e-6
"""Sine of an angle below which two edges are taken for parallel."""


class EarlyEnds:
    """Where motions of one object end.

    Args:
        body: the object, object frame.
        environment: floor and obstacles.
    """

    def __init__(self, body: Body, environment: Environment) -> None:
        self._body, self._floor = body, environment.floor
        self._obstacles = [piece for other in environment.obstacles for piece in other.body.pieces]
        self._D = body.diagonal
        self._touching = environment.contact_tolerance * self._D

    def end(self, start: Pose, motion: Piece) -> float:
        """Return the t, from 0 to 1, at which a motion from ``start`` must end; 0: there is none.

        At the first t > 0 where going on would make two pieces penetrate, or where two that were
        apart touch.
        """
        samples = COARSE
        if isinstance(motion, Tumble):
            samples = max(COARSE, math.ceil(abs(motion.angle) / FINE))
        times = np.linspace(0.0, 1.0, samples + 1)
        between = _longest_way(start.apply(self._body.vertices), motion) / samples
        rounding = CLOSED * (self._D + float(np.abs(start.position).max()))
        last = 1.0
        for gap in self._near(start, motion, times, between):
            last = min(last, self._pair_end(gap, times, between, rounding))
        if last >= 1.0 - WHOLE:
            last = 1.0
        return last if last * samples * between >= LEAST * self._D else 0.0

    def _near(self, start: Pose, motion: Piece, times: Array, between: float) -> Iterator[Gap]:
        """Yield the gaps of the pairs that boxes around the motion do not tell apart."""
        for piece in self._body.pieces:
            places = _moved(start.apply(piece.vertices), motion, times)
            low = places.min(axis=(0, 1)) - between
            high = places.max(axis=(0, 1)) + between
            if self._floor and low[2] <= 0.0:
                yield _OverFloor(piece, start, motion)
            for other in self._obstacles:
                least, most = other.bounds
                if (high >= least).all() and (low <= most).all():
                    yield _Beside(piece, other, start, motion)

    def _pair_end(self, gap: Gap, times: Array, between: float, rounding: float) -> float:
        """Return the t at which one pair of pieces ends the motion; 1 where it does not."""
        widths = gap(times)
        if widths[0] > self._touching:
            near = _first_below(gap, times, widths, max(rounding, TOUCH * self._D), between)
            return near if near in (0.0, 1.0) else _closes(gap, near, rounding)
        sunk = _first_below(gap, times, widths, -self._touching, between)
        return sunk if sunk in (0.0, 1.0) else self._begins_to_sink(gap, times, widths, sunk)

    def _begins_to_sink(self, gap: Gap, times: Array, widths: Array, sunk: float) -> float:
        """Return the last t before ``sunk`` at which a contact was as closed as at first.

        Contacts that stay are closed but for rounding, so it is told from two small depths.
        """
        level, probe = min(float(widths[0]), 0.0), PROBE * self._D
        if level - 3.0 * probe <= -self._touching:
            return sunk
        first, second = (
            _last_above(gap, low, (float(times[(times < sunk) & (widths > low)].max()), sunk))
            for low in (level - probe, level - 2.0 * probe)
        )
        return max(0.0, 2.0 * first - second)


def _first_below(gap: Gap, times: Array, widths: Array, level: float, between: float) -> float:
    """Return the first t at which a gap is down to ``level``; 1: never.

    It may dip between two samples, by at most ``between``: beside a sample that is lowest among
    its neighbours it is looked for.
    """
    if widths[0] <= level:
        return 0.0
    last = len(times) - 1
    for k, width in enumerate(widths):
        if width <= level:
            return _first(gap, level, (times[k - 1], times[k]))
        falls = k == 0 or width < widths[k - 1] - FLAT * between
        rises = k == last or width <= widths[k + 1]
        if falls and rises and width - level < between:
            stretch = float(times[max(k - 1, 0)]), float(times[min(k + 1, last)])
            lowest = _dip(gap, level, stretch, between * last)
            if lowest is not None:
                return _first(gap, level, (stretch[0], lowest))
    return 1.0


def _closes(gap: Gap, near: float, rounding: float) -> float:
    """Return where a gap that is nearly closed at ``near`` is closed, or as near as it comes."""
    times = near + np.linspace(0.0, AHEAD, AHEAD_PARTS + 1)  # beyond 1 the motion goes on
    widths = gap(times)
    below = np.flatnonzero(widths <= 0.0)
    if len(below):
        k = int(below[0])
        return near if k == 0 else min(1.0, _first(gap, 0.0, (times[k - 1], times[k])))
    k = int(widths.argmin())
    stretch = float(times[max(k - 1, 0)]), float(times[min(k + 1, AHEAD_PARTS)])
    for _ in range(3):  # finer than that, a lowest point is rounding
        around = np.linspace(*stretch, ZOOM + 1)
        m = int(gap(around).argmin())
        stretch = float(around[max(m - 1, 0)]), float(around[min(m + 1, ZOOM)])
    lowest = float(gap(np.array([sum(stretch) / 2.0]))[0]) + rounding
    closed = np.flatnonzero(widths <= lowest)
    if len(closed) > 1 and times[closed[-1]] - times[closed[0]] > STAYS:
        return min(1.0, float(times[closed[0]]))  # it stays as near as it came
    return min(1.0, sum(stretch) / 2.0)


def _first(gap: Gap, level: float, stretch: Stretch) -> float:
    """Return the first t at which a gap, above ``level`` at first, is down to it."""
    for _ in range(ROUNDS):
        times = np.linspace(*stretch, ZOOM + 1)
        k = max(1, int((gap(times) <= level).argmax()))
        stretch = times[k - 1], times[k]
    return float(stretch[1])


def _last_above(gap: Gap, level: float, stretch: Stretch) -> float:
    """Return the last t at which a gap, below ``level`` where the stretch ends, is above it."""
    for _ in range(ROUNDS):
        times = np.linspace(*stretch, ZOOM + 1)
        k = ZOOM - max(1, int((gap(times) > level)[::-1].argmax()))
        stretch = times[k], times[k + 1]
    return float(stretch[0])


def _dip(gap: Gap, level: float, stretch: Stretch, speed: float) -> float | None:
    """Return a t in a stretch at which a gap, of at most ``speed``, is down to a level, if any."""
    for _ in range(ROUNDS):
        times = np.linspace(*stretch, ZOOM + 1)
        widths = gap(times)
        k = int(widths.argmin())
        if widths[k] <= level:
            return float(times[k])
        stretch = float(times[max(k - 1, 0)]), float(times[min(k + 1, ZOOM)])
        if widths[k] - level > speed * (stretch[1] - stretch[0]):
            break
    return None


class _OverFloor:
    def __init__(self, piece: ConvexPiece, start: Pose, motion: Piece) -> None:
        self._corners, self._motion = start.apply(piece.vertices), motion

    def __call__(self, times: Array) -> Array:
        lowest: Array = _moved(self._corners, self._motion, times)[:, :, 2].min(axis=1)
        return lowest


class _Beside:
    """A piece of the object beside one of the environment: faces of both, and pairs of edges."""

    def __init__(self, piece: ConvexPiece, other: ConvexPiece, start: Pose, motion: Piece) -> None:
        self._corners, self._other, self._motion = start.apply(piece.vertices), other, motion
        self._normals = piece.face_normals @ start.rotation.T
        self._edges = piece.edge_directions @ start.rotation.T
        sizes = len(self._corners) + len(other.vertices), len(self._edges)
        self._at_once = max(1, AT_ONCE // (sizes[0] * sizes[1] * len(other.edge_directions)))

    def __call__(self, times: Array) -> Array:
        parts = [times[k : k + self._at_once] for k in range(0, len(times), self._at_once)]
        return np.concatenate([self._widths(part) for part in parts])

    def _widths(self, times: Array) -> Array:
        other, motion = self._other, self._motion
        corners = _moved(self._corners, motion, times)
        of_other = (corners @ other.face_normals.T).min(axis=1) - other.face_offsets
        own = _turned(self._normals, motion, times)
        edges = _turned(self._edges, motion, times)[:, :, None]
        pairs = cross(edges, other.edge_directions).reshape(len(times), -1, 3)
        sines = np.linalg.norm(pairs, axis=2, keepdims=True)
        pairs = np.divide(pairs, sines, out=np.zeros_like(pairs), where=sines > ALONG)
        best: Array = of_other.max(axis=1)
        for axes in (-own, pairs, -pairs):
            near = np.einsum("tvi,tki->tkv", corners, axes).min(axis=2)
            far = np.einsum("vi,tki->tkv", other.vertices, axes).max(axis=2)
            real = axes.any(axis=2)  # an axis of parallel edges is none
            best = np.maximum(best, np.where(real, near - far, -np.inf).max(axis=1))
        return best


def _longest_way(corners: Array, motion: Piece) -> float:
    """Return the longest way of any of ``corners`` (v, 3), world frame."""
    if not isinstance(motion, Tumble):
        return float(np.linalg.norm(motion.by))
    radii = np.linalg.norm(cross(corners - motion.pivot, motion.axis), axis=1)
    return abs(motion.angle) * float(radii.max())


def _turned(vectors: Array, motion: Piece, times: Array) -> Array:
    """Return vectors (n, 3) that move along, at times (k,), as (k, n, 3)."""
    if not isinstance(motion, Tumble):
        return np.broadcast_to(vectors, (len(times), *vectors.shape))
    along = (vectors @ motion.axis)[:, None] * motion.axis
    angle = motion.angle * times[:, None, None]
    turned: Array = (
        along + np.cos(angle) * (vectors - along) + np.sin(angle) * cross(motion.axis, vectors)
    )
    return turned


def _moved(points: Array, motion: Piece, times: Array) -> Array:
    """Return points (n, 3), world frame, at times (k,), as (k, n, 3)."""
    if not isinstance(motion, Tumble):
        return points + times[:, None, None] * motion.by
    return motion.pivot + _turned(points - motion.pivot, motion, times)
