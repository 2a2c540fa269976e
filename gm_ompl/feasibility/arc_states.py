"""Contact states in the middles of a screw's segments, all at once: compiled."""

from __future__ import annotations

import itertools
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled_as_written, inlined
from gm_ompl.contact.environment import AT_REST
from gm_ompl.contact.state import ContactState
from gm_ompl.contact.touching import NO_ROOM, Sheet, Solids, sheet, solids, touched
from gm_ompl.feasibility.keys import DECIMALS
from gm_ompl.geometry.flat import combined, summed
from gm_ompl.geometry.vectors import dot
from gm_ompl.motion.arc import Arc
from gm_ompl.motion.screw import Screw, Slide
from gm_ompl.problem import Problem

COLUMNS = 10
"""Numbers that a key has of a contact: point, normal, slip and, perhaps, what it is on."""

ANY_AXIS = np.array([0.0, 0.0, 1.0])
"""A translation's."""


class PackedScrew(NamedTuple):
    """A screw, as compiled code reads it.

    Attributes:
        R: (3, 3), the rotation where it begins.
        p: (3,), the centre of mass there.
        by: (3,), the whole translation; of a rotation, a point of its line.
        axis: (3,), unit, its direction.
        angle: the whole rotation; 0: a translation.
        rate: how much of the whole is passed while t runs from 0 to 1.
    """

    R: Array
    p: Array
    by: Array
    axis: Array
    angle: float
    rate: float


class StateRoom(NamedTuple):
    """Room for contact states, object frame, one behind the other.

    Attributes:
        at: points, normals and what they are on.
        slip: (room, 3).
        rotations: (K, 3, 3).
        past: (K, 2), behind each state's last contact, and behind its key.
        keys: (COLUMNS room + 9 K,), as ``contact_key`` has them.
    """

    at: Sheet
    slip: Array
    rotations: Array
    past: IntArray
    keys: Array


@final
class ArcStates:
    """Finds the contact states along arcs.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self._world = solids(problem.body, problem.environment)
        self._inside, self._D, self._room = (
            problem.environment.patch_points,
            problem.body.diagonal,
            64,
        )
        self._states = state_room(self._room, 1)

    def along(self, arc: Arc, parts: int) -> list[bytes] | None:
        """Return the states' keys, as ``contact_key`` has them; None where it is not known how.

        Args:
            arc: the motion.
            parts: in how many segments.
        """
        if self._inside or not isinstance(arc, Screw):
            return None
        looks = np.array(arc.looks(parts))
        piece, origin = arc.whole, arc.origin
        rate, begin = arc.last - arc.first, (origin.rotation.copy(), origin.position.copy())
        if isinstance(piece, Slide):
            course = PackedScrew(*begin, piece.by.copy(), ANY_AXIS, 0.0, rate)
        else:
            course = PackedScrew(*begin, piece.pivot.copy(), piece.axis.copy(), piece.angle, rate)
        looks = arc.first + looks * rate
        past = NO_ROOM
        while past == NO_ROOM:
            if len(looks) > len(self._states.past):
                self._states = state_room(self._room, len(looks))
            past = states_along(course, looks, self._world, self._states, self._D)
            if past == NO_ROOM:
                self._room *= 2
                self._states = state_room(self._room, len(looks))
        if past < 0:
            return None
        ends, keys = self._states.past[: len(looks), 1].tolist(), self._states.keys
        return [keys[a:b].tobytes() for a, b in itertools.pairwise([0, *ends])]

    def state(self, k: int) -> ContactState:
        """Return state ``k`` of the last arc."""
        s = self._states
        part = slice(int(s.past[k - 1, 0]) if k else 0, int(s.past[k, 0]))
        points, normals, surfaces = (
            s.at.points[part],
            s.at.normals[part],
            s.at.surfaces[part].copy(),
        )
        return ContactState(points, normals, s.slip[part], s.rotations[k], surfaces)


def state_room(contacts: int, states: int) -> StateRoom:
    """Return room for so many contacts and states."""
    return StateRoom(
        sheet(contacts), np.empty((contacts, 3)), np.empty((states, 3, 3)),
        np.empty((states, 2), dtype=np.int64), np.empty(COLUMNS * contacts + 9 * states),
    )  # fmt: skip


@compiled_as_written
def states_along(
    course: PackedScrew, fractions: Array, world: Solids, found: StateRoom, D: float
) -> int:
    """Write the contact states at fractions (K,) of a screw; return what ``touched`` does."""
    past, end, p, linear = 0, 0, np.empty(3), np.empty(3)
    angular = np.zeros(3)
    for k in range(len(fractions)):
        R = found.rotations[k]
        _move(course, fractions[k], R, p)
        for c in range(3):
            linear[c] = course.rate * course.by[c]
        if course.angle != 0.0:
            for c in range(3):
                angular[c] = course.rate * course.angle * course.axis[c]
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                linear[c] = angular[d] * (p[e] - course.by[e]) - angular[e] * (p[d] - course.by[d])
        first, past = past, touched(R, p, world, found.at, past)
        if past < 0:
            return past
        slow = AT_REST * _fastest(world, R, linear, angular)
        past = _kept(found, first, past, (R, p), (linear, angular), slow)
        end = _key(found, first, past, k, end, D)
        found.past[k, 0], found.past[k, 1] = past, end
    return past


@inlined
def _move(course: PackedScrew, fraction: float, R: Array, p: Array) -> None:
    """Write the pose after a fraction of a screw."""
    if course.angle == 0.0:
        for c in range(3):
            p[c] = course.p[c] + fraction * course.by[c]
            for d in range(3):
                R[c, d] = course.R[c, d]
        return
    angle, size = fraction * course.angle, np.sqrt(summed(course.axis, course.axis))
    x, y, z = course.axis[0] / size, course.axis[1] / size, course.axis[2] / size
    across, turn, arm = np.zeros((3, 3)), np.empty((3, 3)), np.empty(3)
    across[0, 1], across[0, 2], across[1, 2] = -z, y, -x
    across[1, 0], across[2, 0], across[2, 1] = z, -y, x
    sine, rest = np.sin(angle), 1.0 - np.cos(angle)
    for c in range(3):
        arm[c] = course.p[c] - course.by[c]
        for d in range(3):
            twice = summed(across[c], across[:, d])
            turn[c, d] = (1.0 if c == d else 0.0) + sine * across[c, d] + rest * twice
    for c in range(3):
        p[c] = dot(turn[c], arm) + course.by[c]
        for d in range(3):
            R[c, d] = summed(turn[c], course.R[:, d])


@inlined
def _velocity(linear: Array, angular: Array, arm: Array, c: int) -> float:
    """Return component ``c`` of the velocity of a point at an arm (3,) from the centre of mass."""
    d, e = (c + 1) % 3, (c + 2) % 3
    velocity: float = linear[c] + combined(angular[d], arm[e], -angular[e], arm[d])
    return velocity


@inlined
def _fastest(world: Solids, R: Array, linear: Array, angular: Array) -> float:
    """Return the greatest speed of the object's corners."""
    most, arm = 0.0, np.empty(3)
    if angular[0] == 0.0 and angular[1] == 0.0 and angular[2] == 0.0:
        return float(np.sqrt(summed(linear, linear)))
    for j in range(len(world.body.ends)):
        for i in range(world.body.ends[j, 0], world.body.ends[j, 1]):
            square = 0.0
            for c in range(3):
                arm[c] = summed(world.body.rows[i], R[c])
            for c in range(3):
                square += _velocity(linear, angular, arm, c) ** 2
            most = max(most, square)
    return float(np.sqrt(most))


