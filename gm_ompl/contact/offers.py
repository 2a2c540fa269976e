"""What the contact lattice offers at a pose: screws of the object, before they are cut short.

Compiled; contact lines as ``lines`` has them, equal in every bit.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled_as_written, inlined
from gm_ompl.contact.expansion import Offered, Room, touches
from gm_ompl.contact.lines import SAME
from gm_ompl.geometry.flat import basis, outline, summed
from gm_ompl.geometry.packed import placed
from gm_ompl.geometry.vectors import dot
from gm_ompl.motion.free import ContactSteps

ON_GRID: Final = 1e-6
"""A coordinate is on the grid up to this many steps."""

NEAR: Final = 1e-6
"""Lines as near to each other as this, relative to D, are one."""

LEANING: Final = 1e-5
"""What a face that is at right angles to an axis, up to rounding, may reach farther, over D."""


class Rules(NamedTuple):
    """What a contact lattice offers.

    Attributes:
        axes: (3, 3), the world's.
        start: (3,), where the grid of translations is counted from, world frame.
        listed: (3,), whether a world axis is listed for translations.
        rotate: (k, 3), unit directions about which the object may turn.
        turns_any: whether it may turn about any.
        turning: (3,), whether it may turn about lines along a world axis.
        step: of translations.
        angle: of rotations.
        near: lines so near to each other are one.
        touching: the contact tolerance (a length).
    """

    axes: Array
    start: Array
    listed: BoolArray
    rotate: Array
    turns_any: bool
    turning: BoolArray
    step: float
    angle: float
    near: float
    touching: float


def rules(steps: ContactSteps, start: Array, diagonal: float, touching: float) -> Rules:
    """Return what a lattice offers.

    Args:
        steps: of the lattice.
        start: (3,), where the grid of translations is counted from, world frame.
        diagonal: D.
        touching: the contact tolerance (a length).
    """
    any_, rotate = steps.rotate is None, np.zeros((0, 3))
    if steps.rotate is not None:
        rotate = steps.rotate.copy()
    listed = np.array([k in steps.translate for k in range(3)])
    sizes = steps.translation, steps.rotation, NEAR * diagonal, touching
    found = Rules(
        np.eye(3), start.copy(), listed, rotate, any_, np.zeros(3, dtype=np.bool_), *sizes
    )
    for k in range(3):
        found.turning[k] = may_turn(found.axes[k], found)
    return found


class Stand(NamedTuple):
    """How the object stands at a pose, seen from the centre of mass.

    Attributes:
        exempt: (3,), the listed world axes along which contact fixes it.
        lines: (n, 2, 3), points and unit directions of lines about which it may turn where
            rotations begin.
        slopes: (s, 3), unit directions of contact lines that the listed axes do not offer.
    """

    exempt: BoolArray
    lines: Array
    slopes: Array


@compiled_as_written
def along_each_other(a: Array, b: Array) -> bool:
    """Whether two unit vectors (3,) are ``parallel``."""
    along, off = summed(a, b), np.empty(3)
    for c in range(3):
        off[c] = a[c] - along * b[c]
    return bool(summed(off, off) <= SAME * SAME)


@compiled_as_written
def may_turn(direction: Array, rules: Rules) -> bool:
    """Whether the object may turn about lines of this direction (3,)."""
    for axis in rules.rotate:
        if along_each_other(direction, axis):
            return True
    return rules.turns_any


@compiled_as_written
def stand(p: Array, points: Array, normals: Array, rules: Rules) -> Stand:
    """Return how the object stands with its centre of mass at a position (3,).

    Args:
        p: the position.
        points: (m, 3), the corners of contact patches, world frame.
        normals: (m, 3), unit, into the object.
        rules: what is offered.
    """
    m, count, sloping, axes = len(points), 0, 0, rules.axes
    lines, slopes = np.empty((4 * m + 3, 2, 3)), np.empty((m, 3))
    group, exempt, way = np.empty(m, dtype=np.int64), np.zeros(3, dtype=np.bool_), np.empty(3)
    for i in range(m):
        group[i] = -1
    for k in range(3 if m == 0 else 0):
        if rules.turning[k]:
            count = _add(lines, count, p, axes[k], p, rules.near)
    for lead in range(m):
        if group[lead] >= 0:
            continue
        rim = _rim(lead, points, normals, group, rules.touching)
        for k in range(3):
            exempt[k] |= rules.listed[k] and along_each_other(normals[lead], axes[k])
            if len(rim) == 1 and rules.turning[k]:
                count = _add(lines, count, points[rim[0]], axes[k], p, rules.near)
        for i in range(0 if len(rim) == 1 else 1 if len(rim) == 2 else len(rim)):
            a, b = points[rim[i]], points[rim[(i + 1) % len(rim)]]
            for c in range(3):
                way[c] = b[c] - a[c]
            length = np.sqrt(summed(way, way))
            for c in range(3):
                way[c] /= length
            if may_turn(way, rules):
                count = _add(lines, count, a, way, p, rules.near)
            if _slopes(way, normals[lead], axes, slopes[:sloping], rules):
                for c in range(3):
                    slopes[sloping, c] = way[c]
                sloping += 1
    for lead in range(m):
        if group[lead] == lead and may_turn(normals[lead], rules):
            count = _add(lines, count, p, normals[lead], p, rules.near)
    return Stand(exempt, lines[:count], slopes[:sloping])


@inlined
def _rim(lead: int, points: Array, normals: Array, group: IntArray, tolerance: float) -> IntArray:
    """Return the corners' numbers of the hull of a contact's group, which is marked."""
    n, count, height = len(points), 0, dot(points[lead], normals[lead])
    which, flat, chart = np.empty(n, dtype=np.int64), np.empty((n, 2)), basis(normals[lead])
    for i in range(lead, n):
        alike = group[i] < 0 and abs(dot(points[i], normals[lead]) - height) <= tolerance
        for c in range(3):
            alike &= abs(normals[i, c] - normals[lead, c]) <= SAME
        if alike:
            which[count], group[i] = i, lead
            for c in range(2):
                flat[count, c] = summed(points[i], chart[c])
            count += 1
    corners = outline(flat[:count], tolerance)
    for i in range(len(corners)):
        corners[i] = which[corners[i]]
    return corners


@compiled_as_written
def _add(lines: Array, count: int, point: Array, way: Array, p: Array, near: float) -> int:
    """Add a line seen from a position (3,) that is none of the lines so far; return how many."""
    for c in range(3):
        lines[count, 0, c], lines[count, 1, c] = point[c] - p[c], way[c]
    return count if find(lines[:count], lines[count, 0], way, near) >= 0 else count + 1


@compiled_as_written
def find(lines: Array, point: Array, way: Array, near: float) -> int:
    """Return the number of the first of lines (n, 2, 3) that is ``same`` as another; -1: none."""
    arm = np.empty(3)
    for i in range(len(lines)):
        for c in range(3):
            arm[c] = point[c] - lines[i, 0, c]
        along = summed(arm, lines[i, 1])
        for c in range(3):
            arm[c] -= along * lines[i, 1, c]
        if along_each_other(way, lines[i, 1]) and summed(arm, arm) <= near * near:
            return i
    return -1


@inlined
def _slopes(way: Array, normal: Array, axes: Array, found: Array, rules: Rules) -> bool:
    """Whether the listed axes do not offer a direction (3,) in a contact plane, nor one found."""
    for other in found:
        if along_each_other(way, other):
            return False
    rest, level = 0.0, False
    for k in range(3):
        slides = rules.listed[k] and abs(normal[k]) <= SAME
        level |= slides
        rest += 0.0 if slides else way[k] * way[k]
        if rules.listed[k] and along_each_other(way, axes[k]):
            return False
    return not (level and rest <= SAME * SAME)


@compiled_as_written
def begins(exempt: BoolArray, p: Array, rules: Rules) -> bool:
    """Whether rotations may begin: the listed coordinates that are free are on the grid."""
    for k in range(3):
        if rules.listed[k] and not exempt[k]:
            count = (p[k] - rules.start[k]) / rules.step
            if abs(count - np.rint(count)) > ON_GRID:
                return False
    return True


@compiled_as_written
def may_begin(R: Array, p: Array, room: Room, rules: Rules, D: float) -> int:
    """Say whether rotations may begin at a pose: 1, 0; -1: how the object stands there says it.

    Across a normal along an axis a plane parts pieces that touch, and both reach up to it.
    """
    meets = np.zeros(3, dtype=np.bool_)
    if begins(meets, p, rules):
        return 1
    here, near = placed(room.body, R, p), room.lengths.touching + LEANING * D
    for k in range(len(here.low)):
        meets[2] |= room.floor and here.low[k, 2] <= near
        for j in range(len(room.obstacles.low)):
            for c in range(3):
                meets[c] |= abs(here.low[k, c] - room.obstacles.high[j, c]) <= near
                meets[c] |= abs(room.obstacles.low[j, c] - here.high[k, c]) <= near
    return -1 if begins(meets, p, rules) and touches(R, p, room) else 0


@compiled_as_written
def offered(at: Stand, p: Array, rules: Rules, under_way: Array) -> Offered:
    """Return the motions that are offered.

    Args:
        at: how the object stands.
        p: (3,), where its centre of mass is.
        rules: what is offered.
        under_way: (k, 2, 3), the line of a rotation that may go on, seen from there, if any.
    """
    lines = at.lines if begins(at.exempt, p, rules) else under_way
    slopes, m = len(at.slopes), 0
    room = 6 + 2 * slopes + 2 * len(lines)
    turns, by, axes = np.zeros(room, dtype=np.bool_), np.zeros((room, 3)), np.zeros((room, 3))
    angles, steps = np.zeros(room), np.ones(room)
    for k in range(3):
        if rules.listed[k]:
            count = (p[k] - rules.start[k]) / rules.step
            for target in (np.floor(count + ON_GRID) + 1.0, np.ceil(count - ON_GRID) - 1.0):
                by[m, k] = rules.start[k] + target * rules.step - p[k]
                steps[m] = min(1.0, abs(by[m, k]) / rules.step)
                m += 1
    for i in range(2 * slopes):
        for c in range(3):
            by[m, c] = (1.0 if i % 2 == 0 else -1.0) * rules.step * at.slopes[i // 2, c]
        m += 1
    for i in range(m):
        axes[i, 2] = 1.0
    for i in range(2 * len(lines)):
        turns[m], angles[m] = True, rules.angle if i % 2 == 0 else -rules.angle
        for c in range(3):
            by[m, c], axes[m, c] = lines[i // 2, 0, c], lines[i // 2, 1, c]
        m += 1
    return Offered(turns[:m], by[:m], axes[:m], angles[:m], steps[:m])
