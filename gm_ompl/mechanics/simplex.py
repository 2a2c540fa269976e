"""All 76 directions of Problem (6) on one tableau.

For fixed modes and f_com the blocks of (6) share nothing but z, and z = 1 / max_i tau_i with

    tau_i = min tau  subject to  tau q + A k = l_i,  per finger sum_k = cap tau,  tau, k >= 0,

so only the right-hand side changes from direction to direction: a basis that is optimal for one
direction stays dual feasible for all, and one pivot moves all right-hand sides along.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.sides import SIDES, number, refine, refine_duals
from gm_ompl.mechanics.tableau import (
    CAREFUL,
    DANTZIG_STEPS,
    FEASIBLE,
    MAX_STEPS,
    MORE_STEPS,
    entering,
    leaving,
    pivot,
)

NO_TAU = 1e-13
"""A tau up to this (over force_scale) is none: z_i = +inf."""

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
def _solution(
    raw: Array, L: Array, T: Array, basis: IntArray, m: int, N: int, column: int, code: int,
    careful: bool, x: Array,
) -> None:  # fmt: skip
    """Write a direction's basic solution (m,): as it stands in the tableau, or refined."""
    sign = -1.0 if code % 2 else 1.0
    for r in range(m):
        x[r] = sign * T[r, column]
    if careful:
        side = np.zeros(m)
        for t in range(6):
            side[t] = L[number(code), t]
        refine(raw, T, basis, m, N, side, x)


@inlined
def _keep(
    basis: IntArray, m: int, N: int, code: int, x: Array, kept: Array, has: BoolArray,
    balance: Array,
) -> None:  # fmt: skip
    """Keep a direction solved by x; with its opposite it makes a balance (right-hand side 0)."""
    for r in range(m):
        if basis[r] < N:
            kept[basis[r], code] = max(x[r], 0.0)
    has[code] = True
    if has[code ^ 1]:
        for j in range(N):
            balance[j] += kept[j, code] + kept[j, code ^ 1]


@inlined
def _keep_bounded(
    basis: IntArray, m: int, N: int, code: int, x: Array, kept: Array, balance: Array,
    times: float,
) -> None:  # fmt: skip
    """Keep a direction that its basic solution x resists with the balance added ``times``."""
    for j in range(N):
        if balance[j] > 0.0:
            kept[j, code] = times * balance[j]
    for r in range(m):
        if basis[r] < N:
            kept[basis[r], code] += x[r]


