"""All 76 directions of Problem (6) on one tableau.

For fixed modes and f_com the blocks of (6) share nothing but z, and z = 1 / max_i tau_i with

    tau_i = min tau  subject to  tau q + A k = l_i,  per finger sum_k = cap tau,  tau, k >= 0,

so only the right-hand side changes: a basis that is optimal for one direction stays dual feasible
for all, and one pivot moves all right-hand sides along.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.resistance import Resistance
from gm_ompl.mechanics.sides import SIDES
from gm_ompl.mechanics.tableau import (
    DANTZIG_STEPS,
    MAX_STEPS,
    MORE_STEPS,
    entering,
    leaving,
    pivot,
)

NO_TAU = 1e-13
"""A tau up to this (over force_scale) is none: z_i = +inf."""

SPACED = (SIDES + 7) // 8 * 8
"""Entries per right-hand side, rounded up to where a vector may begin."""
SOLVED, EXCEEDED, INFEASIBLE, TROUBLE = 0, 1, 2, 3
"""Ends of a pass: the worst direction found; stopped early at a direction; a direction that
nothing resists; give up."""


@compiled
def _eight_rows(
    T: Array, first: int, S: int, last: int, weights: Array, lo: Array, hi: Array
) -> None:
    """Write the least and greatest of 0 and the weighted entries of rows 0 to 7, per column.

    Six to eight rows are there, ``last`` is the last one. All that one column needs stands in one
    expression: many columns are done at a time, and nothing goes through memory in between.
    """
    r6, r7, end = min(6, last), min(7, last), first + S
    a, b, c, d = T[0, first:end], T[1, first:end], T[2, first:end], T[3, first:end]
    e, f, g, h = T[4, first:end], T[5, first:end], T[r6, first:end], T[r7, first:end]
    low, high = lo[:S], hi[:S]
    w0, w1, w2, w3 = weights[0], weights[1], weights[2], weights[3]
    w4, w5, w6, w7 = weights[4], weights[5], weights[r6], weights[r7]
    for j in range(S):
        x0, x1, x2, x3 = w0 * a[j], w1 * b[j], w2 * c[j], w3 * d[j]
        x4, x5, x6, x7 = w4 * e[j], w5 * f[j], w6 * g[j], w7 * h[j]
        u, v = min(min(x0, x1), min(x2, x3)), min(min(x4, x5), min(x6, x7))
        low[j] = min(0.0, min(u, v))
        u, v = max(max(x0, x1), max(x2, x3)), max(max(x4, x5), max(x6, x7))
        high[j] = max(0.0, max(u, v))


@inlined
def _extremes(
    T: Array, basis: IntArray, m: int, N: int, S: int, weights: Array, lo: Array, hi: Array
) -> None:
    """Write the least and greatest weighted basic variable per right-hand side in the tableau.

    Artificial variables count with both signs.
    """
    _eight_rows(T, N + m, S, m - 1, weights, lo, hi)
    for r in range(m):
        if r >= 8 or basis[r] >= N:
            row, w = T[r, N + m : N + m + S], weights[r]
            mirrored = w if basis[r] < N else -w
            for j in range(S):
                x, y, low, high = w * row[j], mirrored * row[j], lo[j], hi[j]
                low, high = x if x < low else low, x if x > high else high
                lo[j], hi[j] = y if y < low else low, y if y > high else high


@inlined
def _keep(
    T: Array, basis: IntArray, m: int, column: int, code: int, times: float, columns: IntArray,
    x: Array, multiples: Array, order: IntArray, count: int,
) -> None:  # fmt: skip
    """Keep the basic solution of a direction, and how often the balance comes to it."""
    sign = -1.0 if code % 2 else 1.0
    for r in range(m):
        columns[code, r] = basis[r]
        x[code, r] = sign * T[r, column]
    multiples[code], order[count] = times, code


@inlined
def _close_bounded(
    T: Array, d: Array, basis: IntArray, m: int, N: int, S: int, slots: IntArray, cost: float,
    enough: float, ahead: BoolArray, behind: BoolArray, lo: Array, hi: Array, weights: Array,
    columns: IntArray, x: Array, multiples: Array, order: IntArray, count: int, balance: Array,
) -> int:  # fmt: skip
    """Close the directions that the balance proves to have tau <= enough; return how many are.

    The basic solution of a direction plus a multiple of the balance resists that direction too,
    once the sum is nowhere negative.
    """
    per_tau = 1.0 / (balance[0] * cost)
    for r in range(m):
        share = per_tau * balance[basis[r]] if basis[r] < N else 0.0
        weights[r] = 1.0 / max(share, 1e-9)
    _extremes(T, basis, m, N, S, weights, lo, hi)
    first = N + m
    costs = d[first : first + S]
    closing = 0
    for s in range(S):
        closing += ahead[s] & (-lo[s] - costs[s] <= enough)
        closing += behind[s] & (hi[s] + costs[s] <= enough)
    for s in range(S if closing > 0 else 0):
        if ahead[s] and -lo[s] - costs[s] <= enough:
            ahead[s], code, times = False, 2 * slots[s], -lo[s] * per_tau
            _keep(T, basis, m, first + s, code, times, columns, x, multiples, order, count)
            count += 1
        if behind[s] and hi[s] + costs[s] <= enough:
            behind[s], code, times = False, 2 * slots[s] + 1, hi[s] * per_tau
            _keep(T, basis, m, first + s, code, times, columns, x, multiples, order, count)
            count += 1
    return count


@inlined
def _drop_closed(
    T: Array, d: Array, m: int, first: int, S: int, slots: IntArray, ahead: BoolArray,
    behind: BoolArray,
) -> int:  # fmt: skip
    """Drop right-hand sides closed both ways; the last ones take their places."""
    s = 0
    while s < S:
        if ahead[s] or behind[s]:
            s += 1
            continue
        S -= 1
        slots[s], ahead[s], behind[s] = slots[S], ahead[S], behind[S]
        d[first + s] = d[first + S]
        for r in range(m):
            T[r, first + s] = T[r, first + S]
    return S


@inlined
def _choose(costs: Array, S: int, ahead: BoolArray, behind: BoolArray, bounds: Array) -> int:
    """Return the direction to solve next: 2 s for right-hand side s, 2 s + 1 for its opposite.

    It is the one with the largest bound on tau: what is worst is found early, and what is solved
    far out tells most about the rest. ``bounds`` (S,) is room to work in.
    """
    for s in range(S):
        one = -costs[s] if ahead[s] else -np.inf
        other = costs[s] if behind[s] else -np.inf
        bounds[s] = one if one > other else other
    best, chosen = -np.inf, 0
    for s in range(S):
        chosen = s if bounds[s] > best else chosen
        best = bounds[s] if bounds[s] > best else best
    return 2 * chosen if ahead[chosen] and -costs[chosen] == best else 2 * chosen + 1


@inlined
def _close_solved(
    T: Array, d: Array, basis: IntArray, m: int, N: int, S: int, slots: IntArray,
    ahead: BoolArray, behind: BoolArray, lo: Array, hi: Array, overlooked: float,
    columns: IntArray, x: Array, multiples: Array, order: IntArray, count: int,
    alone: BoolArray, balance: Array, worst: int, worst_tau: float,
) -> tuple[int, int, float]:  # fmt: skip
    """Close the directions that the present basis solves.

    Returns:
        How many are closed, the worst so far, its tau.
    """
    first = N + m
    for s in range(S):
        slack = overlooked * max(1.0, max(hi[s], -lo[s]))
        if min(hi[s], -lo[s]) > slack:
            continue
        for opposite in range(2):
            open_, miss = (behind[s], hi[s]) if opposite else (ahead[s], -lo[s])
            if not open_ or miss > slack:
                continue
            code, tau = 2 * slots[s] + opposite, d[first + s] if opposite else -d[first + s]
            if opposite:
                behind[s] = False
            else:
                ahead[s] = False
            _keep(T, basis, m, first + s, code, 0.0, columns, x, multiples, order, count)
            count += 1
            alone[code] = True
            if alone[code ^ 1]:
                for k in (code, code ^ 1):
                    for r in range(m):
                        if columns[k, r] < N:
                            balance[columns[k, r]] += max(x[k, r], 0.0)
            if tau > worst_tau:
                worst, worst_tau = code, tau
    return count, worst, worst_tau


@inlined
def _step(
    T: Array, d: Array, basis: IntArray, m: int, N: int, S: int, now: int, least: float,
    overlooked: float, bland: bool, x: Array, y: Array, room: Array,
) -> int:  # fmt: skip
    """Pivot towards a direction; where nothing resists it, ``y`` (m,) gets the ray that proves it.

    ``x`` (m,) and ``room`` (N,) are room to work in.

    Returns:
        SOLVED where a pivot was made, INFEASIBLE, or TROUBLE.
    """
    column = N + m + now // 2
    sign = -1.0 if now % 2 else 1.0
    for r in range(m):
        x[r] = sign * T[r, column]
    r = leaving(x, basis, m, N, overlooked, bland)
    if r < 0:
        return TROUBLE
    sign = 1.0 if x[r] < 0.0 else -1.0
    c = entering(T, d, N, r, sign, least, bland, room)
    if c < 0:
        for i in range(m):
            y[i] = -sign * T[r, N + i]
        return INFEASIBLE
    pivot(T, d, basis, m, N + m + S, r, c)
    return SOLVED


@compiled
def search_directions(
    T: Array, d: Array, basis: IntArray, m: int, N: int, cost: float, limit: float,
    enough: float, patience: int, least: float, overlooked: float, bland: bool, y: Array,
    found: Resistance,
) -> tuple[int, int, float]:  # fmt: skip
    """Find the direction with the largest tau, or one whose tau is large enough.

    Args:
        T: tableau, dual feasible, with all right-hand sides; left at its last basis, and right-hand
            sides are lost.
        d: reduced costs.
        basis: basic variable per row.
        m: number of rows.
        N: number of real columns.
        cost: of the tau column: tau = cost times its variable.
        limit: stop as soon as a direction is solved whose tau exceeds this.
        enough: a tau that is proven to stay within this need not be known; 0 for the largest
            tau exactly.
        patience: pivots after which the worst direction so far will do.
        least: the smallest entry accepted as a pivot.
        overlooked: how far a basic variable may be on the wrong side, relative to the largest.
        bland: use Bland's rule throughout, the slow and sure one.
        y: output (m,): the duals that prove the tau returned (y . l_i = tau), or the ray with
            y . l_i > 0 where a direction is infeasible.
        found: output, what resists each direction that was closed.

    Returns:
        How the pass ended, the direction's code, its tau.
    """
    # Rooms in one piece where they can be: asking for each takes longer than a pivot.
    flags, slots = np.ones(4 * SIDES, dtype=np.bool_), np.arange(SIDES)
    ahead, behind, alone = flags[:SIDES], flags[SIDES : 2 * SIDES], flags[2 * SIDES :]
    numbers = np.zeros(2 * SPACED + 3 * m + 2 * N)
    lo, hi, rest = numbers[:SPACED], numbers[SPACED : 2 * SPACED], numbers[2 * SPACED :]
    ones, weights, side = rest[:m], rest[m : 2 * m], rest[2 * m : 3 * m]
    room, balance = rest[3 * m : 3 * m + N], rest[3 * m + N :]
    alone[:], ones[:] = False, 1.0
    columns, x, multiples, order = found.basis, found.x, found.times, found.order
    now, worst, worst_tau, here, first, S, count = -1, -1, -1.0, 0, N + m, len(slots), 0
    for step in range(MAX_STEPS + MORE_STEPS * N):
        _extremes(T, basis, m, N, S, ones, lo, hi)
        before = worst
        count, worst, worst_tau = _close_solved(
            T, d, basis, m, N, S, slots, ahead, behind, lo, hi, overlooked, columns, x, multiples,
            order, count, alone, balance, worst, worst_tau,
        )  # fmt: skip
        if worst != before:
            for r in range(m):
                y[r] = -d[N + r]
        if worst_tau > limit or (step >= patience and worst_tau > NO_TAU):
            return EXCEEDED, worst, worst_tau
        if balance[0] > 0.0:
            count = _close_bounded(
                T, d, basis, m, N, S, slots, cost, max(worst_tau, enough), ahead, behind, lo, hi,
                weights, columns, x, multiples, order, count, balance,
            )  # fmt: skip
        if now < 0 or not (behind[now // 2] if now % 2 else ahead[now // 2]):
            S = _drop_closed(T, d, m, first, S, slots, ahead, behind)
            if S == 0:
                return SOLVED, worst, worst_tau
            now, here = _choose(d[first : first + S], S, ahead, behind, lo), 0
        here += 1
        slow = bland or here > DANTZIG_STEPS + N
        end = _step(T, d, basis, m, N, S, now, least, overlooked, slow, side, y, room)
        if end != SOLVED:
            return end, 2 * slots[now // 2] + now % 2, np.inf
    return TROUBLE, -1, 0.0
