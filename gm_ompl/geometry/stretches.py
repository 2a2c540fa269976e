"""Whether one plane keeps two convex pieces apart over a stretch of a motion, compiled.

Looked at are the planes of the faces of either, and one spanned by an edge of each. A height over
such a plane is a + b cos + c sin of the angle turned, plus t times another such sum where the
motion drifts too; without a drift, or without a turn, its least value has a closed form.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import inlined, lean
from gm_ompl.geometry.facets import PARALLEL
from gm_ompl.geometry.packed import Drive, Hull, HullRoom, moved_hull
from gm_ompl.geometry.vectors import Triple, across, between, dot

BLOCKED: Final = 0
"""The pieces penetrate each other in the middle of the stretch."""
CLEAR: Final = 1
"""A plane keeps them apart throughout."""
UNDECIDED: Final = -1
"""Its halves must be asked."""


class Timespan(NamedTuple):
    """From t = ``first`` to ``last`` of a turn by ``angle``, with cosines and sines there."""

    first: float
    last: float
    angle: float
    c0: float
    s0: float
    c1: float
    s1: float


@lean
def stretch(first: float, last: float, angle: float) -> Timespan:
    """Return a stretch."""
    a, b = first * angle, last * angle
    return Timespan(first, last, angle, np.cos(a), np.sin(a), np.cos(b), np.sin(b))


@lean
def least(still: Triple, rising: Triple, over: Timespan) -> float:
    """Return the least height over a stretch, or a lower bound where it turns and drifts."""
    a, b, c = still
    d, e, f = rising
    at_first = a + b * over.c0 + c * over.s0 + over.first * (d + e * over.c0 + f * over.s0)
    at_last = a + b * over.c1 + c * over.s1 + over.last * (d + e * over.c1 + f * over.s1)
    ends = min(at_first, at_last)
    if over.angle == 0.0:
        return ends
    swing, length = np.hypot(b, c), over.last - over.first
    if d == 0.0 and e == 0.0 and f == 0.0:
        if a - swing >= ends:
            return ends
        lowest = np.arctan2(-c, -b) - over.first * over.angle
        if over.angle < 0.0:
            lowest = -lowest
        inside = np.mod(lowest, 2.0 * np.pi) < abs(over.angle) * length
        return a - swing if inside else ends
    swell = np.hypot(e, f)
    bend: float = over.angle**2 * (swing + over.last * swell) + 2.0 * abs(over.angle) * swell
    return ends - bend * length * length / 8.0


@lean
def turned(axis: Array, moving: Array | Triple, fixed: Array | Triple) -> Triple:
    """Return the coefficients of (turned ``moving``) . ``fixed``, (3,) each."""
    still = dot(fixed, axis) * dot(moving, axis)
    ahead = (
        fixed[0] * (axis[1] * moving[2] - axis[2] * moving[1])
        + fixed[1] * (axis[2] * moving[0] - axis[0] * moving[2])
        + fixed[2] * (axis[0] * moving[1] - axis[1] * moving[0])
    )
    return still, dot(fixed, moving) - still, ahead


@lean
def height(
    motion: Drive, point: Array, normal: Array | Triple, offset: float
) -> tuple[Triple, Triple]:
    """Return the coefficients of the height of a moving point (3,), given at t = 0."""
    a, b, c = turned(motion.axis, between(motion.pivot, point), normal)
    level = dot(normal, motion.pivot) - offset
    return (a + level, b, c), (dot(normal, motion.drift), 0.0, 0.0)


@lean
def beneath(motion: Drive, normal: Array, offset: float, point: Array) -> tuple[Triple, Triple]:
    """Return the coefficients of the height of a fixed point (3,) over a plane, given at t = 0."""
    a, b, c = turned(motion.axis, normal, between(motion.pivot, point))
    from_pivot = offset - dot(normal, motion.pivot)
    d, e, f = turned(motion.axis, normal, motion.drift)
    return (a - from_pivot, b, c), (-d, -e, -f)


@lean
def over_plane(normal: Array, offset: float, points: Array) -> float:
    """Return how far the lowest of points (n, 3) is over a plane."""
    lowest = np.inf
    for i in range(len(points)):
        lowest = min(lowest, dot(normal, points[i]) - offset)
    return lowest


@inlined
def _over_fixed(
    mover: Hull, here: Hull, motion: Drive, other: Hull, over: Timespan, depth: float
) -> float:
    """Return +inf where a fixed face separates over a stretch, else the widest gap at ``here``."""
    widest = -np.inf
    for k in range(len(other.normals)):
        normal, offset = other.normals[k], other.offsets[k]
        gap = over_plane(normal, offset, here.vertices)
        widest = max(widest, gap)
        if gap >= -depth:
            lowest = np.inf
            for i in range(len(mover.vertices)):
                still, rising = height(motion, mover.vertices[i], normal, offset)
                lowest = min(lowest, least(still, rising, over))
                if lowest < -depth:
                    break
            if lowest >= -depth:
                return np.inf
    return widest


@inlined
def _over_moving(
    mover: Hull, here: Hull, motion: Drive, other: Hull, over: Timespan, depth: float
) -> float:
    """Return +inf where a moving face separates over a stretch, else the widest gap at ``here``."""
    widest = -np.inf
    for k in range(len(mover.normals)):
        gap = over_plane(here.normals[k], here.offsets[k], other.vertices)
        widest = max(widest, gap)
        if gap >= -depth:
            lowest = np.inf
            for i in range(len(other.vertices)):
                still, rising = beneath(
                    motion, mover.normals[k], mover.offsets[k], other.vertices[i]
                )
                lowest = min(lowest, least(still, rising, over))
                if lowest < -depth:
                    break
            if lowest >= -depth:
                return np.inf
    return widest


class Crossed(NamedTuple):
    """The pair of edges across whose plane two pieces are widest apart.

    Attributes:
        gap: how far.
        mine: the first piece's edge; -1: no two edges cross.
        theirs: the other's.
        ahead: whether the first is on the side where the edges' cross product points.
        corner: the other's vertex that is nearest to the plane.
    """

    gap: float
    mine: int
    theirs: int
    ahead: bool
    corner: int


@lean
def crossed(a: Hull, b: Hull) -> Crossed:
    """Return the pair of edges with the widest gap."""
    best, mine, theirs, before, corner = -np.inf, -1, -1, True, 0
    for i in range(len(a.edges)):
        for j in range(len(b.edges)):
            e, f = a.edges[i], b.edges[j]  # no arrays from here on: this is asked most
            x, y, z = (
                e[1] * f[2] - e[2] * f[1],
                e[2] * f[0] - e[0] * f[2],
                e[0] * f[1] - e[1] * f[0],
            )
            sine = np.sqrt(x * x + y * y + z * z)
            if sine <= PARALLEL:
                continue
            x, y, z = x / sine, y / sine, z / sine
            (a_low, a_high), (b_low, b_high) = (np.inf, -np.inf), (np.inf, -np.inf)
            lowest = highest = 0
            for k in range(len(a.vertices)):
                p = a.vertices[k]
                value = x * p[0] + y * p[1] + z * p[2]
                a_low, a_high = min(a_low, value), max(a_high, value)
            for k in range(len(b.vertices)):
                p = b.vertices[k]
                value = x * p[0] + y * p[1] + z * p[2]
                if value < b_low:
                    b_low, lowest = value, k
                if value > b_high:
                    b_high, highest = value, k
            gap = max(a_low - b_high, b_low - a_high)
            if gap > best:
                ahead = a_low - b_high >= b_low - a_high
                best, mine, theirs, before = gap, i, j, ahead
                corner = highest if ahead else lowest
    return Crossed(best, mine, theirs, before, corner)


@inlined
def _spanned(
    mover: Hull, motion: Drive, other: Hull, pair: Crossed, over: Timespan, depth: float
) -> bool:
    """Whether the plane that two edges span separates throughout a stretch.

    Its normal is n = R e x f, R the turn, e the moving edge, f the fixed one. Written out, every
    height over it is linear in R.
    """
    sign = 1.0 if pair.ahead else -1.0
    mine, f = mover.edges[pair.mine], other.edges[pair.theirs]
    e = (sign * mine[0], sign * mine[1], sign * mine[2])
    axis, corner = motion.axis, other.vertices[pair.corner]
    one = turned(axis, e, across(f, between(corner, motion.pivot)))
    rising = turned(axis, e, across(f, motion.drift))
    none = (0.0, 0.0, 0.0)
    above = below = np.inf
    for i in range(len(mover.vertices)):
        arm = between(motion.pivot, mover.vertices[i])
        two = turned(axis, across(arm, e), f)
        still = (one[0] + two[0], one[1] + two[1], one[2] + two[2])
        above = min(above, least(still, rising, over))
    for i in range(len(other.vertices)):
        u, v, w = turned(axis, e, across(f, between(corner, other.vertices[i])))
        below = min(below, least((-u, -v, -w), none, over))
    u, v, w = turned(axis, e, f)
    cosine = -min(least((u, v, w), none, over), least((-u, -v, -w), none, over))
    length = np.sqrt(max(0.0, 1.0 - cosine * cosine))
    clear: bool = above + below >= -depth * length
    return clear


@lean
def decide(
    mover: Hull, motion: Drive, other: Hull, ends: tuple[float, float], depth: float,
    room: HullRoom,
) -> int:  # fmt: skip
    """Say of two pieces whether they penetrate each other by more than ``depth``.

    Args:
        mover: the one that moves, where it is at t = 0.
        motion: how.
        other: the one that does not.
        ends: t where the stretch begins, and where it ends.
        depth: allowed.
        room: for the mover.

    Returns:
        ``CLEAR``, ``BLOCKED`` or ``UNDECIDED``.
    """
    over = stretch(ends[0], ends[1], motion.angle)
    here = moved_hull(mover, motion, (ends[0] + ends[1]) / 2.0, room)
    deepest = _over_fixed(mover, here, motion, other, over, depth)
    if deepest == np.inf:
        return CLEAR
    deepest = max(deepest, _over_moving(mover, here, motion, other, over, depth))
    if deepest == np.inf:
        return CLEAR
    pair = crossed(here, other)
    if max(deepest, pair.gap) < -depth:
        return BLOCKED
    if pair.gap >= -depth and _spanned(mover, motion, other, pair, over, depth):
        return CLEAR
    return UNDECIDED


@lean
def width(a: Hull, b: Hull) -> float:
    """Return the gap between two pieces along the best separating axis, as ``gap`` does."""
    widest = crossed(a, b).gap
    for k in range(len(a.normals)):
        widest = max(widest, over_plane(a.normals[k], a.offsets[k], b.vertices))
    for k in range(len(b.normals)):
        widest = max(widest, over_plane(b.normals[k], b.offsets[k], a.vertices))
    return widest
