"""Dual simplex on a dense tableau for all 76 directions of Problem (6) at once.

For fixed modes and f_com the blocks of (6) share nothing but z, and z = 1 / max_i tau_i with

    tau_i = min tau  subject to  tau q + A k = l_i,  per finger sum_k = cap tau,  tau, k >= 0,

so only the right-hand side changes from direction to direction: a basis that is optimal for one
direction stays dual feasible for all, and one pivot moves all right-hand sides along.

Layout of a tableau: row r belongs to basis[r]; columns 0..N-1 are real variables (0 is tau),
N..N+m-1 artificial ones, fixed at zero, then 38 right-hand sides: +e_1..+e_6 and the corners with
+ in the last coordinate (the opposite directions have the opposite basic solutions). ``d`` holds
the reduced costs; y = -d[N:N+m] are the duals, and -d of a right-hand side is y . l.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

PIVOT = 1e-9
"""Smallest entry accepted as a pivot; columns have norms of order 1."""
FEASIBLE = 1e-10
"""Tolerance on basic variables, relative to the largest of them (at least 1)."""
DANTZIG_STEPS = 60
"""Pivots within one direction before falling back to Bland's rule, which cannot cycle."""
MAX_STEPS = 2000
"""Pivots within one pass before giving up on the tableau."""

SIDES = 38
"""Right-hand sides in a tableau: one for each pair of opposite directions."""

SOLVED, EXCEEDED, INFEASIBLE, TROUBLE = 0, 1, 2, 3
"""Ends of a pass: all directions solved; a tau above the given limit; no tau at all; give up."""


@compiled
def pivot(T: Array, d: Array, basis: IntArray, m: int, W: int, r: int, c: int) -> None:
    """Bring column c into the basis in row r."""
    scale = 1.0 / T[r, c]
    for j in range(W):
        T[r, j] *= scale
    T[r, c] = 1.0
    for i in range(m):
        factor = T[i, c]
        if i != r and factor != 0.0:
            for j in range(W):
                T[i, j] -= factor * T[r, j]
            T[i, c] = 0.0
    factor = d[c]
    if factor != 0.0:
        for j in range(W):
            d[j] -= factor * T[r, j]
        d[c] = 0.0
    basis[r] = c


@compiled
def side(j: int) -> int:
    """Return the direction whose right-hand side is number j."""
    return 2 * j if j < 6 else 6 + j


@compiled
def opposite(j: int) -> int:
    """Return the direction opposite to that of right-hand side j."""
    return 2 * j + 1 if j < 6 else 81 - j


@compiled
def start(
    raw: Array, cost: float, L: Array, T: Array, d: Array, basis: IntArray, m: int, N: int
) -> None:
    """Fill the tableau from the raw columns (m, N) with the all-artificial basis."""
    for i in range(m):
        for j in range(SIDES):
            T[i, N + m + j] = L[side(j), i] if i < 6 else 0.0
        for j in range(N):
            T[i, j] = raw[i, j]
        for j in range(m):
            T[i, N + j] = 0.0
        T[i, N + i] = 1.0
        basis[i] = N + i
    for j in range(N + m + SIDES):
        d[j] = 0.0
    d[0] = cost


@compiled
def restart(
    raw: Array, cost: float, L: Array, T: Array, d: Array, basis: IntArray, old: IntArray,
    m: int, N: int,
) -> bool:  # fmt: skip
    """Fill the tableau anew with the basis ``old``; False where that is no longer dual feasible."""
    start(raw, cost, L, T, d, basis, m, N)
    free = np.ones(m, dtype=np.bool_)
    for i in range(m):
        if old[i] >= N:
            free[old[i] - N] = False
    for i in range(m):
        if old[i] < N:
            best, row = 1e-7, -1
            for r in range(m):
                if free[r] and abs(T[r, old[i]]) > best:
                    best, row = abs(T[r, old[i]]), r
            if row < 0:
                return False
            pivot(T, d, basis, m, N + m + SIDES, row, old[i])
            free[row] = False
    for j in range(N):
        if d[j] < 0.0:
            if d[j] < -1e-9:
                return False
            d[j] = 0.0
    return True


