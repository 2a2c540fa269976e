"""What penetrates nothing anywhere along a motion, not at some places of it alone.

Two convex bodies are clear of each other over a stretch of time where one plane separates them
throughout (``stretches``). Where no plane does, the stretch is halved, until the bodies penetrate
each other in its middle or every part is clear.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.geometry.collision import EXACT, Scene, allowed_depth
from gm_ompl.geometry.packed import (
    Drive,
    Hull,
    HullRoom,
    Hulls,
    drive,
    hull_room,
    packed,
    piece,
    placed,
    rotation,
    write_moved,
    write_rotation,
    write_way_box,
)
from gm_ompl.geometry.stretches import BLOCKED, CLEAR, decide, height, least, stretch
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.geometry.vectors import dot

SHORTEST: Final = 1e-9
"""A stretch of time so short that is still undecided counts as blocked."""

UP: Final = (0.0, 0.0, 1.0)

MOST_STRETCHES: Final = 500
"""Stretches looked at for one pair: a contact that no plane keeps would take them without end."""


class SweptScene:
    """The object, its environment, and whether they penetrate each other along a motion.

    Args:
        scene: the same at single poses.

    Attributes:
        body: the object, object frame.
        obstacles: what is in its way, world frame.
        floor: whether there is one.
        depth: how far the object may penetrate.
    """

    def __init__(self, scene: Scene) -> None:
        self.depth, self.floor, D = scene.depth, scene.floor, scene.body.diagonal
        self.body, self.obstacles = packed(scene.body.pieces), packed(scene.obstacles)
        allowed = [allowed_depth(D, piece) for piece in scene.obstacles]
        self._allowed = np.array([EXACT * D, *allowed])

    def object_free(self, sweep: Sweep) -> bool:
        """Whether the object penetrates neither floor nor obstacles along ``sweep``."""
        start = sweep.start
        here = placed(self.body, start.rotation.copy(), start.position.copy())
        return body_clear(here, drive(sweep), self.obstacles, self.floor, self.depth)

    def free_placements(self, sweep: Sweep, centres: Array, radius: float) -> BoolArray:
        """Return which fingertips (P,) do not penetrate the environment along ``sweep``.

        Args:
            sweep: how the object moves.
            centres: (P, 3), the fingertips' centres, object frame.
            radius: their radius.
        """
        free = np.ones(len(centres), dtype=np.bool_)
        here, gaps = sweep.start.apply(centres), self.gaps(radius)
        tips_clear(here, drive(sweep), self.obstacles, self.floor, gaps, free)
        return free

    def gaps(self, radius: float) -> Array:
        """Return how near centres of fingertips may come to floor and obstacles (1 + k,)."""
        gaps: Array = radius - self._allowed
        return gaps


@compiled
def body_clear(here: Hulls, motion: Drive, obstacles: Hulls, floor: bool, depth: float) -> bool:
    """Whether a body, given at t = 0, penetrates neither floor nor obstacles by over ``depth``."""
    room, left = hull_room(here), np.empty((MOST_STRETCHES + 2, 2))
    return bool(_is_clear(here, motion, obstacles, (floor, depth), room, left))


@lean
def _is_clear(
    here: Hulls, motion: Drive, obstacles: Hulls, bounds: tuple[bool, float], room: HullRoom,
    left: Array,
) -> bool:  # fmt: skip
    """Do what ``body_clear`` does; there is room for it."""
    floor, depth = bounds
    for k in range(len(here.low)):
        mover = piece(here, k)
        if floor and lowest(mover.vertices, motion) < -depth:
            return False
        write_way_box(mover.vertices, motion, 1.0, room)
        for j in range(len(obstacles.low)):
            if boxes_meet(room.box[0], room.box[1], obstacles, j, 0.0) and not _pair_clear(
                mover, motion, piece(obstacles, j), depth, room, left
            ):
                return False
    return True


@lean
def boxes_meet(low: Array, high: Array, hulls: Hulls, j: int, margin: float) -> bool:
    """Whether a box (3,), (3,) reaches to within ``margin`` of the one around piece ``j``."""
    for k in range(3):
        if low[k] - margin > hulls.high[j, k] or hulls.low[j, k] > high[k] + margin:
            return False
    return True


@inlined
def lowest(points: Array, motion: Drive) -> float:
    """Return the least height over the floor of points (n, 3) along a motion."""
    found, over = np.inf, stretch(0.0, 1.0, motion.angle)
    for i in range(len(points)):
        still, rising = height(motion, points[i], UP, 0.0)
        found = min(found, least(still, rising, over))
    return found


@inlined
def _pair_clear(
    mover: Hull, motion: Drive, other: Hull, depth: float, room: HullRoom, left: Array
) -> bool:
    """Whether a moving piece penetrates another nowhere by more than ``depth``."""
    left[0, 0], left[0, 1], count = 0.0, 1.0, 1
    for _ in range(MOST_STRETCHES):
        if count == 0:
            return True
        count -= 1
        first, last = left[count, 0], left[count, 1]
        answer = decide(mover, motion, other, (first, last), depth, room)
        if answer == CLEAR:
            continue
        if answer == BLOCKED or last - first <= SHORTEST:
            return False
        middle = (first + last) / 2.0
        left[count, 0], left[count, 1] = first, middle
        left[count + 1, 0], left[count + 1, 1] = middle, last
        count += 2
    return count == 0


@compiled
def tips_clear(
    centres: Array, motion: Drive, obstacles: Hulls, floor: bool, least_gaps: Array, free: BoolArray
) -> None:
    """Write which fingertips stay away from floor and obstacles; those not free are left out.

    Args:
        centres: (P, 3), of the fingertips at t = 0, world frame.
        motion: how they move.
        obstacles: what stands in their way.
        floor: whether there is one.
        least_gaps: (1 + k,), how near centres may come to the floor, and to each obstacle.
        free: (P,), True where asked.
    """
    room = TipRoom(
        np.empty((MOST_STRETCHES + 2, 2)), rotation(motion.axis, motion.angle), np.empty((2, 3)),
        np.empty((3, 3)), np.empty((1, 3)), np.empty(3),
    )  # fmt: skip
    _write_clear(centres, motion, obstacles, floor, least_gaps, room, free)


class TipRoom(NamedTuple):
    """What the test of a fingertip needs.

    Attributes:
        left: (n, 2), stretches still to be looked at.
        turn: (3, 3), the whole rotation.
        box: (2, 3), where the fingertip stays.
        R: (3, 3), the rotation up to some time.
        place: (1, 3), where the fingertip is then.
        normal: (3,), of a plane.
    """

    left: Array
    turn: Array
    box: Array
    R: Array
    place: Array
    normal: Array


@lean
def _write_clear(
    centres: Array, motion: Drive, obstacles: Hulls, floor: bool, least_gaps: Array,
    room: TipRoom, free: BoolArray,
) -> None:  # fmt: skip
    """Do what ``tips_clear`` does; there is room for it."""
    over, low, high = stretch(0.0, 1.0, motion.angle), room.box[0], room.box[1]
    for i in range(len(centres)):
        if not free[i]:
            continue
        point = centres[i : i + 1]
        if floor:
            still, rising = height(motion, point[0], UP, 0.0)
            if least(still, rising, over) < least_gaps[0]:
                free[i] = False
                continue
        _box_of_way(point[0], motion, room.turn, low, high)
        for j in range(len(obstacles.low)):
            gap = least_gaps[1 + j]
            if boxes_meet(low, high, obstacles, j, gap) and not _tip_clear(
                point, motion, obstacles, (j, gap), room
            ):
                free[i] = False
                break


@inlined
def _box_of_way(point: Array, motion: Drive, turn: Array, low: Array, high: Array) -> None:
    """Write a box in which a point (3,) stays all along a motion, as ``way_box`` has it."""
    axis, pivot, half = motion.axis, motion.pivot, abs(motion.angle) / 2.0
    x, y, z = point[0] - pivot[0], point[1] - pivot[1], point[2] - pivot[2]
    along = x * axis[0] + y * axis[1] + z * axis[2]
    wide = max(0.0, x * x + y * y + z * z - along * along)
    bulge = np.sqrt(wide) * ((1.0 - np.cos(half)) if half < np.pi / 2 else 2.0)
    for k in range(3):
        end = turn[k, 0] * x + turn[k, 1] * y + turn[k, 2] * z + pivot[k] + motion.drift[k]
        low[k], high[k] = min(point[k], end) - bulge, max(point[k], end) + bulge


@lean
def _tip_clear(
    point: Array, motion: Drive, hulls: Hulls, piece: tuple[int, float], room: TipRoom
) -> bool:
    """Whether a point (1, 3) stays away from a piece: its number, and the least gap."""
    (j, gap), left, place, h = piece, room.left, room.place[0], hulls.all
    left[0, 0], left[0, 1], count = 0.0, 1.0, 1
    for _ in range(MOST_STRETCHES):
        if count == 0:
            return True
        count -= 1
        first, last = left[count, 0], left[count, 1]
        over, middle = stretch(first, last, motion.angle), (first + last) / 2.0
        write_rotation(motion.axis, middle * motion.angle, room.R)
        write_moved(point, motion, middle, room.R, room.place)
        clear, highest = False, -np.inf
        for k in range(hulls.ends[j, 1], hulls.ends[j + 1, 1]):
            above = dot(h.normals[k], place) - h.offsets[k]
            highest = max(highest, above)
            if above >= gap and not clear:
                still, rising = height(motion, point[0], h.normals[k], h.offsets[k])
                clear = least(still, rising, over) >= gap
        if clear:
            continue
        # The plane through the point of the edges that is nearest in the middle.
        _from_edges(place, hulls, j, room.normal)
        support = -np.inf
        for v in range(hulls.ends[j, 0], hulls.ends[j + 1, 0]):
            support = max(support, dot(room.normal, h.vertices[v]))
        if max(highest, dot(room.normal, place) - support) < gap:
            return False
        still, rising = height(motion, point[0], room.normal, support)
        if least(still, rising, over) >= gap:
            continue
        if last - first <= SHORTEST:
            return False
        left[count, 0], left[count, 1] = first, middle
        left[count + 1, 0], left[count + 1, 1] = middle, last
        count += 2
    return count == 0


@inlined
def _from_edges(place: Array, hulls: Hulls, j: int, normal: Array) -> None:
    """Write the unit direction (3,) to a place from the nearest point of a piece's edges."""
    best, starts, spans = np.inf, hulls.all.starts, hulls.all.spans
    normal[0] = normal[1] = normal[2] = 0.0
    for k in range(hulls.ends[j, 3], hulls.ends[j + 1, 3]):
        span, start = spans[k], starts[k]
        x, y, z = place[0] - start[0], place[1] - start[1], place[2] - start[2]
        along = x * span[0] + y * span[1] + z * span[2]
        share = min(1.0, max(0.0, along / dot(span, span)))
        x, y, z = x - share * span[0], y - share * span[1], z - share * span[2]
        square = x * x + y * y + z * z
        if square < best:
            best, normal[0], normal[1], normal[2] = square, x, y, z
    length = max(np.sqrt(best), 1e-300)
    for c in range(3):
        normal[c] /= length
