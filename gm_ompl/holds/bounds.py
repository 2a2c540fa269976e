"""What cuts and decisions say of sets of placements along arcs, compiled: bounds, no judgement.

A set may hold along fewer arcs than is said here, and costs at least as much.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.holds.tables import UNASKED, Tables
from gm_ompl.mechanics.cuts import CutTables, state_bound

Memo: TypeAlias = tuple[int, float, float, float]
"""What was computed last along a set's arcs, as it repeats: a contact state and its bound on z, a
margin and its factor of Eq. (9)."""

NOTHING: Final[Memo] = (UNASKED, np.inf, np.nan, 1.0)


@inlined
def arc_holds(
    rows: IntArray, a: int, known: Array, at: int, tables: Tables, cuts: CutTables, z: Array,
    before: int, bound: float,
) -> tuple[bool, int, float]:  # fmt: skip
    """Return whether a set may hold along an arc, and the last contact state with its bound.

    Args:
        rows: (n,), its placements.
        a: the arc.
        known: (.., P), decided margins, +inf where undecided.
        at: the arc's row in ``known`` and ``z``.
        tables: the tables.
        cuts: the cuts.
        z: output (.., P), upper bounds on the margins: what is known, else the least of the
            state's cuts; left alone after the first that is below z_min.
        before: the contact state asked for last.
        bound: its bound on z.
    """
    holds, row = True, tables.like[a]
    for k in range(len(rows)):
        holds = holds and tables.free[k, rows[k], row]
    for j in range(tables.states.shape[1]):
        if not holds:
            break
        state = tables.states[a, j]
        if state != before:
            before, bound = state, np.inf
            if 0 <= state < len(cuts.counts):
                bound = state_bound(state, rows, cuts)
        z[at, j] = min(bound, known[at, j])
        holds = z[at, j] >= tables.z_min
    return holds, before, bound


@inlined
def arc_cost(
    rows: IntArray, a: int, known: Array, at: int, tables: Tables, cuts: CutTables, z: Array,
    factors: Array, memo: Memo,
) -> tuple[float, Memo]:  # fmt: skip
    """Return a lower bound on Eq. (9) for an arc; +inf where it cannot hold.

    Arguments as for ``arc_holds``; ``factors`` (P,) is room to work in, ``memo`` what the arc
    before has left. It is returned with the cost.
    """
    before, bound, margin, factor = memo
    holds, before, bound = arc_holds(rows, a, known, at, tables, cuts, z, before, bound)
    P, most, row = tables.states.shape[1], 0.0, tables.like[a]
    if holds:
        for j in range(P):
            if z[at, j] != margin:
                margin = z[at, j]
                factor = 1.0 + tables.X_stab / margin if tables.X_stab > 0.0 else 1.0
            factors[j] = factor
        for k in range(len(rows)):
            travel = 0.0
            for j in range(P):
                travel += factors[j] * tables.lengths[k, rows[k], row, j]
            most = max(most, travel)
    return most if holds else np.inf, (before, bound, margin, factor)


@inlined
def ends_at(rows: IntArray, c: int, tables: Tables) -> bool:
    """Whether node c is a goal for a set: wanted there, and free."""
    ends = tables.goal[c]
    if ends:
        for k in range(len(rows)):
            fits = tables.wanted[k] < 0 or tables.wanted[k] == rows[k]
            ends = ends and fits and tables.node_free[k, rows[k], c]
    return bool(ends)


@inlined
def relax(d: Array, costs: Array, tables: Tables) -> None:
    """Lower d (V,) to the least cost to go, by arcs of these costs (A,)."""
    falling = True
    while falling:
        falling = False
        for a in tables.order:
            through = d[tables.head[a]] + costs[a]
            if through < d[tables.tail[a]]:
                d[tables.tail[a]] = through
                falling = not tables.one_pass


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
        known: (A, P), decided margins, +inf where undecided.
        z: output (A, P), upper bounds on the margins of arcs that may hold.
        costs: output (A,), lower bounds on Eq. (9).
        d: output (V,), lower bounds on the cost to the goal without regrasping.
    """
    factors, memo = np.empty(tables.states.shape[1]), NOTHING
    for a in range(len(costs)):
        costs[a], memo = arc_cost(rows, a, known, a, tables, cuts, z, factors, memo)
    for c in range(len(d)):
        d[c] = 0.0 if ends_at(rows, c, tables) else np.inf
    relax(d, costs, tables)


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
        known: (K, A, P), decided margins.
        costs: output (L, A), see ``refresh``.
        d: output (L, V), see ``refresh``.
    """
    z = np.empty(tables.states.shape)
    for i in range(sets.shape[0]):
        refresh(sets[i], tables, cuts, known[places[i]], z, costs[i], d[i])


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
    P = tables.states.shape[1]
    known, z = np.full((1, P), np.inf), np.empty((1, P))
    step = 1 if last >= first else -1
    for m in range(sets.shape[0]):
        k, before, bound = first, UNASKED, np.inf
        while k != reach[m]:
            arc = k if step > 0 else k - 1
            holds, before, bound = arc_holds(sets[m], arc, known, 0, tables, cuts, z, before, bound)
            if not holds:
                break
            k += step
        reach[m] = k
