"""Least costs of plans with given regrasps, by bounds on their lanes; compiled.

A plan's legs are lanes, each with one finger elsewhere than in the one before. Its cost is at least
that of the cheapest way along the first leg to a node where the others may hold the object, X_regr,
and on along the next leg: ``to_go``. ``follow`` returns that way, ``weakest`` what to doubt on it.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.holds.bounds import refresh
from gm_ompl.holds.rows import UNASKED, Tables, lower
from gm_ompl.mechanics.cuts import CutTables, state_bound

REGRASP: Final = -1
"""Stands for a regrasp where an arc is expected."""

ROUNDED: Final = 1e-12
"""Sums in another order are equal up to this, relatively."""


class LaneRoom(NamedTuple):
    """What is known of lanes, by their numbers.

    Attributes:
        sets: (lanes, n), the cell of each finger.
        z: (lanes, K, P), upper bounds on the margins.
        looked: (lanes, K, P), where more than the cuts was asked for.
        costs: (lanes, K), lower bounds on Eq. (9).
        d: (lanes, V), lower bounds on the cost to the goal inside the lane.
    """

    sets: IntArray
    z: Array
    looked: BoolArray
    costs: Array
    d: Array


class RestRoom(NamedTuple):
    """What is known of rests on all fingers but one, by their numbers.

    Attributes:
        z: (rests, V), upper bounds on the margin at each node.
        looked: (rests, V), as ``LaneRoom`` has it.
    """

    z: Array
    looked: BoolArray


@compiled
def renew_lane(lane: int, room: LaneRoom, tables: Tables, cuts: CutTables) -> None:
    """Write a lane's bounds anew; its margins only fall."""
    K, P = room.z.shape[1], room.z.shape[2]
    z = np.full((K, P), np.inf)
    refresh(room.sets[lane], tables, cuts, room.z[lane], z, room.costs[lane], room.d[lane])
    for k in range(K):
        for j in range(P):
            room.z[lane, k, j] = min(room.z[lane, k, j], z[k, j])


@compiled
def renew_rest(z: Array, cells: IntArray, states: IntArray, cuts: CutTables) -> None:
    """Lower the margins (V,) of a rest by the cuts of the nodes' states (V,)."""
    for c in range(len(z)):
        if 0 <= states[c] < len(cuts.counts):
            z[c] = min(z[c], state_bound(states[c], cells, cuts))


@compiled
def to_go(
    legs: IntArray, rests: IntArray, room: LaneRoom, resting: RestRoom, tables: Tables, D: Array,
    lift: Array,
) -> None:  # fmt: skip
    """Write lower bounds D (m, V) on the cost to the goal from each node of each leg.

    Args:
        legs: (m,), lanes.
        rests: (m - 1,), between each leg and the next.
        room: of the lanes.
        resting: of the rests.
        tables: by cells.
        D: output.
        lift: output (m - 1, V), likewise by a regrasp right there.
    """
    last = len(legs) - 1
    D[last] = room.d[legs[last]]
    for m in range(last - 1, -1, -1):
        for c in range(D.shape[1]):
            holds = resting.z[rests[m], c] >= tables.z_min
            for k in range(room.sets.shape[1]):
                holds = holds and tables.node_free[k, room.sets[legs[m + 1], k], c]
            lift[m, c] = tables.X_regr + D[m + 1, c] if holds else np.inf
        D[m] = lift[m]
        lower(D[m], room.costs[legs[m]], tables)


@compiled
def _hops(ends: BoolArray, costs: Array, d: Array, tables: Tables) -> IntArray:
    """Return how many arcs the cheapest ways (V,) take to where they may end; some cost nothing.

    Args:
        ends: (V,), where.
        costs: (K,), of the kinds of arcs.
        d: (V,), least costs to go.
        tables: the arcs.
    """
    hops, falling = np.where(ends, 0, len(d)), True
    while falling:
        falling = False
        for a in tables.order:
            tail, head = tables.tail[a], tables.head[a]
            through = costs[tables.kind[a]] + d[head]
            if hops[head] + 1 < hops[tail] and through <= d[tail] * (1.0 + ROUNDED):
                hops[tail], falling = hops[head] + 1, True
    return hops