@compiled_as_written
def _kept(
    found: StateRoom, first: int, past: int, pose: tuple[Array, Array], twist: tuple[Array, Array],
    slow: float,
) -> int:  # fmt: skip
    """Leave out what separates, and write the others in the object frame; return the end."""
    R, p = pose
    kept, arm, slip, v = first, np.empty(3), np.empty(3), np.empty(3)
    for i in range(first, past):
        normal, leaving = found.at.normals[i].copy(), 0.0
        for c in range(3):
            arm[c] = found.at.points[i, c] - p[c]
        for c in range(3):
            v[c] = _velocity(twist[0], twist[1], arm, c)
            leaving += v[c] * normal[c]
        if leaving > slow:
            continue
        speed = 0.0
        for c in range(3):
            slip[c] = v[c] - leaving * normal[c]
            speed += slip[c] * slip[c]
        speed = np.sqrt(speed)
        for c in range(3):
            slip[c] = slip[c] / speed if speed > slow else 0.0
        found.at.surfaces[kept] = found.at.surfaces[i]
        for c in range(3):
            found.at.points[kept, c] = summed(arm, R[:, c])
            found.at.normals[kept, c] = summed(normal, R[:, c])
            found.slip[kept, c] = summed(slip, R[:, c])
        kept += 1
    return kept


@compiled_as_written
def _key(found: StateRoom, first: int, past: int, k: int, start: int, D: float) -> int:
    """Write the key of state ``k`` as ``contact_key`` has it; return what is past it."""
    unit, n, some = 10.0**DECIMALS, past - first, False
    for i in range(first, past):
        some |= found.at.surfaces[i] != 0
    wide = COLUMNS if some else COLUMNS - 1
    rows = found.keys[start : start + n * wide].reshape((n, wide))
    for i in range(n):
        for c in range(3):
            rows[i, c] = np.rint(found.at.points[first + i, c] / D * unit) / unit + 0.0
            rows[i, 3 + c] = np.rint(found.at.normals[first + i, c] * unit) / unit + 0.0
            rows[i, 6 + c] = np.rint(found.slip[first + i, c] * unit) / unit + 0.0
        if some:
            rows[i, 9] = found.at.surfaces[first + i]
        b = i
        while b > 0:  # the last column counts first
            c = wide - 1
            while c > 0 and rows[b, c] == rows[b - 1, c]:
                c -= 1
            if rows[b, c] >= rows[b - 1, c]:
                break
            for c in range(wide):
                rows[b, c], rows[b - 1, c] = rows[b - 1, c], rows[b, c]
            b -= 1
    end = start + n * wide
    for i in range(9):
        rounded = np.rint(found.rotations[k, i // 3, i % 3] * unit) / unit
        found.keys[end + i] = rounded + 0.0
    return end + 9
