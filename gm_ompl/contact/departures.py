"""What leaves poses on the contact lattice, many poses at once: compiled.

From each pose the motions that are offered there, cut short where they end, but for those that
come to nothing or take the centre of mass out of its region.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.contact.expansion import Ended, Offered, Room, ended, forms
from gm_ompl.contact.offers import Rules, offered, stand
from gm_ompl.contact.poses import Book
from gm_ompl.contact.touching import NO_ROOM, Sheet, Solids, touched

FORM: Final = 9
"""Numbers that tell a motion's form."""


class Terrain(NamedTuple):
    """What motions go by, wherever they begin.

    Attributes:
        room: the object and what it may run into.
        bare: the same without obstacles.
        world: the object and what it may touch.
        floor: the same without obstacles.
        rules: what is offered.
        region: (2, 3), of the centre of mass.
        slack: how far out of it is still inside.
        far: obstacles farther from the centre of mass than this are out of reach.
        D: the object's diagonal.
    """

    room: Room
    bare: Room
    world: Solids
    floor: Solids
    rules: Rules
    region: Array
    slack: float
    far: float
    D: float


class Tails(NamedTuple):
    """Where motions begin.

    Attributes:
        places: (N,), numbers of poses.
        turning: (N,), 1 where a rotation is under way, else 0.
        lines: (N, 2, 3), its line, a point and a unit direction, world frame.
    """

    places: IntArray
    turning: IntArray
    lines: Array


class Departures(NamedTuple):
    """Motions, those from one pose behind those from the one before.

    Attributes:
        past: (N,), the row behind each pose's last.
        near: (N,), whether an obstacle may be in reach.
        untold: (N,), whether it is not known how the object stands there.
        turns: (M,), which are rotations.
        by: (M, 3), whole translations; of a rotation, a point of its line, world frame.
        axes: (M, 3), unit.
        angles: (M,), whole rotations [rad].
        steps: (M,), lengths in steps of the lattice.
        bare: (M,), whether the object touches nothing in the middle of some segment.
        rotations: (M, 3, 3), of the object at the end.
        positions: (M, 3), of its centre of mass there.
        forms: (M, FORM), equal for motions that are one as the object sees them, either way.
        ahead: (M,), which way each goes.
    """

    past: IntArray
    near: BoolArray
    untold: BoolArray
    turns: BoolArray
    by: Array
    axes: Array
    angles: Array
    steps: Array
    bare: BoolArray
    rotations: Array
    positions: Array
    forms: IntArray
    ahead: BoolArray


def departures(poses: int, room: int) -> Departures:
    """Return room for so many motions from so many poses."""
    flags = [np.zeros(n, dtype=bool) for n in (poses, poses, room, room, room)]
    return Departures(
        np.zeros(poses, np.int64), flags[0], flags[1], flags[2], np.empty((room, 3)),
        np.empty((room, 3)), np.empty(room), np.empty(room), flags[3], np.empty((room, 3, 3)),
        np.empty((room, 3)), np.empty((room, FORM), np.int64), flags[4],
    )  # fmt: skip


@compiled
def depart(
    tails: Tails, book: Book, terrain: Terrain, onto: Sheet, told: int, found: Departures
) -> int:
    """Write the motions from poses.

    Args:
        tails: where they begin.
        book: poses.
        terrain: what motions go by.
        onto: room for contacts.
        told: how many contacts the object has at the one pose, where they are written there
            already; else -1.
        found: written.

    Returns:
        0, or ``NO_ROOM``, for contacts or for motions.
    """
    count = 0
    for n in range(len(tails.places)):
        R, p = book.rotations[tails.places[n]], book.positions[tails.places[n]]
        found.near[n], past = in_reach(p, terrain), told
        if told < 0:
            past = touched(R, p, terrain.world if found.near[n] else terrain.floor, onto, 0)
        if past == NO_ROOM:
            return NO_ROOM
        found.untold[n] = past < 0
        if past >= 0:
            corners = onto.points[:past], onto.normals[:past]
            count = _motions(n, corners, tails, book, terrain, found, count)
        if count == NO_ROOM:
            return NO_ROOM
        found.past[n] = count
    return 0


@compiled
def in_reach(p: Array, terrain: Terrain) -> bool:
    """Whether an obstacle may be in reach of object or hand around a position (3,)."""
    low, high = terrain.room.obstacles.low, terrain.room.obstacles.high
    for j in range(len(low)):
        square = 0.0
        for c in range(3):
            way = min(max(p[c], low[j, c]), high[j, c]) - p[c]
            square += way * way
        if square <= terrain.far * terrain.far:
            return True
    return False


@inlined
def _motions(
    n: int, corners: tuple[Array, Array], tails: Tails, book: Book, terrain: Terrain,
    found: Departures, count: int,
) -> int:  # fmt: skip
    """Write the motions from a pose from a row on; return the row behind, or ``NO_ROOM``."""
    place, here, turning = tails.places[n], np.empty((1, 2, 3)), tails.turning[n]
    R, p = book.rotations[place], book.positions[place]
    for c in range(3):
        here[0, 0, c], here[0, 1, c] = tails.lines[n, 0, c] - p[c], tails.lines[n, 1, c]
    at = stand(p, corners[0], corners[1], terrain.rules)
    motions = offered(at, p, terrain.rules, here[:turning])
    got = ended(motions, R, p, terrain.room if found.near[n] else terrain.bare)
    numbers, ahead = forms(motions, got, R, terrain.D)
    for i in range(len(motions.steps)):
        if count != NO_ROOM and _inside(got, i, p, terrain):
            if count == len(found.steps):
                count = NO_ROOM
            else:
                _write(motions, got, i, p, found, count)
                found.ahead[count] = ahead[i]
                for k in range(FORM):
                    found.forms[count, k] = numbers[i, k]
                count += 1
    return count


@inlined
def _inside(got: Ended, i: int, p: Array, terrain: Terrain) -> bool:
    """Whether a motion comes to something, the centre of mass in its region all along."""
    inside = got.shares[i] > 0.0
    for k in range(3):
        inside &= p[k] + got.low[i, k] - terrain.region[0, k] >= -terrain.slack
        inside &= p[k] + got.high[i, k] - terrain.region[1, k] <= terrain.slack
    return bool(inside)


@inlined
def _write(motions: Offered, got: Ended, i: int, p: Array, found: Departures, row: int) -> None:
    found.turns[row], found.bare[row] = motions.turns[i], got.bare[i]
    found.angles[row] = got.shares[i] * motions.angles[i]
    found.steps[row] = got.shares[i] * motions.steps[i]
    for k in range(3):
        found.by[row, k] = motions.by[i, k] + p[k] if motions.turns[i] else got.ways[i, k]
        found.axes[row, k] = motions.axes[i, k]
        found.positions[row, k] = p[k] + got.ways[i, k]
        for c in range(3):
            found.rotations[row, k, c] = got.rotations[i, k, c]
