"""Which of the 76 directions a tableau answers as it stands, and what is kept of them; compiled.

A right-hand side in the tableau stands for two directions: place 2 s for that of side s, 2 s + 1
for its opposite. They are named by places until they are kept, then by codes (``sides``).

Arrays come one by one here: numba counts every use of every array of a tuple, once per pivot.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.sides import SIDES


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
def extremes(
    T: Array, basis: IntArray, N: int, S: int, weights: Array, lo: Array, hi: Array
) -> None:
    """Write the least and greatest weighted basic variable per right-hand side in the tableau.

    Artificial variables count with both signs.
    """
    m = len(basis)
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
def sides_left() -> tuple[IntArray, BoolArray, BoolArray, BoolArray]:
    """Return the side at each place (38,), who is open there, whose opposite; by code, nobody."""
    flags = np.ones(4 * SIDES, dtype=np.bool_)
    alone = flags[2 * SIDES :]
    alone[:] = False
    return np.arange(SIDES), flags[:SIDES], flags[SIDES : 2 * SIDES], alone


@inlined
def solved(
    S: int, lo: Array, hi: Array, overlooked: float, ahead: BoolArray, behind: BoolArray,
    closing: IntArray,
) -> int:  # fmt: skip
    """Close the open directions that the present basis solves; return how many ``closing`` gets."""
    count = 0
    for s in range(S):
        slack = overlooked * max(1.0, max(hi[s], -lo[s]))
        if min(hi[s], -lo[s]) > slack:
            continue
        if ahead[s] and not -lo[s] > slack:
            ahead[s], closing[count] = False, 2 * s
            count += 1
        if behind[s] and not hi[s] > slack:
            behind[s], closing[count] = False, 2 * s + 1
            count += 1
    return count


@inlined
def bounded(
    costs: Array, lo: Array, hi: Array, enough: float, ahead: BoolArray, behind: BoolArray,
    closing: IntArray,
) -> int:  # fmt: skip
    """Close the open directions that the balance proves to have tau <= enough, likewise.

    The basic solution of a direction plus a multiple of the balance resists that direction too,
    once the sum is nowhere negative. ``costs`` (S,) are the right-hand sides' reduced costs.
    """
    S, count, some = len(costs), 0, 0
    for s in range(S):
        some += ahead[s] & (-lo[s] - costs[s] <= enough)
        some += behind[s] & (hi[s] + costs[s] <= enough)
    for s in range(S if some > 0 else 0):
        if ahead[s] and -lo[s] - costs[s] <= enough:
            ahead[s], closing[count] = False, 2 * s
            count += 1
        if behind[s] and hi[s] + costs[s] <= enough:
            behind[s], closing[count] = False, 2 * s + 1
            count += 1
    return count


@inlined
def weigh(basis: IntArray, N: int, balance: Array, cost: float, weights: Array) -> float:
    """Write weights that show how much of the balance a basic variable needs; return 1 / its tau.

    A weighted variable of -x takes x of the balance's tau.
    """
    per_tau = 1.0 / (balance[0] * cost)
    for r in range(len(basis)):
        share = per_tau * balance[basis[r]] if basis[r] < N else 0.0
        weights[r] = 1.0 / max(share, 1e-9)
    return per_tau


@inlined
def worst_of(
    costs: Array, slots: IntArray, closing: IntArray, worst: int, tau: float
) -> tuple[int, float]:
    """Return the code of the worst direction so far, those closing by place included, and tau."""
    for place in closing:
        cost = costs[place >> 1] if place & 1 else -costs[place >> 1]
        if cost > tau:
            worst, tau = 2 * slots[place >> 1] + (place & 1), cost
    return worst, tau


@inlined
def share(
    closing: IntArray, slots: IntArray, lo: Array, hi: Array, per_tau: float, times: Array
) -> None:
    """Write, by code, how much of the balance directions closing by place need."""
    for place in closing:
        s, opposite = place >> 1, place & 1
        times[2 * slots[s] + opposite] = (hi[s] if opposite else -lo[s]) * per_tau


@inlined
def basic(T: Array, column: int, opposite: int, x: Array) -> None:
    """Write the basic solution x (m,) of a right-hand side, or of its opposite."""
    sign = -1.0 if opposite else 1.0
    for r in range(len(x)):
        x[r] = sign * T[r, column]


@compiled
def keep(
    T: Array, basis: IntArray, first: int, slots: IntArray, closing: IntArray, columns: IntArray,
    x: Array,
) -> None:  # fmt: skip
    """Keep the basic solutions of directions, which get their codes in the place of places."""
    for k in range(len(closing)):
        s, opposite = closing[k] >> 1, closing[k] & 1
        code, sign = 2 * slots[s] + opposite, -1.0 if opposite else 1.0
        closing[k] = code
        for r in range(len(basis)):
            columns[code, r], x[code, r] = basis[r], sign * T[r, first + s]


@inlined
def join_balance(
    closing: IntArray, columns: IntArray, x: Array, N: int, alone: BoolArray, balance: Array
) -> None:
    """Add to the balance the solutions just kept alone, each pair of opposites once."""
    for code in closing:
        alone[code] = True
        if alone[code ^ 1]:
            for c in (code, code ^ 1):
                for r in range(x.shape[1]):
                    if columns[c, r] < N:
                        balance[columns[c, r]] += max(x[c, r], 0.0)


@inlined
def drop_closed(
    T: Array, d: Array, first: int, S: int, slots: IntArray, ahead: BoolArray, behind: BoolArray
) -> int:
    """Drop right-hand sides closed both ways; the last ones take their places."""
    s = 0
    while s < S:
        if ahead[s] or behind[s]:
            s += 1
            continue
        S -= 1
        slots[s], ahead[s], behind[s] = slots[S], ahead[S], behind[S]
        d[first + s] = d[first + S]
        for r in range(len(T)):
            T[r, first + s] = T[r, first + S]
    return S


@inlined
def choose(costs: Array, S: int, ahead: BoolArray, behind: BoolArray, bounds: Array) -> int:
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
