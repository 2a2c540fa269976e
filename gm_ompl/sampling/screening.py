"""How far many sets of placements can get along a route, as cuts bound it; compiled.

A route is K strides of P segments; vertices are numbered 0..K. What is written here are bounds:
a set gets at most as far, and pays at least as much. No mode decision is made.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.cuts import CutTables, state_bound


class RouteTables(NamedTuple):
    """What all sets share along a route, as compiled code reads it.

    Attributes:
        states: (K, P), contact states of the segments, -1 where not yet asked for.
        free: (n, placements, K), whether object and fingertip are free along the stride.
        z_min: the threshold, over the kernel's unit of force.
    """

    states: IntArray
    free: BoolArray
    z_min: float


@compiled
def stride_holds(rows: IntArray, k: int, route: RouteTables, cuts: CutTables) -> bool:
    """Whether a set may hold along stride k, as far as geometry and cuts know."""
    for i in range(len(rows)):
        if not route.free[i, rows[i], k]:
            return False
    before = -1
    for p in range(route.states.shape[1]):
        state = route.states[k, p]
        if state != before and 0 <= state < len(cuts.counts):
            before = state
            if state_bound(state, rows, cuts) < route.z_min:
                return False
    return True


@compiled
def reaches(
    sets: IntArray, first: int, last: int, route: RouteTables, cuts: CutTables, reach: IntArray
) -> None:
    """Lower ``reach`` (L,), the furthest vertex each set (L, n) may come to from ``first``.

    Args:
        sets: the sets.
        first: where the motion starts.
        last: where it would end.
        route: the route.
        cuts: the cuts.
        reach: what is known so far, at most ``last``; lowered in place.
    """
    for m in range(sets.shape[0]):
        k = first
        while k < min(last, reach[m]) and stride_holds(sets[m], k, route, cuts):
            k += 1
        reach[m] = min(k, reach[m])


@compiled
def reaches_back(
    sets: IntArray, first: int, last: int, route: RouteTables, cuts: CutTables, reach: IntArray
) -> None:
    """Raise ``reach`` (L,), the earliest vertex from which each set may come to ``first``.

    Args:
        sets: the sets (L, n).
        first: where the motion ends.
        last: where it would start, at most ``first``.
        route: the route.
        cuts: the cuts.
        reach: what is known so far, at least ``last``; raised in place.
    """
    for m in range(sets.shape[0]):
        k = first
        while k > max(last, reach[m]) and stride_holds(sets[m], k - 1, route, cuts):
            k -= 1
        reach[m] = max(k, reach[m])


@compiled
def stride_costs(
    sets: IntArray, known: Array, lengths: Array, X_stab: float, route: RouteTables,
    cuts: CutTables, costs: Array,
) -> None:  # fmt: skip
    """Write lower bounds (L, K) on Eq. (9) per set and stride; +inf where it cannot hold.

    Args:
        sets: the sets (L, n).
        known: (L, K, P) or (0, K, P), decided margins, +inf undecided, negative failed.
        lengths: (n, placements, K, P), |dq_finger i,j|.
        X_stab: of Eq. (9), over the kernel's unit of force.
        route: the route.
        cuts: the cuts.
        costs: output.
    """
    K, P = route.states.shape
    z = np.empty(P)
    for m in range(sets.shape[0]):
        rows = sets[m]
        before, bound = -1, np.inf
        for k in range(K):
            holds = True
            for i in range(len(rows)):
                holds = holds and route.free[i, rows[i], k]
            for p in range(P):
                state = route.states[k, p]
                if state != before:
                    before, bound = state, np.inf
                    if 0 <= state < len(cuts.counts):
                        bound = state_bound(state, rows, cuts)
                z[p] = min(bound, known[m, k, p]) if len(known) else bound
                holds = holds and z[p] >= route.z_min
            most = 0.0
            if holds:
                for i in range(len(rows)):
                    travel = 0.0
                    for p in range(P):
                        factor = 1.0 + X_stab / z[p] if X_stab > 0.0 else 1.0
                        travel += factor * lengths[i, rows[i], k, p]
                    most = max(most, travel)
            costs[m, k] = most if holds else np.inf
