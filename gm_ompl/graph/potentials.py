"""Potentials that no arc outruns: lower bounds on travel in a plane, compiled.

The object moves in a plane by translations and by rotations about points c of its outline. A
rotation by s takes a point o of the object |o - c| s along, and costs at least m(c) s, where m(c)
is the distance from c of the farthest fingertip. So with a direction y, and

    lambda = kappa min_c (m(c) - |y| |o - c|) >= 0,

no rotation gains more of y . (the way that o has gone) + lambda (the angle turned) than it costs.
No translation does, either, where none of them has a part along y longer than itself: those along
two axes allow |y| up to sqrt(2). kappa is what chords are shorter than their arcs.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import compiled, inlined, lean

SLOPES = np.array([0.0, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 2.0**0.5])
"""The lengths of y that are tried."""

SIDES = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0],
                  [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]])  # fmt: skip
"""Where a better o is looked for."""

POTENTIALS: Final = len(SLOPES) + 1
"""Of a set of fingertips; the last one has lambda = 0 and the largest |y|."""


class PlaneGoal(NamedTuple):
    """Where the object must end, in the plane.

    Attributes:
        low: (2,), least coordinates of the centre of mass.
        high: (2,), greatest.
        turned: whether the rotation is given.
        cos: of the angle by which the object must be turned from its own frame.
        sin: likewise.
        distance: how far the centre of mass may be from there.
        across: how far a point at arm 1 may be from there at right angles to the arm, as the object
            may be turned from there.
        along: likewise, along the arm.
    """

    low: Array
    high: Array
    turned: bool
    cos: float
    sin: float
    distance: float
    across: float
    along: float


STEPS: Final = 7
"""A point o is looked for in steps that are halved so many times."""


@lean
def set_up(near: Array, points: Array, outline: Array, kappa: float, found: Array) -> None:
    """Write the potentials (POTENTIALS, 4) of a set of fingertips: o, |y| and lambda of each.

    Args:
        near: (T, S, 2), over each piece of the outline each fingertip's distance, from below: a
            linear function, by its values at the ends.
        points: (M, 2), points o to begin with.
        outline: (S, 2, 2), the pieces' ends; between them a potential is least at one.
        kappa: of chords.
        found: written.
    """
    far, worst = 0.0, 0
    for s in range(len(outline)):
        far = max(far, abs(outline[s, 0, 0]), abs(outline[s, 0, 1]))
    x, z = 0.0, 0.0
    for k in range(POTENTIALS):
        # One after the other they differ little: each begins where the last one ended.
        best, worst = _least((x, z), k, near, outline, -np.inf, worst)
        for m in range(len(points) if k < 2 else 0):
            one, worst = _least((points[m, 0], points[m, 1]), k, near, outline, best, worst)
            if one > best:
                best, x, z = one, points[m, 0], points[m, 1]
        # What is looked for is concave in o, or, of the last one, has a single top as well.
        step, halved = far / 8.0, 0
        while halved < STEPS:
            moved = False
            for d in range(len(SIDES)):
                there = x + step * SIDES[d, 0], z + step * SIDES[d, 1]
                one, worst = _least(there, k, near, outline, best, worst)
                if one > best:
                    best, x, z, moved = one, there[0], there[1], True
            if not moved:
                step, halved = step / 2.0, halved + 1
        found[k, 0], found[k, 1] = x, z
        if k == len(SLOPES):
            found[k, 2], found[k, 3] = max(0.0, min(best, SLOPES[-1])), 0.0
        else:
            found[k, 2], found[k, 3] = SLOPES[k], kappa * best
            if best < 0.0:
                found[k, 2] = found[k, 3] = 0.0


@lean
def _least(
    o: tuple[float, float], k: int, near: Array, outline: Array, known: float, first: int
) -> tuple[float, int]:
    """Return lambda over kappa of potential ``k``, of the last one its |y|, and a piece.

    Where it is no more than ``known``, that is enough to say. The piece is where it is so small;
    the one to look at ``first`` may be.
    """
    least, at, S = np.inf, first, len(outline)
    for q in range(S):
        s = (first + q) % S
        one = _apart(o, outline[s, 0])
        two = _apart(o, outline[s, 1])
        most = -np.inf
        for t in range(len(near)):
            a, b = near[t, s, 0], near[t, s, 1]
            if k < len(SLOPES):
                most = max(most, min(a - SLOPES[k] * one, b - SLOPES[k] * two))
            else:
                most = max(most, min(_over(a, one), _over(b, two)))
        if most < least:
            least, at = most, s
        if least <= known:
            break
    return float(least), at


@inlined
def _apart(o: tuple[float, float], end: Array) -> float:
    x, z = o[0] - end[0], o[1] - end[1]
    return float(np.sqrt(x * x + z * z))


@inlined
def _over(length: float, arm: float) -> float:
    """Return length / arm, from below; where both are nothing, nothing."""
    return length / max(arm, 1e-300) if length > 0.0 else 0.0


@inlined
def _gain(x: float, z: float, slope: float) -> float:
    """Return the most y . (x, z), both >= 0, of |y| <= ``slope``, each of its parts <= 1."""
    more, less = max(x, z), min(x, z)
    length = np.sqrt(x * x + z * z)
    if slope * more <= length:
        return float(slope * length)
    return float(more + less * min(1.0, np.sqrt(max(slope * slope - 1.0, 0.0))))


@lean
def potential(found: Array, place: Array, target: PlaneGoal) -> float:
    """Return the best lower bound on what is left to travel.

    Args:
        found: (POTENTIALS, 4).
        place: (5,), where the centre of mass is, cosine and sine of how far the object is turned,
            and the angle that it must still turn at least [rad].
        target: where it must end.
    """
    x, z, cos, sin, left, best = place[0], place[1], place[2], place[3], place[4], 0.0
    for k in range(len(found)):
        o_x, o_z, slope, rate = found[k, 0], found[k, 1], found[k, 2], found[k, 3]
        if slope == 0.0 and rate == 0.0:
            continue
        here_x, here_z = x + cos * o_x - sin * o_z, z + sin * o_x + cos * o_z
        there_x, there_z, slack = 0.0, 0.0, target.distance
        if target.turned:
            there_x = target.cos * o_x - target.sin * o_z
            there_z = target.sin * o_x + target.cos * o_z
        else:
            slack += np.sqrt(o_x * o_x + o_z * o_z)
        # Turned a bit o ends elsewhere: in a box, so that no arc outruns what is left to it.
        off_x = abs(there_z) * target.across + abs(there_x) * target.along
        off_z = abs(there_x) * target.across + abs(there_z) * target.along
        there_x, there_z = there_x - here_x, there_z - here_z
        way_x = max(0.0, target.low[0] + there_x - off_x, -target.high[0] - there_x - off_x)
        way_z = max(0.0, target.low[1] + there_z - off_z, -target.high[1] - there_z - off_z)
        gain = _gain(way_x, way_z, slope) - slope * slack
        best = max(best, max(0.0, gain) + rate * left)
    return best


@compiled
def set_up_all(
    near: Array, points: Array, outline: Array, kappa: float, tips: Array, found: Array
) -> None:
    """Write the potentials (L, POTENTIALS, 4) of many sets of fingertips.

    Args:
        near: (L, T, S, 2), as for ``set_up``.
        points: (M, 2), likewise, for all sets.
        outline: (S, 2, 2).
        kappa: of chords.
        tips: (L, T, 2), the fingertips; they, what lies half way to them, and their middle are
            tried beside the points.
        found: written.
    """
    M, T = len(points), tips.shape[1]
    tried = np.empty((M + 2 * T + 1, 2))
    tried[:M] = points
    for i in range(len(near)):
        tried[M + 2 * T] = 0.0
        for t in range(T):
            tried[M + t], tried[M + T + t] = tips[i, t], 0.5 * tips[i, t]
            tried[M + 2 * T] += tips[i, t] / T
        set_up(near[i], tried, outline, kappa, found[i])
