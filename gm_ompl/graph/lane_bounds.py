"""Where to go from a node of a lane, and what that costs at least; compiled."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.holds.bounds import NOTHING, arc_cost, arcs_of, ends_at, ends_of, unknown
from gm_ompl.holds.rows import Tables
from gm_ompl.mechanics.cuts import CutTables

SHORTER = 1.0 - 1e-11
"""A hub counts as reached anew only by this factor: sums in another order are not progress."""


@lean
def spread(c: int, costs: Array, tables: Tables, travel: Array, via: IntArray) -> None:
    """Write the least cost (V,) from node c, kinds costing this (K,), and the last arc (V,)."""
    order, tail, head, again = tables.order, tables.tail, tables.head, not tables.one_pass
    travel[:], via[:] = np.inf, -1
    kind, travel[c], falling = tables.kind, 0.0, True
    while falling:
        falling = False
        for k in range(len(order) - 1, -1, -1):
            a = order[k]
            onward, there = travel[tail[a]] + costs[kind[a]], head[a]
            if onward < travel[there]:
                travel[there], via[there], falling = onward, a, again


@inlined
def better_hub(
    at: int, through: float, g: float, V: Array, G: Array, way: tuple[float, int, int]
) -> tuple[float, int, int]:
    """Return the cheapest way on: the one known so far, or through a hub entered at node ``at``.

    ``through`` is the cost to there and of the regrasp.
    """
    best, node, slot = way
    for k in range(V.shape[0]):
        if through + V[k, at] < best and g + through < G[k, at] * SHORTER:
            best, node, slot = through + V[k, at], at, k
    return best, node, slot


@lean
def best_target(
    c: int, g: float, costs: Array, d: Array, hubs: tuple[Array, Array], tables: Tables,
    travel: Array,
) -> tuple[float, int, int]:  # fmt: skip
    """Return the cheapest way on from node c of a lane: (cost, node, slot lifted there).

    Args:
        c: the node.
        g: cost so far.
        costs: (K,), costs of the kinds of arcs.
        d: (V,), cost of reaching the goal inside the lane.
        hubs: (n, V) each, of the hub where slot k is lifted: a lower bound on the cost from
            there, and the least cost at which it was reached already.
        tables: the tables.
        travel: (V,), room to work in.

    Returns:
        Slot -1 stands for the goal.
    """
    order, tail, head, again = tables.order, tables.tail, tables.head, not tables.one_pass
    (V, G), X_regr, best, node, slot = hubs, tables.X_regr, d[c], c, -1
    if X_regr <= best:
        best, node, slot = better_hub(c, X_regr, g, V, G, (best, node, slot))
    travel[:] = np.inf
    kind, travel[c], falling = tables.kind, 0.0, True
    while falling:
        falling = False
        for k in range(len(order) - 1, -1, -1):
            a = order[k]
            onward, there = travel[tail[a]] + costs[kind[a]], head[a]
            if onward < travel[there] and onward + X_regr <= best:
                travel[there], falling = onward, again
                way = better_hub(there, onward + X_regr, g, V, G, (best, node, slot))
                best, node, slot = way
    return best, node, slot


@inlined
def hub_default(rows: IntArray, k: int, c: int, tables: Tables) -> float:
    """Return the bound that geometry gives from the hub of slot k: those that stay travel on."""
    least, ahead = tables.least, tables.ahead
    through = least[c]
    for i in range(len(rows)):
        if i != k:
            through = max(through, ahead[i, rows[i], c])
    return float(min(through, tables.X_regr + least[c]))


@lean
def hub_defaults(rows: IntArray, tables: Tables, V: Array) -> None:
    """Write V (n, V) as geometry alone bounds it."""
    for k in range(V.shape[0]):
        for c in range(V.shape[1]):
            V[k, c] = hub_default(rows, k, c, tables)


@compiled
def lane_keys(
    sets: IntArray, ids: IntArray, V: Array, c: int, tables: Tables, cuts: CutTables,
    keys: Array,
) -> None:  # fmt: skip
    """Write for many lanes a lower bound on the cost from node c to the goal.

    As ``best_target`` for hubs not yet reached; arcs are looked at only where the way leads.

    Args:
        sets: (L, n), the lanes' placements.
        ids: (L, n), rows of ``V``: the hub where each slot is lifted; (1, n) where geometry
            alone is to bound the cost from hubs.
        V: (hubs, V), lower bounds on the cost from hubs; (0, V) where geometry is to.
        c: the node.
        tables: the tables.
        cuts: the cuts.
        keys: output (L,).
    """
    known, z = unknown(tables)
    travel, costs = np.empty(len(tables.goal)), np.empty(tables.states.shape[0])
    room = known, z, travel, costs
    _lane_keys((sets, ids), V, c, tables, cuts, room, keys)


@lean
def _lane_keys(
    lanes: tuple[IntArray, IntArray], V: Array, c: int, tables: Tables, cuts: CutTables,
    room: tuple[Array, Array, Array, Array], keys: Array,
) -> None:  # fmt: skip
    sets, ids = lanes
    for m in range(len(sets)):
        one = sets[m], ids[m if len(V) > 0 else 0]
        keys[m] = _lane_key(one, V, c, tables, cuts, room)


@inlined
def _lane_key(
    one: tuple[IntArray, IntArray], V: Array, c: int, tables: Tables, cuts: CutTables,
    room: tuple[Array, Array, Array, Array],
) -> float:  # fmt: skip
    """Return the bound for one lane, given by its placements and the rows of its hubs."""
    tail, head, order, kind = tables.tail, tables.head, tables.order, tables.kind
    (rows, hubs), (known, z, travel, costs) = one, room
    X_regr, again, memo, best = tables.X_regr, not tables.one_pass, NOTHING, np.inf
    arcs, ends = arcs_of(tables, True), ends_of(tables)
    travel[:], costs[:] = np.inf, -1.0
    travel[c], k, at, falling = 0.0, len(order), c, False
    while True:
        if at >= 0:  # reached at less cost than before: it may end here, or go on from a hub
            if ends_at(rows, at, ends):
                best = min(best, travel[at])
            for i in range(len(rows)):
                onward = V[hubs[i], at] if len(V) > 0 else hub_default(rows, i, at, tables)
                best = min(best, travel[at] + X_regr + onward)
        if k == 0:
            if not falling:
                break
            k, falling = len(order), False
        k -= 1
        a, at = order[k], -1
        here = travel[tail[a]]
        if here < best and here < travel[head[a]]:  # else no cost of the arc matters
            if costs[kind[a]] < 0.0:
                costs[kind[a]], memo = arc_cost(rows, kind[a], known, arcs, cuts, z, memo)
            cost = costs[kind[a]]
            if here + cost < best and here + cost < travel[head[a]]:
                at = head[a]
                travel[at], falling = here + cost, again
    return float(best)


@compiled
def hub_rows(
    rows: IntArray, slot: int, choices: IntArray, which: IntArray, tables: Tables,
    cuts: CutTables, table: Array,
) -> None:  # fmt: skip
    """Write for a hub the costs to the goal in the lanes that some of its choices lead to.

    Args:
        rows: (n,), the placements; that of ``slot`` is replaced by each choice.
        slot: the lifted finger.
        choices: its possible placements.
        which: the choices to treat, by their numbers.
        tables: the tables.
        cuts: the cuts.
        table: output (choices, V).
    """
    known, z = unknown(tables)
    full, costs = rows.copy(), np.empty(tables.states.shape[0])
    for index in which:
        full[slot] = choices[index]
        _hub_row(full, tables, cuts, (known, z, costs), table[index])


@lean
def _hub_row(
    rows: IntArray, tables: Tables, cuts: CutTables, room: tuple[Array, Array, Array], d: Array
) -> None:
    """Write the costs to the goal (V,) in one lane."""
    order, tails, heads, kind = tables.order, tables.tail, tables.head, tables.kind
    (known, z, costs), again, falling, memo = room, not tables.one_pass, True, NOTHING
    arcs, ends, costs[:] = arcs_of(tables, True), ends_of(tables), -1.0
    for c in range(len(d)):
        d[c] = 0.0 if ends_at(rows, c, ends) else np.inf
    while falling:
        falling = False
        for k in range(len(order)):
            a = order[k]
            head, tail = heads[a], tails[a]
            if d[head] < d[tail]:  # else no cost of the arc matters
                if costs[kind[a]] < 0.0:
                    costs[kind[a]], memo = arc_cost(rows, kind[a], known, arcs, cuts, z, memo)
                if d[head] + costs[kind[a]] < d[tail]:
                    d[tail], falling = d[head] + costs[kind[a]], again