@compiled
def _extremes(
    T: Array, basis: IntArray, m: int, N: int, weights: Array, lo: Array, hi: Array
) -> None:
    """Write the least and greatest weighted basic variable per right-hand side.

    Artificial variables count with both signs.
    """
    first = N + m
    for j in range(SIDES):
        lo[j], hi[j] = 0.0, 0.0
    for r in range(m):
        w = weights[r]
        if basis[r] < N:
            for j in range(SIDES):
                x = w * T[r, first + j]
                lo[j] = x if x < lo[j] else lo[j]
                hi[j] = x if x > hi[j] else hi[j]
        else:
            for j in range(SIDES):
                x = w * abs(T[r, first + j])
                lo[j] = -x if -x < lo[j] else lo[j]
                hi[j] = x if x > hi[j] else hi[j]


@compiled
def _keep(
    T: Array, basis: IntArray, m: int, N: int, code: int, tau: float,
    kept: Array, has: IntArray, balance: Array,
) -> None:  # fmt: skip
    """Remember a solved direction; with its opposite it makes a balance (right-hand side 0)."""
    sign = -1.0 if code % 2 else 1.0
    kept[code, :] = 0.0
    for r in range(m):
        if basis[r] < N:
            kept[code, basis[r]] = max(sign * T[r, N + m + code // 2], 0.0)
    has[code] = 1
    if has[code ^ 1]:
        for j in range(N):
            balance[j] += kept[code, j] + kept[code ^ 1, j]


@compiled
def _leaving(x: Array, basis: IntArray, m: int, N: int, bland: bool) -> int:
    """Return the row to leave: the most infeasible one, or by Bland's rule the first variable."""
    size = 1.0
    for r in range(m):
        size = max(size, abs(x[r]))
    best, row = FEASIBLE * size, -1
    for r in range(m):
        excess = abs(x[r]) if basis[r] >= N else -x[r]
        if excess > FEASIBLE * size and (
            (bland and (row < 0 or basis[r] < basis[row])) or (not bland and excess > best)
        ):
            best, row = excess, r
    return row


@compiled
def _entering(T: Array, d: Array, N: int, r: int, sign: float, bland: bool) -> int:
    """Return the entering column by the dual ratio test, or -1 where there is none."""
    ratio = np.inf
    for j in range(N):
        alpha = -sign * T[r, j]
        if alpha > PIVOT and d[j] + 1e-12 < ratio * alpha:
            ratio = (d[j] + 1e-12) / alpha
    best, column = 0.0, -1
    for j in range(N):
        alpha = -sign * T[r, j]
        if alpha > PIVOT and d[j] <= ratio * alpha and alpha > best:
            best, column = alpha, j
            if bland:
                break
    return column


@compiled
def _next_direction(
    d: Array, first: int, lo: Array, hi: Array, open_: IntArray, worst_tau: float
) -> int:
    """Return the open direction to solve next, coded 2 j + (0: side j, 1: its opposite).

    The one with the largest bound on tau if that beats the worst so far, else the one that the
    present basis misses by least: a pivot or two will do.
    """
    best_tau, by_tau, best_miss, by_miss = worst_tau, -1, np.inf, -1
    for j in range(SIDES):
        for opp in range(2):
            if open_[2 * j + opp]:
                tau = d[first + j] if opp else -d[first + j]
                miss = hi[j] if opp else -lo[j]
                if tau > best_tau:
                    best_tau, by_tau = tau, 2 * j + opp
                if miss < best_miss:
                    best_miss, by_miss = miss, 2 * j + opp
    return by_tau if by_tau >= 0 else by_miss


@compiled
def worst_direction(
    T: Array, d: Array, basis: IntArray, m: int, N: int, cost: float, limit: float, y: Array
) -> tuple[int, int, float]:
    """Find the direction with the largest tau.

    Args:
        T: tableau, dual feasible; left at its last basis.
        d: reduced costs.
        basis: basic variable per row.
        m: number of rows.
        N: number of real columns.
        limit: stop as soon as a direction is solved whose tau exceeds this.
        y: output (m,): the duals that prove the tau returned (y . l_i = tau), or the ray with
            y . l_i > 0 where a direction is infeasible.

    Returns:
        How the pass ended, the direction, its tau.
    """
    open_, has = np.ones(2 * SIDES, dtype=np.int64), np.zeros(2 * SIDES, dtype=np.int64)
    lo, hi, x = np.empty(SIDES), np.empty(SIDES), np.empty(m)
    low, high, ones, weights = np.empty(SIDES), np.empty(SIDES), np.ones(m), np.ones(m)
    kept, balance = np.empty((2 * SIDES, N)), np.zeros(N)
    now, worst, worst_tau, here, first = -1, -1, -1.0, 0, N + m
    for _ in range(MAX_STEPS):
        _extremes(T, basis, m, N, ones, lo, hi)
        left, better = 0, False
        for j in range(SIDES):
            slack = FEASIBLE * max(1.0, max(hi[j], -lo[j]))
            for opp in range(2):
                if open_[2 * j + opp]:
                    if (hi[j] if opp else -lo[j]) > slack:
                        left += 1
                        continue
                    open_[2 * j + opp] = 0
                    tau = d[first + j] if opp else -d[first + j]
                    _keep(T, basis, m, N, 2 * j + opp, tau, kept, has, balance)
                    if tau > worst_tau:
                        worst, worst_tau, better = 2 * j + opp, tau, True
        if balance[0] > 0.0 and left > 0:
            cost_free = 1.0 / (balance[0] * cost)
            for r in range(m):
                share = cost_free * balance[basis[r]] if basis[r] < N else 0.0
                weights[r] = 1.0 / max(share, 1e-9)
            _extremes(T, basis, m, N, weights, low, high)
            for j in range(SIDES):
                for opp in range(2):
                    if open_[2 * j + opp]:
                        spare = worst_tau - (d[first + j] if opp else -d[first + j])
                        if (high[j] if opp else -low[j]) <= spare:
                            open_[2 * j + opp] = 0
                            left -= 1
        if better:
            for r in range(m):
                y[r] = -d[N + r]
        if worst_tau > limit or left == 0:
            end = EXCEEDED if worst_tau > limit else SOLVED
            return end, opposite(worst // 2) if worst % 2 else side(worst // 2), worst_tau
        if now < 0 or not open_[now]:
            now, here = _next_direction(d, first, lo, hi, open_, worst_tau), 0
        sign = -1.0 if now % 2 else 1.0
        for r in range(m):
            x[r] = sign * T[r, first + now // 2]
        here += 1
        r = _leaving(x, basis, m, N, here > DANTZIG_STEPS)
        if r < 0:
            break
        sign = 1.0 if x[r] < 0.0 else -1.0
        c = _entering(T, d, N, r, sign, here > DANTZIG_STEPS)
        if c < 0:
            for i in range(m):
                y[i] = -sign * T[r, N + i]
            return INFEASIBLE, opposite(now // 2) if now % 2 else side(now // 2), np.inf
        pivot(T, d, basis, m, first + SIDES, r, c)
    return TROUBLE, -1, 0.0


@compiled
def feasible(
    T: Array, d: Array, basis: IntArray, m: int, N: int, W: int, b: Array, x: Array
) -> int:
    """Dual simplex for the one right-hand side ``b`` (m,), from a dual feasible tableau.

    Returns:
        1 where ``x`` (m,) is the optimal basic solution, 0 where there is none, -1 in trouble.
    """
    for step in range(MAX_STEPS):
        for r in range(m):
            x[r] = 0.0
            for j in range(m):
                x[r] += T[r, N + j] * b[j]
        bland = step > DANTZIG_STEPS * (1 + m // 12)
        r = _leaving(x, basis, m, N, bland)
        if r < 0:
            return 1
        c = _entering(T, d, N, r, 1.0 if x[r] < 0.0 else -1.0, bland)
        if c < 0:
            return 0
        pivot(T, d, basis, m, W, r, c)
    return -1