@compiled
def follow(
    start: int, legs: IntArray, room: LaneRoom, tables: Tables, D: Array, lift: Array,
    steps: IntArray,
) -> int:  # fmt: skip
    """Write the cheapest way by ``to_go``'s D and lift from the start; return its number of steps.

    Args:
        start: the start node.
        legs: (m,), lanes.
        room: of the lanes.
        tables: by cells; the goal is the last lane's.
        D: (m, V), of finite D[0, start].
        lift: (m - 1, V).
        steps: output (.., 3): leg, arc or REGRASP, and the node where it begins.
    """
    c, count, last = start, 0, len(legs) - 1
    for m in range(len(legs)):
        ends = tables.goal & (D[m] <= 0.0)
        if m < last:
            ends = lift[m] <= D[m] * (1.0 + ROUNDED)
        costs = room.costs[legs[m]]
        hops = _hops(ends, costs, D[m], tables)
        while hops[c] > 0:
            best, arc = np.inf, REGRASP
            for a in range(len(tables.tail)):
                if tables.tail[a] == c and hops[tables.head[a]] < hops[c]:
                    through = costs[tables.kind[a]] + D[m, tables.head[a]]
                    if through < best:
                        best, arc = through, a
            steps[count, 0], steps[count, 1], steps[count, 2] = m, arc, c
            count, c = count + 1, tables.head[arc]
        if m < last:
            steps[count, 0], steps[count, 1], steps[count, 2] = m, REGRASP, c
            count += 1
    return count


@compiled
def weakest(
    steps: IntArray, legs: IntArray, rests: IntArray, room: LaneRoom, resting: RestRoom,
    tables: Tables,
) -> tuple[int, int]:  # fmt: skip
    """Return the step (and segment) whose margin may be least, of those not looked at.

    (-1, -1): all were. A step whose state nobody asked for comes first.
    """
    least, found, part = np.inf, -1, -1
    for i in range(len(steps) - 1, -1, -1):  # among equals from the far end
        m, arc = steps[i, 0], steps[i, 1]
        if arc == REGRASP:
            c = steps[i, 2]
            if not resting.looked[rests[m], c] and (resting.z[rests[m], c] < least or found < 0):
                least, found, part = resting.z[rests[m], c], i, 0
            continue
        k, lane = tables.kind[arc], legs[m]
        for j in range(tables.states.shape[1]):
            if tables.states[k, j] == UNASKED:
                return i, j
            if not room.looked[lane, k, j] and (room.z[lane, k, j] < least or found < 0):
                least, found, part = room.z[lane, k, j], i, j
    return found, part


@compiled
def least_margin(
    steps: IntArray, legs: IntArray, rests: IntArray, room: LaneRoom, resting: RestRoom,
    tables: Tables,
) -> float:  # fmt: skip
    """Return the least upper bound on the margins of a way."""
    least = np.inf
    for i in range(len(steps)):
        m, arc = steps[i, 0], steps[i, 1]
        if arc == REGRASP:
            least = min(least, resting.z[rests[m], steps[i, 2]])
        else:
            for j in range(tables.states.shape[1]):
                least = min(least, room.z[legs[m], tables.kind[arc], j])
    return least


@compiled
def note(lane: int, state: int, z: float, room: LaneRoom, tables: Tables) -> None:
    """Take a lane's margin at a contact state into account."""
    states = tables.states
    for k in range(states.shape[0]):
        for j in range(states.shape[1]):
            if states[k, j] == state:
                room.z[lane, k, j] = min(room.z[lane, k, j], z)
                room.looked[lane, k, j] = True
