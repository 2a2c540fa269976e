"""What cuts and decisions say of sets of placements along arcs, compiled: bounds, no judgement.

A set may hold along fewer arcs than is said here, and costs at least as much.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.holds.rows import UNASKED, Tables, lower, lower_once
from gm_ompl.mechanics.cuts import CutTables, state_bound

Memo: TypeAlias = tuple[int, float, float, float]
"""What was computed last along a set's arcs, as it repeats: a contact state and its bound on z, a
margin and its factor of Eq. (9)."""

NOTHING: Final[Memo] = (UNASKED, np.inf, np.nan, 1.0)


class Arcs(NamedTuple):
    """What costs of arcs need of ``Tables``.

    ``weigh`` says whether lengths count: else an arc that may hold costs nothing.
    """

    like: IntArray
    free: BoolArray
    states: IntArray
    lengths: Array
    z_min: float
    z_floor: float
    X_stab: float
    weigh: bool


class Ends(NamedTuple):
    """What tells goal nodes, likewise."""

    goal: BoolArray
    wanted: IntArray
    node_free: BoolArray


@inlined
def arcs_of(tables: Tables, weigh: bool) -> Arcs:
    """Return what costs of arcs need."""
    return Arcs(
        tables.like, tables.free, tables.states, tables.lengths, tables.z_min, tables.z_floor,
        tables.X_stab, weigh,
    )  # fmt: skip


@inlined
def ends_of(tables: Tables) -> Ends:
    """Return what tells goal nodes."""
    return Ends(tables.goal, tables.wanted, tables.node_free)


@inlined
def arc_cost(
    rows: IntArray, kind: int, known: Array, arcs: Arcs, cuts: CutTables, z: Array, memo: Memo
) -> tuple[float, Memo]:
    """Return a lower bound on Eq. (9) for arcs of a kind; +inf where they cannot hold.

    Args:
        rows: (n,), a set's placements.
        kind: of the arcs.
        known: (P,), the kind's decided margins, +inf where undecided.
        arcs: of the tables.
        cuts: the cuts.
        z: output (P,), upper bounds on the margins: what is known, else the least of the
            state's cuts; left alone after the first that is below z_min.
        memo: what the arc before has left. It is returned with the cost.
    """
    like, free, states, lengths, z_min, z_floor, X_stab, weigh = arcs
    before, bound, margin, factor = memo
    P, row = states.shape[1], like[kind]
    most, holds = 0.0, True
    for k in range(len(rows)):
        holds = holds and free[k, rows[k], row]
    for j in range(P):
        if not holds:
            break
        if states[kind, j] != before:
            before, bound = states[kind, j], np.inf
            if 0 <= before < len(cuts.counts):
                bound = state_bound(before, rows, cuts)
        least = min(bound, known[j])
        holds = least >= z_min
        z[j] = least
    if holds and weigh:
        for k in range(len(rows)):
            travel = 0.0
            for j in range(P):
                if z[j] != margin:
                    margin = z[j]
                    factor = 1.0 + X_stab / max(margin, z_floor) if X_stab > 0.0 else 1.0
                travel += factor * lengths[k, rows[k], row, j]
            most = max(most, travel)
    return most if holds else np.inf, (before, bound, margin, factor)


@inlined
def ends_at(rows: IntArray, c: int, ends: Ends) -> bool:
    """Whether node c is a goal for a set: wanted there, and free."""
    goal, wanted, node_free = ends
    arrived = goal[c]
    if arrived:
        for k in range(len(rows)):
            fits = wanted[k] < 0 or wanted[k] == rows[k]
            arrived = arrived and fits and node_free[k, rows[k], c]
    return bool(arrived)


@compiled
def refresh(
    rows: IntArray, tables: Tables, cuts: CutTables, known: Array, z: Array, costs: Array,
    d: Array,
) -> None:  # fmt: skip
    """Write a set's bounds anew.

    Args:
        rows: (n,), its placements.
        tables: the tables.
        cuts: the cuts.
        known: (K, P), decided margins, +inf where undecided.
        z: output (K, P), upper bounds on the margins of arcs that may hold.
        costs: output (K,), lower bounds on Eq. (9).
        d: output (V,), lower bounds on the cost to the goal without regrasping.
    """
    _bound(rows, tables, cuts, known, z, costs, d)
    if not tables.one_pass:
        lower(d, costs, tables)


@lean
def _bound(
    rows: IntArray, tables: Tables, cuts: CutTables, known: Array, z: Array, costs: Array,
    d: Array,
) -> None:  # fmt: skip
    """Write a set's bounds along arcs, and to the goal where one pass is enough; else the ends."""
    arcs, ends, memo = arcs_of(tables, True), ends_of(tables), NOTHING
    for k in range(len(costs)):
        costs[k], memo = arc_cost(rows, k, known[k], arcs, cuts, z[k], memo)
    for c in range(len(d)):
        d[c] = 0.0 if ends_at(rows, c, ends) else np.inf
    if tables.one_pass:
        lower_once(d, costs, tables)


@inlined
def unknown(tables: Tables) -> tuple[Array, Array]:
    """Return the margins (P,) of a kind of which none is decided, and room for bounds on them."""
    P = tables.states.shape[1]
    return np.full(P, np.inf), np.empty(P)


@compiled
def refresh_many(
    sets: IntArray, tables: Tables, cuts: CutTables, places: IntArray, known: Array,
    costs: Array, d: Array,
) -> None:  # fmt: skip
    """Write the bounds of many sets.

    Args:
        sets: (L, n), the sets.
        tables: the tables.
        cuts: the cuts.
        places: (L,), where a set's decided margins stand in ``known``; 0 is all undecided.
        known: (.., K, P), decided margins.
        costs: output (L, K), see ``refresh``.
        d: output (L, V), see ``refresh``.
    """
    z = np.empty(tables.states.shape)
    for i in range(sets.shape[0]):
        _bound(sets[i], tables, cuts, known[places[i]], z, costs[i], d[i])
        if not tables.one_pass:
            lower(d[i], costs[i], tables)


@compiled
def reaches(
    sets: IntArray, first: int, last: int, tables: Tables, cuts: CutTables, reach: IntArray
) -> None:
    """Bring ``reach`` (L,) nearer to ``first``: how far each set (L, n) may come at most.

    Args:
        sets: the sets.
        first: a vertex of a route, whose arc k leads from vertex k to k + 1.
        last: the vertex to come to; a smaller one where the motion ends at ``first``.
        tables: the route's.
        cuts: the cuts.
        reach: what is known so far, between the two.
    """
    known, z = unknown(tables)
    for m in range(sets.shape[0]):
        reach[m] = _reach(sets[m], (first, reach[m]), last >= first, tables, cuts, (known, z))


@lean
def _reach(
    rows: IntArray, ends: tuple[int, int], onward: bool, tables: Tables, cuts: CutTables,
    room: tuple[Array, Array],
) -> int:  # fmt: skip
    """Return how far one set may come, between two vertices."""
    (k, last), (known, z), memo = ends, room, NOTHING
    arcs, step = arcs_of(tables, False), 1 if onward else -1
    while k != last:
        kind = tables.kind[k if onward else k - 1]
        cost, memo = arc_cost(rows, kind, known, arcs, cuts, z, memo)
        if cost == np.inf:
            break
        k += step
    return int(k)
