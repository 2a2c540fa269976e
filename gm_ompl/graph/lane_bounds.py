"""Lower bounds on travel along lanes, compiled.

A lane is one set of placements on a lattice of one coordinate: a line of nodes 0..N joined by N
forward and N backward arcs. Arrays over a lane's arcs have shape (N,), over its segments (N, P);
those of backward arcs stand in the order of the forward ones.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.cuts import CutTables, state_bound

SHORTER = 1.0 - 1e-11
"""A hub counts as reached anew only by this factor: sums in another order are not progress."""

UNASKED = -1
"""Stands for a contact state that was not asked for yet: nothing bounds z there."""

Memo: TypeAlias = tuple[int, float, float, float]
"""What was computed last along a lane, as it repeats: a contact state and its bound on z, a margin
and its factor of Eq. (9)."""

NOTHING: Final[Memo] = (UNASKED, np.inf, np.nan, 1.0)


class LaneTables(NamedTuple):
    """What all lanes share, as compiled code reads it.

    Attributes:
        forward: (N, P), contact states of the forward arcs' segments.
        backward: (N, P), of the backward arcs', UNASKED where no search has come yet.
        lengths: (n, placements, N, P), chords |dq_finger i,j| of Eq. (9).
        free: (n, placements, N), whether object and fingertip are free along the arc.
        node_free: (n, placements, N + 1), likewise at the nodes.
        goal: (N + 1,), the goal nodes.
        wanted: (n,), the placements required at the goal, -1 for any.
        ahead: (n, placements, N + 1), lower bound on travel to the goal, this finger kept.
        least: (N + 1,), lower bound on travel to the goal with whatever placements.
        z_min: the threshold, over force_scale.
        X_stab: over force_scale.
        X_regr: cost of a regrasp.
    """

    forward: IntArray
    backward: IntArray
    lengths: Array
    free: BoolArray
    node_free: BoolArray
    goal: BoolArray
    wanted: IntArray
    ahead: Array
    least: Array
    z_min: float
    X_stab: float
    X_regr: float


@inlined
def arc_cost(
    rows: IntArray, i: int, states: IntArray, known: Array, way: int, at: int,
    lanes: LaneTables, cuts: CutTables, z: Array, factors: Array, memo: Memo,
) -> tuple[float, Memo]:  # fmt: skip
    """Return a lower bound on Eq. (9) for arc i of one way; +inf where it cannot hold.

    Args:
        rows: (n,), the lane's placements.
        i: the arc.
        states: (N, P), contact states of that way.
        known: (.., .., P), decided margins, +inf where undecided.
        way: of this arc in ``known`` and ``z``.
        at: its row there.
        lanes: the tables.
        cuts: the cuts.
        z: output (.., .., P), upper bounds on the margins: what is known, else the least of the
            state's cuts; left alone after the first that is below z_min.
        factors: (P,), room to work in.
        memo: what the arc before has left. It is returned with the cost.
    """
    before, bound, margin, factor = memo
    free, lengths, z_min, X_stab = lanes.free, lanes.lengths, lanes.z_min, lanes.X_stab
    P = states.shape[1]
    most, holds = 0.0, True
    for k in range(len(rows)):
        holds = holds and free[k, rows[k], i]
    for j in range(P):
        if not holds:
            break
        if states[i, j] != before:
            before = states[i, j]
            bound = np.inf if before == UNASKED else state_bound(before, rows, cuts)
        least = min(bound, known[way, at, j])
        holds = least >= z_min
        z[way, at, j] = least
        if least != margin:
            margin = least
            factor = 1.0 + X_stab / margin if X_stab > 0.0 else 1.0
        factors[j] = factor
    if holds:
        for k in range(len(rows)):
            travel = 0.0
            for j in range(P):
                travel += factors[j] * lengths[k, rows[k], i, j]
            most = max(most, travel)
    return most if holds else np.inf, (before, bound, margin, factor)


@inlined
def ends_at(rows: IntArray, c: int, lanes: LaneTables) -> bool:
    """Whether node c of a lane is a goal: wanted there, and free."""
    ends = lanes.goal[c]
    if ends:
        for k in range(len(rows)):
            fits = lanes.wanted[k] < 0 or lanes.wanted[k] == rows[k]
            ends = ends and fits and lanes.node_free[k, rows[k], c]
    return bool(ends)


@compiled
def refresh(
    rows: IntArray, lanes: LaneTables, cuts: CutTables, known: Array, z: Array, costs: Array,
    d: Array,
) -> None:  # fmt: skip
    """Write a lane's bounds anew.

    Args:
        rows: (n,), its placements.
        lanes: the tables.
        cuts: the cuts.
        known: (2, N, P), decided margins forward and backward, +inf where undecided.
        z: output (2, N, P), upper bounds on the margins of arcs that may hold.
        costs: output (2, N), lower bounds on Eq. (9).
        d: output (N + 1,), lower bounds on the cost to the goal inside the lane.
    """
    N, P = lanes.forward.shape
    factors = np.empty(P)
    memo = NOTHING
    for way in range(2):
        states = lanes.forward if way == 0 else lanes.backward
        for i in range(N):
            costs[way, i], memo = arc_cost(
                rows, i, states, known, way, i, lanes, cuts, z, factors, memo
            )
    for c in range(N + 1):
        d[c] = 0.0 if ends_at(rows, c, lanes) else np.inf
    for c in range(N - 1, -1, -1):
        d[c] = min(d[c], d[c + 1] + costs[0, c])
    for c in range(1, N + 1):
        d[c] = min(d[c], d[c - 1] + costs[1, c - 1])


@compiled
def best_target(
    c: int, g: float, costs: Array, d: Array, V: Array, G: Array, X_regr: float
) -> tuple[float, int, int]:
    """Return the cheapest way on from node c of a lane: (cost, node, slot lifted there).

    Args:
        c: the node.
        g: cost so far.
        costs: (2, N), costs of the arcs c -> c + 1 and c + 1 -> c.
        d: (N + 1,), cost of reaching the goal inside the lane.
        V: (n, N + 1), lower bound on the cost from the hub where slot k is lifted.
        G: (n, N + 1), least cost at which that hub was reached already.
        X_regr: cost of a regrasp.

    Returns:
        Slot -1 stands for the goal.
    """
    best, node, slot = d[c], c, -1
    N = costs.shape[1]
    for way in range(2):
        travel, at = 0.0, c
        while travel + X_regr <= best and travel < np.inf:
            if way == 0 or at != c:
                for k in range(V.shape[0]):
                    through = travel + X_regr
                    if through + V[k, at] < best and g + through < G[k, at] * SHORTER:
                        best, node, slot = through + V[k, at], at, k
            if (way == 0 and at == N) or (way == 1 and at == 0):
                break
            if way == 1:
                at -= 1
            travel += costs[way, at]
            if way == 0:
                at += 1
    return best, node, slot


@inlined
def hub_default(rows: IntArray, k: int, c: int, lanes: LaneTables) -> float:
    """Return the bound that geometry gives from the hub of slot k: those that stay travel on."""
    through = lanes.least[c]
    for i in range(len(rows)):
        if i != k:
            through = max(through, lanes.ahead[i, rows[i], c])
    return float(min(through, lanes.X_regr + lanes.least[c]))


@compiled
def hub_defaults(rows: IntArray, lanes: LaneTables, V: Array) -> None:
    """Write V (n, N + 1) as geometry alone bounds it."""
    for k in range(V.shape[0]):
        for c in range(V.shape[1]):
            V[k, c] = hub_default(rows, k, c, lanes)


@compiled
def lane_keys(
    sets: IntArray, ids: IntArray, V: Array, c: int, lanes: LaneTables, cuts: CutTables,
    keys: Array,
) -> None:  # fmt: skip
    """Write for many lanes a lower bound on the cost from node c to the goal.

    As ``best_target`` for hubs not yet reached; arcs are looked at only where the way leads.

    Args:
        sets: (L, n), the lanes' placements.
        ids: (L, n), rows of ``V``: the hub where each slot is lifted; (0, n) where geometry
            alone is to bound the cost from hubs.
        V: (hubs, N + 1), lower bounds on the cost from hubs.
        c: the node.
        lanes: the tables.
        cuts: the cuts.
        keys: output (L,).
    """
    N, P = lanes.forward.shape
    known, z, factors = np.full((1, 1, P), np.inf), np.empty((1, 1, P)), np.empty(P)
    shared = len(ids) > 0
    for m in range(sets.shape[0]):
        rows, best, memo = sets[m], np.inf, NOTHING
        for way in range(2):
            states = lanes.forward if way == 0 else lanes.backward
            travel, at = 0.0, c
            while travel < best:
                if way == 0 or at != c:
                    if ends_at(rows, at, lanes):
                        best = travel
                    onward = np.inf
                    for k in range(len(rows)):
                        if shared:
                            onward = min(onward, V[ids[m, k], at])
                        else:
                            onward = min(onward, hub_default(rows, k, at, lanes))
                    best = min(best, travel + lanes.X_regr + onward)
                if at == (N if way == 0 else 0):
                    break
                arc = at if way == 0 else at - 1
                cost, memo = arc_cost(rows, arc, states, known, 0, 0, lanes, cuts, z, factors, memo)
                travel += cost
                at += 1 if way == 0 else -1
        keys[m] = best


@compiled
def hub_rows(
    rows: IntArray, slot: int, choices: IntArray, which: IntArray, lanes: LaneTables,
    cuts: CutTables, table: Array,
) -> None:  # fmt: skip
    """Write for a hub the costs to the goal in the lanes that some of its choices lead to.

    Args:
        rows: (n,), the placements; that of ``slot`` is replaced by each choice.
        slot: the lifted finger.
        choices: its possible placements.
        which: the choices to treat, by their numbers.
        lanes: the tables.
        cuts: the cuts.
        table: output (choices, N + 1).
    """
    N, P = lanes.forward.shape
    known, z, factors = np.full((1, 1, P), np.inf), np.empty((1, 1, P)), np.empty(P)
    full = rows.copy()
    for index in which:
        full[slot] = choices[index]
        d, memo = table[index], NOTHING
        for c in range(N + 1):
            d[c] = 0.0 if ends_at(full, c, lanes) else np.inf
        for way in range(2):
            states = lanes.forward if way == 0 else lanes.backward
            for k in range(N):
                arc = N - 1 - k if way == 0 else k
                head, tail = (arc + 1, arc) if way == 0 else (arc, arc + 1)
                if d[head] < d[tail]:  # else no cost of the arc matters
                    cost, memo = arc_cost(
                        full, arc, states, known, 0, 0, lanes, cuts, z, factors, memo
                    )
                    d[tail] = min(d[tail], d[head] + cost)
