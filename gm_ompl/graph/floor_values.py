"""What rotations cost beyond the way that they go along the floor: compiled.

A point o of the object that is an average of its fingertips goes no farther along an arc than the
farthest fingertip. So with a horizontal direction y, |y| <= 1, no arc costs less than it takes o
along y. What rotations cost beyond that, summed up along the cheapest sequence of them that leads
to the goal's attitude, comes on top of how far o must go along y.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import inlined, lean
from gm_ompl.graph.kept_tables import FAILED, Prices

SLIP = 3e-6
"""What attitudes that count as one may differ by, over D."""

LESS = 1e-12
"""A sum lower by less than this is no lower."""


class FloorArcs(NamedTuple):
    """The arcs of a ``FloorGraph``, as compiled code reads them.

    Attributes:
        tails: (K,).
        heads: (K,).
        lines: (K, 2, 3), as ``KeptArcs`` has them.
        chords: (K, parts), likewise.
        states: (K, parts), numbers of contact states; -1 behind the last.
        free: (K, F, P), whether a fingertip is free all along.
        shifts: (K, 2, 4), take a point (x, y, z, 1) of the object to how far it goes on the floor.
        slip: taken off each cost, a length.
    """

    tails: IntArray
    heads: IntArray
    lines: Array
    chords: Array
    states: IntArray
    free: BoolArray
    shifts: Array
    slip: float


class FloorSets(NamedTuple):
    """Sets of placements that are asked about.

    Attributes:
        rows: (L, n), placements.
        shapes: (n,), of the fingers.
        tips: (F, P, 3), fingertips of each shape.
        margins: (L, C), z by contact state; +inf where it is not known, else FAILED below z_min.
        points: (L, 3), o of each.
        ways: (L, 2), y of each.
    """

    rows: IntArray
    shapes: IntArray
    tips: Array
    margins: Array
    points: Array
    ways: Array


@lean
def evaluate(
    sets: FloorSets, arcs: FloorArcs, prices: Prices, ends: Array, costs: Array, values: Array,
    via: IntArray,
) -> None:  # fmt: skip
    """Write what is left to pay from each attitude, and by which arc.

    Args:
        sets: L of them.
        arcs: best in order of how far their heads are from the goal.
        prices: of Eq. (9).
        ends: (A, 3, 3), the rotations of attitudes that have arrived; NaN of others.
        costs: (K,), room.
        values: (L, A), written: y . R o at the end, and all costs beyond y . shift until there.
        via: (L, A), written: the next arc; -1 at the end, and where none leads there.
    """
    for one in range(len(sets.rows)):
        o, y = sets.points[one], sets.ways[one]
        for k in range(len(costs)):
            gone = 0.0
            for c in range(2):
                gone += y[c] * (_along(arcs.shifts[k, c], o) + arcs.shifts[k, c, 3])
            costs[k] = max(0.0, _price(one, k, sets, arcs, prices) - gone - arcs.slip)
        for a in range(len(ends)):
            via[one, a], values[one, a] = -1, np.inf
            if not np.isnan(ends[a, 0, 0]):
                values[one, a] = y[0] * _along(ends[a, 0], o) + y[1] * _along(ends[a, 1], o)
        falls = True
        while falls:
            falls = False
            for k in range(len(costs)):
                whole, tail = costs[k] + values[one, arcs.heads[k]], arcs.tails[k]
                if whole < values[one, tail] - LESS:
                    values[one, tail], via[one, tail], falls = whole, k, True


@inlined
def _along(row: Array, o: Array) -> float:
    return float(row[0] * o[0] + row[1] * o[1] + row[2] * o[2])


@inlined
def _price(one: int, k: int, sets: FloorSets, arcs: FloorArcs, prices: Prices) -> float:
    """Return Eq. (9) along arc ``k``, by travel alone where z is not known; +inf: it is barred."""
    travel, arm = 0.0, 0.0
    point, way = arcs.lines[k, 0], arcs.lines[k, 1]
    for i in range(sets.rows.shape[1]):
        row = sets.rows[one, i]
        if not arcs.free[k, sets.shapes[i], row]:
            return np.inf
        tip, along, square = sets.tips[sets.shapes[i], row], 0.0, 0.0
        for c in range(3):
            along += (tip[c] - point[c]) * way[c]
        for c in range(3):
            square += (tip[c] - point[c] - along * way[c]) ** 2
        arm = max(arm, square)
    for j in range(arcs.states.shape[1]):
        if arcs.states[k, j] >= 0:
            z = sets.margins[one, arcs.states[k, j]]
            if z == FAILED:
                return np.inf
            travel += (1.0 + prices.X_stab / max(z, prices.z_floor)) * arcs.chords[k, j]
    return float(travel * np.sqrt(arm))


@lean
def undecided(via: IntArray, start: int, margins: Array, arcs: FloorArcs, found: IntArray) -> int:
    """Write the contact states without known z on the way from an attitude; return how many."""
    count, at = 0, start
    while via[at] >= 0:
        for j in range(arcs.states.shape[1]):
            state = arcs.states[via[at], j]
            new = state >= 0 and margins[state] == np.inf and count < len(found)
            for i in range(count):
                new &= found[i] != state
            if new:
                found[count] = state
                count += 1
        at = arcs.heads[via[at]]
    return count
