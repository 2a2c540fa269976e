"""Lower bounds on travel along lanes, compiled.

A lane is one set of placements on a lattice of one coordinate: a line of nodes 0..N joined by N
forward and N backward arcs. Arrays over a lane's arcs have shape (N,), over its segments (N, P);
those of backward arcs stand in the order of the forward ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cuts import CutTables, state_bound

SHORTER = 1.0 - 1e-11
"""A hub counts as reached anew only by this factor: sums in another order are not progress."""


class LaneTables(NamedTuple):
    """What all lanes share, as compiled code reads it.

    Attributes:
        forward: (N, P), contact states of the forward arcs' segments.
        backward: (N, P), of the backward arcs'.
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


@compiled
def bounded_margins(
    rows: IntArray, states: IntArray, cuts: CutTables, known: Array, z: Array
) -> None:
    """Write upper bounds on z per segment (N, P): what is known of it, else the state's cuts."""
    before, bound = -1, np.inf
    for i in range(states.shape[0]):
        for j in range(states.shape[1]):
            if states[i, j] != before:
                before = states[i, j]
                bound = state_bound(before, rows, cuts)
            z[i, j] = min(bound, known[i, j])


@compiled
def arc_costs(rows: IntArray, z: Array, lanes: LaneTables, cost: Array) -> None:
    """Write Eq. (9) per arc (N,) for margins z (N, P); +inf where the arc cannot hold."""
    N, P = z.shape
    factors, before, factor = np.empty(P), np.nan, 1.0
    for i in range(N):
        cost[i] = np.inf
        holds = True
        for k in range(len(rows)):
            holds = holds and lanes.free[k, rows[k], i]
        for j in range(P):
            holds = holds and z[i, j] >= lanes.z_min
        if not holds:
            continue
        for j in range(P):
            if z[i, j] != before:  # margins repeat while the contact state does
                before = z[i, j]
                factor = 1.0 + lanes.X_stab / before if lanes.X_stab > 0.0 else 1.0
            factors[j] = factor
        most = 0.0
        for k in range(len(rows)):
            travel = 0.0
            for j in range(P):
                travel += factors[j] * lanes.lengths[k, rows[k], i, j]
            most = max(most, travel)
        cost[i] = most


@compiled
def costs_to_go(
    rows: IntArray, forward: Array, backward: Array, lanes: LaneTables, d: Array
) -> None:
    """Write per node (N + 1,) the cost of reaching a goal node inside the lane."""
    N = len(forward)
    fits = True
    for k in range(len(rows)):
        fits = fits and (lanes.wanted[k] < 0 or lanes.wanted[k] == rows[k])
    run = np.inf
    for c in range(N, -1, -1):
        run = 0.0 if lanes.goal[c] and fits else (run + forward[c] if c < N else np.inf)
        d[c] = run
    run = np.inf
    for c in range(N + 1):
        run = 0.0 if lanes.goal[c] and fits else (run + backward[c - 1] if c > 0 else np.inf)
        d[c] = min(d[c], run)
        for k in range(len(rows)):
            if not lanes.node_free[k, rows[k], c]:
                d[c] = np.inf


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
        z: output (2, N, P), upper bounds on the margins.
        costs: output (2, N), lower bounds on Eq. (9).
        d: output (N + 1,), lower bounds on the cost to the goal inside the lane.
    """
    bounded_margins(rows, lanes.forward, cuts, known[0], z[0])
    arc_costs(rows, z[0], lanes, costs[0])
    bounded_margins(rows, lanes.backward, cuts, known[1], z[1])
    arc_costs(rows, z[1], lanes, costs[1])
    costs_to_go(rows, costs[0], costs[1], lanes, d)


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


@compiled
def hub_defaults(rows: IntArray, lanes: LaneTables, V: Array) -> None:
    """Write V (n, N + 1) as geometry alone bounds it: the fingers that stay travel to the goal."""
    n = len(rows)
    for t in range(V.shape[1]):
        for k in range(n):
            through = lanes.least[t]
            for i in range(n):
                if i != k:
                    through = max(through, lanes.ahead[i, rows[i], t])
            V[k, t] = min(through, lanes.X_regr + lanes.least[t])


@compiled
def lane_keys(
    sets: IntArray, ids: IntArray, V: Array, c: int, lanes: LaneTables, cuts: CutTables,
    keys: Array,
) -> None:  # fmt: skip
    """Write for many lanes a lower bound on the cost from node c to the goal.

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
    n = sets.shape[1]
    known, z = np.full((2, N, P), np.inf), np.empty((2, N, P))
    costs, d = np.empty((2, N)), np.empty(N + 1)
    here, G = np.empty((n, N + 1)), np.full((n, N + 1), np.inf)
    costs[1] = np.inf
    for i in range(sets.shape[0]):
        if c > 0:
            refresh(sets[i], lanes, cuts, known, z, costs, d)
        else:  # nothing lies behind: backward arcs do not matter
            bounded_margins(sets[i], lanes.forward, cuts, known[0], z[0])
            arc_costs(sets[i], z[0], lanes, costs[0])
            costs_to_go(sets[i], costs[0], costs[1], lanes, d)
        if ids.shape[0] == 0:
            hub_defaults(sets[i], lanes, here)
        else:
            for k in range(n):
                here[k] = V[ids[i, k]]
        keys[i] = best_target(c, 0.0, costs, d, here, G, lanes.X_regr)[0]


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
    known, z = np.full((2, N, P), np.inf), np.empty((2, N, P))
    costs, full = np.empty((2, N)), rows.copy()
    for index in which:
        full[slot] = choices[index]
        refresh(full, lanes, cuts, known, z, costs, table[index])
