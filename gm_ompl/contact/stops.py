"""Where a screw motion of the object ends: where it would penetrate, or a new contact closes."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.contact.closing import BRACKET, Pair, closing, leaving
from gm_ompl.geometry.facets import PARALLEL
from gm_ompl.geometry.packed import (
    Drive,
    Hull,
    HullRoom,
    Hulls,
    hull_room,
    piece,
    write_way_box,
)
from gm_ompl.geometry.stretches import BLOCKED, CLEAR, decide, height, least, stretch, width
from gm_ompl.geometry.swept import UP, boxes_meet
from gm_ompl.geometry.vectors import across, dot

ROUNDING: Final = 1e-10
"""Gaps are known to this, relative to D."""

WHOLE: Final = 1e-9
"""An end within this share of the whole motion is the whole."""

TOUCH: Final = 1e-9
"""Gaps of pieces that were apart count as closed from here on, relative to D: poses that end at a
contact are no more exact after many arcs."""

CLOSED: Final = 4e-15
"""What the sum of a gap leaves of none, relative to D."""

MOST_STRETCHES: Final = 2000
"""Stretches looked at for one pair; beyond, the motion ends where it was known to be clear."""

DEEP: Final = 1e-8
"""Two depths, this and twice this, relative to D, tell where a kept contact begins to sink."""


class Lengths(NamedTuple):
    """What counts as nothing.

    Attributes:
        touching: the contact tolerance.
        rounding: how well gaps are known.
        touch: gaps at most this wide of pieces that were apart are closed.
        closed: what a gap's sum leaves of none.
        deep: tells where a kept contact begins to sink.
    """

    touching: float
    rounding: float
    touch: float
    closed: float
    deep: float


def lengths(diagonal: float, tolerance: float) -> Lengths:
    """Return what counts as nothing beside D, contacts known to ``tolerance`` (relative to D)."""
    small = (tolerance, ROUNDING, TOUCH, CLOSED, DEEP)
    return Lengths(*(share * diagonal for share in small))


class StopRoom(NamedTuple):
    """Room for finding where motions end.

    Attributes:
        hull: for a piece that has moved.
        left: (n, 2), for stretches still to be looked at.
        axes: (n, 3), for directions that separate two pieces.
        gaps: (n,), for the gaps along them.
        rates: (n,), for how fast these change.
    """

    hull: HullRoom
    left: Array
    axes: Array
    gaps: Array
    rates: Array


@compiled
def stop_room(body: Hulls, obstacles: Hulls) -> StopRoom:
    """Return room for a body beside obstacles."""
    n, a, b = 0, body.ends, obstacles.ends
    for k in range(len(body.low)):
        for j in range(len(obstacles.low)):
            faces = a[k + 1, 1] - a[k, 1] + b[j + 1, 1] - b[j, 1]
            pairs = (a[k + 1, 2] - a[k, 2]) * (b[j + 1, 2] - b[j, 2])
            n = max(n, faces + 2 * pairs)
    left = np.empty((MOST_STRETCHES + 2, 2))
    return StopRoom(hull_room(body), left, np.empty((n, 3)), np.empty(n), np.empty(n))


@lean
def free_share(
    here: Hulls, motion: Drive, obstacles: Hulls, floor: bool, small: Lengths, room: StopRoom
) -> float:
    """Return the share of a motion that a body, given at t = 0, can go."""
    share = 1.0
    if floor:
        for k in range(len(here.low)):
            share = min(share, _over_floor(piece(here, k), motion, small))
    for k in range(len(here.low)):
        mover = piece(here, k)
        for j in range(len(obstacles.low)):
            write_way_box(mover.vertices, motion, share, room.hull)
            low, high = room.hull.box[0], room.hull.box[1]
            if boxes_meet(low, high, obstacles, j, small.touching):
                share = min(share, _beside(mover, motion, piece(obstacles, j), small, room))
    return 1.0 if share >= 1.0 - WHOLE else share


@inlined
def _over_floor(mover: Hull, motion: Drive, small: Lengths) -> float:
    """Return the share that a piece can go over the floor."""
    over = stretch(0.0, 1.0, motion.angle)
    first = np.inf
    for i in range(len(mover.vertices)):
        first = min(first, mover.vertices[i, 2])
    touches, share = first <= small.touching, 1.0
    for i in range(len(mover.vertices)):
        still, rising = height(motion, mover.vertices[i], UP, 0.0)
        at_first, lowest = mover.vertices[i, 2], least(still, rising, over)
        # What touches may go no deeper than a contact is; what is apart ends where it touches.
        if (lowest >= -small.touching) if touches else (lowest > small.touch):
            continue
        # A corner on the floor sinks from where it is; others come down to it.
        level = 0.0
        if at_first <= small.touching:
            level = min(at_first, 0.0) - small.rounding
        if motion.angle == 0.0:
            share = min(share, max(0.0, (level - at_first) / rising[0]))
        else:
            a, b, c = still
            c = c if motion.angle > 0.0 else -c
            cosine = min(1.0, max(-1.0, (level - a) / np.hypot(b, c)))
            angle = np.mod(np.arctan2(c, b) + np.arccos(cosine), 2.0 * np.pi)
            share = min(share, angle / abs(motion.angle))
    return share


@lean
def _beside(mover: Hull, motion: Drive, other: Hull, small: Lengths, room: StopRoom) -> float:
    """Return the share that a piece can go beside one of the environment."""
    if motion.angle == 0.0:
        return _sliding(mover, other, motion.drift, small, room)
    wide = width(mover, other)
    apart = wide > small.touching
    depth = -small.touch if apart else small.touching
    first, last = _bracket(mover, motion, other, depth, room)
    if first > 1.0:
        return 1.0
    pair = Pair(mover, motion, other, 0.0 if apart else min(wide, 0.0), room.hull)
    if apart:
        return closing(pair, first, last, small.closed, small.rounding)
    return leaving(pair, last, small.deep)


@inlined
def _sliding(here: Hull, there: Hull, drift: Array, small: Lengths, room: StopRoom) -> float:
    """Return the share of a translation until two pieces touch, or penetrate."""
    axes, gaps, rates, wide = room.axes, room.gaps, room.rates, -np.inf
    n = _write_separating(here, there, axes)
    for k in range(n):
        near, far = np.inf, -np.inf
        for i in range(len(here.vertices)):
            near = min(near, dot(axes[k], here.vertices[i]))
        for i in range(len(there.vertices)):
            far = max(far, dot(axes[k], there.vertices[i]))
        gaps[k], rates[k] = near - far, dot(axes[k], drift)
        wide = max(wide, gaps[k])
    apart = wide > small.touching
    level = small.touch if apart else -small.touching
    exact = 0.0 if apart else min(wide, 0.0) - small.rounding
    first = share = -np.inf
    last = np.inf
    for k in range(n):
        if rates[k] < -small.rounding:
            first = max(first, (level - gaps[k]) / rates[k])
            share = max(share, (exact - gaps[k]) / rates[k])
        elif rates[k] > small.rounding:
            last = min(last, (level - gaps[k]) / rates[k])
        elif gaps[k] > level:
            return 1.0
    if first == -np.inf or last < 0.0 or first > min(last, 1.0):
        return 1.0
    return min(1.0, max(0.0, share))


@inlined
def _write_separating(here: Hull, there: Hull, axes: Array) -> int:
    """Write directions, from the second piece to the first, one of which separates them.

    Returns:
        How many they are.
    """
    f, g = len(there.normals), len(here.normals)
    count = f + g
    for k in range(3):
        for i in range(f):
            axes[i, k] = there.normals[i, k]
        for i in range(g):
            axes[f + i, k] = -here.normals[i, k]
    for i in range(len(here.edges)):
        for j in range(len(there.edges)):
            axis = across(here.edges[i], there.edges[j])
            sine = np.sqrt(dot(axis, axis))
            if sine > PARALLEL:
                for k in range(3):
                    axes[count, k] = axis[k] / sine
                    axes[count + 1, k] = -axes[count, k]
                count += 2
    return count


@inlined
def _bracket(
    mover: Hull, motion: Drive, other: Hull, depth: float, room: StopRoom
) -> tuple[float, float]:
    """Return (t, t'), clear up to t and blocked somewhere up to t'; both 2: clear throughout."""
    left, count = room.left, 1
    left[0, 0], left[0, 1] = 0.0, 1.0
    for _ in range(MOST_STRETCHES):
        if count == 0:
            return 2.0, 2.0
        count -= 1
        first, last = left[count, 0], left[count, 1]
        answer = decide(mover, motion, other, (first, last), depth, room.hull)
        if answer == CLEAR:
            continue
        middle = (first + last) / 2.0
        if last - first <= BRACKET:
            return first, last
        if answer == BLOCKED:
            left[0, 0], left[0, 1], count = first, middle, 1
        else:
            left[count, 0], left[count, 1] = middle, last
            left[count + 1, 0], left[count + 1, 1] = first, middle
            count += 2
    if count == 0:
        return 2.0, 2.0
    return left[count - 1, 0], left[count - 1, 1]
