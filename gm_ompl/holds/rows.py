"""The tables of arcs as compiled code reads them, and least costs over them."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined

UNASKED: Final = -1
"""Stands for a contact state that was not asked for yet: nothing bounds z there."""


class Tables(NamedTuple):
    """The tables as compiled code reads them.

    The object's nodes are numbered 0..V - 1, its arcs 0..A - 1, and their kinds 0..K - 1: arcs of
    one kind differ in nothing that concerns the hand. An arc has at most P segments; one that has
    fewer repeats the last one's contact state, with no length.

    Attributes:
        tail: (A,), the node where each arc begins.
        head: (A,), and where it ends.
        kind: (A,), of each arc.
        like: (K,), a kind's row in ``free`` and ``lengths``: an arc and its way back share one.
        order: (A,), the arcs such that costs to the goal settle soon, each arc after those ahead.
        one_pass: whether they settle in one pass, as on a row of nodes.
        into: (A,), the arcs by the nodes where they end.
        first: (V + 1,), where the arcs into each node begin in ``into``.
        states: (K, P), contact states of the segments, UNASKED where no search has come yet.
        free: (n, placements, rows), whether object and fingertip are free along the arc.
        lengths: (n, placements, rows, P), chords |dq_finger i,j| of Eq. (9).
        node_free: (n, placements, V), whether they are free at the nodes.
        goal: (V,), the goal nodes.
        wanted: (n,), the placements required at the goal, -1 for any.
        ahead: (n, placements, V), lower bound on travel to the goal, this finger kept.
        least: (V,), lower bound on travel to the goal with whatever placements.
        z_min: the threshold, over the kernel's unit of force.
        z_floor: what a smaller margin counts as in Eq. (9), likewise.
        X_stab: of Eq. (9), over the kernel's unit of force.
        X_regr: cost of a regrasp.
    """

    tail: IntArray
    head: IntArray
    kind: IntArray
    like: IntArray
    order: IntArray
    one_pass: bool
    into: IntArray
    first: IntArray
    states: IntArray
    free: BoolArray
    lengths: Array
    node_free: BoolArray
    goal: BoolArray
    wanted: IntArray
    ahead: Array
    least: Array
    z_min: float
    z_floor: float
    X_stab: float
    X_regr: float


@inlined
def lower_once(d: Array, costs: Array, tables: Tables) -> None:
    """Do what ``lower`` does where one pass over the arcs is enough."""
    tail, head, order, kind = tables.tail, tables.head, tables.order, tables.kind
    for k in range(len(order)):
        a = order[k]
        through = d[head[a]] + costs[kind[a]]
        if through < d[tail[a]]:
            d[tail[a]] = through


@compiled
def lower(d: Array, costs: Array, tables: Tables) -> None:
    """Lower d (V,) to the least cost to go, by arcs whose kinds cost this (K,).

    On a row of nodes one pass over the arcs does it. Elsewhere a node whose value has fallen waits
    in a queue to be followed back (Bellman, Ford and Moore's algorithm).
    """
    if tables.one_pass:
        lower_once(d, costs, tables)
        return
    tail, kind, V = tables.tail, tables.kind, len(d)
    queue, waits = np.empty(V, dtype=np.int64), np.zeros(V, dtype=np.bool_)
    front, count = 0, 0
    for c in range(V):
        if d[c] < np.inf:
            queue[count], waits[c] = c, True
            count += 1
    while count > 0:
        c = queue[front]
        front, count, waits[c] = (front + 1) % V, count - 1, False
        for k in range(tables.first[c], tables.first[c + 1]):
            a = tables.into[k]
            t, through = tail[a], d[c] + costs[kind[a]]
            if through < d[t]:
                d[t] = through
                if not waits[t]:
                    queue[(front + count) % V], waits[t] = t, True
                    count += 1


@compiled
def settle(cost: Array, tables: Tables, ahead: Array) -> None:
    """Write the least costs to a goal node (m, V), by arcs whose rows cost this (m, rows)."""
    costs = np.empty(len(tables.like))
    for i in range(cost.shape[0]):
        for k in range(len(costs)):
            costs[k] = cost[i, tables.like[k]]
        for c in range(ahead.shape[1]):
            ahead[i, c] = 0.0 if tables.goal[c] else np.inf
        lower(ahead[i], costs, tables)
