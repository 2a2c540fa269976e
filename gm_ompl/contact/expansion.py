"""What motions that are offered at a pose come to, compiled: where each ends, and how it is cut."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.contact.stops import Lengths, StopRoom, free_share, stop_room
from gm_ompl.geometry.packed import (
    Drive,
    HullRoom,
    Hulls,
    hull_room,
    moved_hull,
    piece,
    placed,
    write_rotation,
)
from gm_ompl.geometry.stretches import width
from gm_ompl.geometry.swept import boxes_meet
from gm_ompl.geometry.vectors import across, between, dot


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


class EndRoom(NamedTuple):
    """Room for finding what motions come to.

    Attributes:
        stops: for where they end.
        pivot: (3,), for a point of a line, world frame.
        still: (3,), 0.
    """

    stops: StopRoom
    pivot: Array
    still: Array


@compiled
def ended(offered: Offered, R: Array, p: Array, room: Room) -> Ended:
    """Return what motions at the pose (3, 3), (3,) come to."""
    m, here = len(offered.steps), placed(room.body, R, p)
    found = Ended(
        np.zeros(m), np.zeros((m, 3)), np.empty((m, 3, 3)), np.zeros((m, 3)), np.zeros((m, 3)),
        np.zeros(m, dtype=np.bool_),
    )  # fmt: skip
    bench = EndRoom(stop_room(here, room.obstacles), np.empty(3), np.zeros(3))
    for i in range(m):
        _end(i, here, offered, (R, p), room, bench, found)
    return found


@lean
def _end(
    i: int, here: Hulls, offered: Offered, at: tuple[Array, Array], room: Room, bench: EndRoom,
    found: Ended,
) -> None:  # fmt: skip
    """Write what a motion comes to."""
    by, axis, turns = offered.by[i], offered.axes[i], offered.turns[i]
    for k in range(3):
        bench.pivot[k] = at[1][k] + (by[k] if turns else 0.0)
    angle = offered.angles[i] if turns else 0.0
    motion = Drive(bench.pivot, axis, angle, bench.still if turns else by)
    share = free_share(here, motion, room.obstacles, room.floor, room.lengths, bench.stops)
    if share * _longest(here, motion) < room.shortest:
        return
    found.shares[i] = share
    found.bare[i] = _bare(here, motion, (share, offered.steps[i]), room, bench.stops.hull)
    if turns:
        _write_turn(i, motion, by, share, at[0], found, bench.stops.hull.R)
    else:
        for k in range(3):
            found.ways[i, k] = by[k] if share == 1.0 else share * by[k]
            for c in range(3):
                found.rotations[i, k, c] = at[0][k, c]
    for k in range(3):
        found.low[i, k] = min(found.low[i, k], found.ways[i, k])
        found.high[i, k] = max(found.high[i, k], found.ways[i, k])


@inlined
def _write_turn(
    i: int, motion: Drive, by: Array, share: float, R: Array, found: Ended, turned: Array
) -> None:
    """Write where a rotation leads; ``turned`` (3, 3) is room."""
    write_rotation(motion.axis, share * motion.angle, turned)
    for k in range(3):
        found.ways[i, k] = by[k] - dot(turned[k], by)
        for c in range(3):
            found.rotations[i, k, c] = dot(turned[k], R[:, c])
    _widen(by, motion.axis, share * motion.angle, found.low[i], found.high[i])


@inlined
def _bare(
    here: Hulls, motion: Drive, length: tuple[float, float], room: Room, hull: HullRoom
) -> bool:
    """Whether the object touches nothing in the middle of some segment.

    Of a motion by a share, of so many steps.
    """
    share, steps = length
    pitch, t = 1.0 / (room.parts * steps), 0.0
    while t < share - 1e-12:
        end = min(t + pitch, share)
        if not _touching(here, motion, (t + end) / 2.0, room, hull):
            return True
        t = end
    return False


@lean
def _touching(here: Hulls, motion: Drive, t: float, room: Room, hull: HullRoom) -> bool:
    """Whether the object, given at t = 0, touches floor or obstacles at ``t``, or overlaps them."""
    margin, low, high = room.lengths.touching, hull.box[0], hull.box[1]
    for k in range(len(here.low)):
        mover = piece(here, k)
        there = moved_hull(mover, motion, t, hull)
        for c in range(3):
            low[c], high[c] = np.inf, -np.inf
            for i in range(len(there.vertices)):
                low[c], high[c] = (
                    min(low[c], there.vertices[i, c]),
                    max(high[c], there.vertices[i, c]),
                )
        if room.floor and low[2] <= margin:
            return True
        for j in range(len(room.obstacles.low)):
            if (
                boxes_meet(low, high, room.obstacles, j, margin)
                and width(there, piece(room.obstacles, j)) <= margin
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
        arm = between(motion.pivot, here.all.vertices[i])
        along = dot(arm, motion.axis)
        farthest = max(farthest, dot(arm, arm) - along * along)
    return float(abs(motion.angle) * np.sqrt(farthest))


@inlined
def _widen(pivot: Array, axis: Array, angle: float, low: Array, high: Array) -> None:
    """Widen a box by where a point that begins at the origin has its extremes in a turn."""
    along = dot(pivot, axis)
    arm = (  # from the line
        along * axis[0] - pivot[0],
        along * axis[1] - pivot[1],
        along * axis[2] - pivot[2],
    )
    ahead = across(axis, arm)
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
    return bool(_touching(placed(room.body, R, p), still, 0.0, room, hull_room(room.body)))


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
