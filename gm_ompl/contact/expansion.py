"""What motions that are offered at a pose come to, compiled: where each ends, and how it is cut."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.contact.stops import Lengths, free_share
from gm_ompl.geometry.packed import Drive, Hulls, moved, moved_hull, one, placed, rotation
from gm_ompl.geometry.stretches import width
from gm_ompl.geometry.swept import boxes_meet
from gm_ompl.geometry.vectors import dot, minus, plus, product


class Offered(NamedTuple):
    """Motions at a pose, all seen from the centre of mass.

    Attributes:
        turns: (m,), which of them are rotations.
        by: (m, 3), translations; of a rotation, a point of its line.
        axes: (m, 3), unit, of the lines.
        angles: (m,) [rad].
        steps: (m,), lengths in steps of the lattice.
    """

    turns: BoolArray
    by: Array
    axes: Array
    angles: Array
    steps: Array


class Room(NamedTuple):
    """The object and what it may run into.

    Attributes:
        body: the object, object frame.
        obstacles: world frame.
        floor: whether there is one.
        lengths: what counts as nothing.
        shortest: an arc on which no corner goes farther is none.
        parts: segments per step.
    """

    body: Hulls
    obstacles: Hulls
    floor: bool
    lengths: Lengths
    shortest: float
    parts: int


class Ended(NamedTuple):
    """What motions come to.

    Attributes:
        shares: (m,), of each that the object can go; 0: it is too short to be an arc.
        ways: (m, 3), of the centre of mass.
        rotations: (m, 3, 3), of the object at the end.
        low: (m, 3), least coordinates of the centre of mass on the way, from where it begins.
        high: (m, 3), greatest.
        bare: (m,), whether the object touches nothing in the middle of some segment.
    """

    shares: Array
    ways: Array
    rotations: Array
    low: Array
    high: Array
    bare: BoolArray


@compiled
def ended(offered: Offered, R: Array, p: Array, room: Room) -> Ended:
    """Return what motions at the pose (3, 3), (3,) come to."""
    m, here = len(offered.steps), placed(room.body, R, p)
    shares, ways, rotations = np.zeros(m), np.zeros((m, 3)), np.empty((m, 3, 3))
    low, high = np.zeros((m, 3)), np.zeros((m, 3))
    bare, none = np.zeros(m, dtype=np.bool_), np.zeros(3)
    for i in range(m):
        by, axis, angle = offered.by[i], offered.axes[i], offered.angles[i]
        turns = offered.turns[i]
        pivot = plus(by, p)
        motion = Drive(pivot, axis, angle, none) if turns else Drive(p, axis, 0.0, by)
        share = free_share(here, motion, room.obstacles, room.floor, room.lengths)
        if share * _longest(here, motion) < room.shortest:
            continue
        shares[i] = share
        bare[i] = _bare(here, motion, share, offered.steps[i], room)
        if turns:
            Rt = rotation(axis, share * angle)
            for k in range(3):
                ways[i, k] = by[k] - dot(Rt[k], by)
                for c in range(3):
                    rotations[i, k, c] = dot(Rt[k], R[:, c])
            _widen(by, axis, share * angle, low[i], high[i])
        else:
            for k in range(3):
                ways[i, k] = by[k] if share == 1.0 else share * by[k]
                for c in range(3):
                    rotations[i, k, c] = R[k, c]
        for k in range(3):
            low[i, k] = min(low[i, k], ways[i, k])
            high[i, k] = max(high[i, k], ways[i, k])
    return Ended(shares, ways, rotations, low, high, bare)


@inlined
def _bare(here: Hulls, motion: Drive, share: float, steps: float, room: Room) -> bool:
    """Whether the object touches nothing in the middle of some segment."""
    pitch, t = 1.0 / (room.parts * steps), 0.0
    while t < share - 1e-12:
        end = min(t + pitch, share)
        if not touching(here, motion, (t + end) / 2.0, room):
            return True
        t = end
    return False


@compiled
def touching(here: Hulls, motion: Drive, t: float, room: Room) -> bool:
    """Whether the object, given at t = 0, touches floor or obstacles at ``t``, or overlaps them."""
    margin = room.lengths.touching
    for k in range(len(here.low)):
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        mover = one(here, k)
        places = moved(mover.vertices, motion, t)
        for i in range(len(places)):
            for c in range(3):
                low[c], high[c] = min(low[c], places[i, c]), max(high[c], places[i, c])
        if room.floor and low[2] <= margin:
            return True
        for j in range(len(room.obstacles.low)):
            if (
                boxes_meet(low, high, room.obstacles, j, margin)
                and width(moved_hull(mover, motion, t), one(room.obstacles, j)) <= margin
            ):
                return True
    return False


@inlined
def _longest(here: Hulls, motion: Drive) -> float:
    """Return how far a corner goes at most."""
    if motion.angle == 0.0:
        return float(np.sqrt(dot(motion.drift, motion.drift)))
    farthest = 0.0
    for i in range(len(here.all.vertices)):
        arm = minus(here.all.vertices[i], motion.pivot)
        along = dot(arm, motion.axis)
        farthest = max(farthest, dot(arm, arm) - along * along)
    return float(abs(motion.angle) * np.sqrt(farthest))


@inlined
def _widen(pivot: Array, axis: Array, angle: float, low: Array, high: Array) -> None:
    """Widen a box by where a point that begins at the origin has its extremes in a turn."""
    along, arm = dot(pivot, axis), np.empty(3)
    for k in range(3):
        arm[k] = along * axis[k] - pivot[k]  # from the line
    ahead = product(axis, arm)
    for k in range(3):
        top = np.arctan2(ahead[k], arm[k])
        for at in (top, top + np.pi):
            way = np.mod(at, 2.0 * np.pi)
            if angle < 0.0:
                way -= 2.0 * np.pi
            if 0.0 < way / angle < 1.0:
                place = np.cos(way) * arm[k] + np.sin(way) * ahead[k] - arm[k]
                low[k], high[k] = min(low[k], place), max(high[k], place)


@compiled
def touches(R: Array, p: Array, room: Room) -> bool:
    """Whether the object touches anything at a pose, or overlaps it."""
    still = Drive(p, np.array([0.0, 0.0, 1.0]), 0.0, np.zeros(3))
    return bool(touching(placed(room.body, R, p), still, 0.0, room))


DIGITS: Final = 1e9
"""Forms equal to one part in so many (of D, or in radians) are one."""


@compiled
def forms(offered: Offered, found: Ended, R: Array, D: float) -> tuple[IntArray, BoolArray]:
    """Return what is equal for motions that are one as the object sees them, whichever way.

    Returns:
        (m, 9), the numbers of each; (m,), which way it goes.
    """
    m, parts, vector, beside = len(offered.steps), np.empty(3), np.empty(3), np.empty(3)
    numbers, ahead = np.zeros((m, 9), dtype=np.int64), np.ones(m, dtype=np.bool_)
    for i in range(m):
        turns, size = offered.turns[i], abs(found.shares[i] * offered.angles[i])
        scale = 1.0
        if not turns:
            size = np.sqrt(dot(found.ways[i], found.ways[i])) / D
            scale = 1.0 / max(size * D, 1e-300)
        most = 0.0
        for k in range(3):
            vector[k] = scale * (offered.axes[i, k] if turns else found.ways[i, k])
        along = dot(offered.by[i], vector)
        for k in range(3):
            beside[k] = offered.by[i, k] - along * vector[k]
            parts[k] = dot(R[:, k], vector)
            most = max(most, abs(parts[k]))
        sign = 0.0
        for k in range(3):
            if sign == 0.0 and abs(parts[k]) >= most - 1e-6:
                sign = 1.0 if parts[k] > 0.0 else -1.0
        ahead[i] = (sign > 0.0) == (not turns or offered.angles[i] > 0.0)
        for k in range(3):
            numbers[i, k] = np.rint(sign * parts[k] * DIGITS)
            if turns:
                numbers[i, 3 + k] = np.rint(dot(R[:, k], beside) / D * DIGITS)
        numbers[i, 6] = np.rint(size * DIGITS)
        numbers[i, 7] = np.rint(found.shares[i] * offered.steps[i] * DIGITS)
        numbers[i, 8] = 1 if turns else 0
    return numbers, ahead