@inlined
def _close_bounded(
    raw: Array, L: Array, T: Array, d: Array, basis: IntArray, m: int, N: int, S: int,
    slots: IntArray, cost: float, balance: Array, enough: float, ahead: BoolArray,
    behind: BoolArray, lo: Array, hi: Array, weights: Array, careful: bool, x: Array, kept: Array,
) -> None:  # fmt: skip
    """Close the directions that the balance proves to have tau <= enough, and keep why.

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
    if closing == 0:
        return
    for s in range(S):
        for opposite in range(2):
            open_ = behind[s] if opposite else ahead[s]
            more, tau = (hi[s], costs[s]) if opposite else (-lo[s], -costs[s])
            if not open_ or more + tau > enough:
                continue
            if opposite:
                behind[s] = False
            else:
                ahead[s] = False
            code = 2 * slots[s] + opposite
            _solution(raw, L, T, basis, m, N, first + s, code, careful, x)
            _keep_bounded(basis, m, N, code, x, kept, balance, more * per_tau)


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
    raw: Array, L: Array, T: Array, d: Array, basis: IntArray, m: int, N: int, S: int,
    slots: IntArray, ahead: BoolArray, behind: BoolArray, lo: Array, hi: Array, careful: bool,
    x: Array, kept: Array, has: BoolArray, balance: Array, worst: int, worst_tau: float,
) -> tuple[int, float]:  # fmt: skip
    """Close the directions that the present basis solves; return the worst so far, and its tau."""
    first = N + m
    for s in range(S):
        slack = (CAREFUL if careful else FEASIBLE) * max(1.0, max(hi[s], -lo[s]))
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
            _solution(raw, L, T, basis, m, N, first + s, code, careful, x)
            _keep(basis, m, N, code, x, kept, has, balance)
            if tau > worst_tau:
                worst, worst_tau = code, tau
    return worst, worst_tau


@inlined
def _step(
    T: Array, d: Array, basis: IntArray, m: int, N: int, S: int, now: int, least: float,
    careful: bool, bland: bool, x: Array, y: Array, room: Array,
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
    r = leaving(x, basis, m, N, CAREFUL if careful else FEASIBLE, bland)
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
    raw: Array, L: Array, T: Array, d: Array, basis: IntArray, cost: float, limit: float,
    enough: float, patience: int, least: float, careful: bool, bland: bool, y: Array,
    kept: Array,
) -> tuple[int, int, float]:  # fmt: skip
    """Find the direction with the largest tau, or one whose tau is large enough.

    Args:
        raw: (m, N), the columns.
        L: (76, 6), the directions.
        T: tableau, dual feasible, with all right-hand sides; left at its last basis, and right-hand
            sides are lost.
        d: reduced costs.
        basis: basic variable per row.
        cost: of the tau column: tau = cost times its variable.
        limit: stop as soon as a direction is solved whose tau exceeds this.
        enough: a tau that is proven to stay within this need not be known; 0 for the largest
            tau exactly.
        patience: pivots after which the worst direction so far will do.
        least: the smallest entry accepted as a pivot.
        careful: whether solutions and duals are refined, and no more than rounding is overlooked.
        bland: use Bland's rule throughout, the slow and sure one.
        y: output (m,): the duals that prove the tau returned (y . l_i = tau), or the ray with
            y . l_i > 0 where a direction is infeasible.
        kept: output (N, 76), by code: what resists each direction, where all were found.

    Returns:
        How the pass ended, the direction, its tau.
    """
    m, N = raw.shape
    ahead, behind = np.ones(SIDES, dtype=np.bool_), np.ones(SIDES, dtype=np.bool_)
    slots, has, work = np.arange(SIDES), np.zeros(2 * SIDES, dtype=np.bool_), np.empty((2, SIDES))
    lo, hi = work[0], work[1]
    ones, weights, x, balance, room = (
        np.ones(m), np.empty(m), np.empty(m), np.zeros(N), np.empty(N),
    )  # fmt: skip
    kept[:, :] = 0.0
    now, worst, worst_tau, here, first, S = -1, -1, -1.0, 0, N + m, len(slots)
    for step in range(MAX_STEPS + MORE_STEPS * N):
        _extremes(T, basis, m, N, S, ones, lo, hi)
        before = worst
        worst, worst_tau = _close_solved(
            raw, L, T, d, basis, m, N, S, slots, ahead, behind, lo, hi, careful, x, kept, has,
            balance, worst, worst_tau,
        )  # fmt: skip
        if worst != before:
            for r in range(m):
                y[r] = -d[N + r]
            if careful:
                refine_duals(raw, T, basis, m, N, cost, y)
        if worst_tau > limit or (step >= patience and worst_tau > NO_TAU):
            return EXCEEDED, number(worst), worst_tau
        if balance[0] > 0.0:
            _close_bounded(
                raw, L, T, d, basis, m, N, S, slots, cost, balance, max(worst_tau, enough), ahead,
                behind, lo, hi, weights, careful, x, kept,
            )  # fmt: skip
        if now < 0 or not (behind[now // 2] if now % 2 else ahead[now // 2]):
            S = _drop_closed(T, d, m, first, S, slots, ahead, behind)
            if S == 0:
                return SOLVED, number(worst), worst_tau
            now, here = _choose(d[first : first + S], S, ahead, behind, lo), 0
        here += 1
        slow = bland or here > DANTZIG_STEPS + N
        end = _step(T, d, basis, m, N, S, now, least, careful, slow, x, y, room)
        if end != SOLVED:
            return end, number(2 * slots[now // 2] + now % 2), np.inf
    return TROUBLE, -1, 0.0
