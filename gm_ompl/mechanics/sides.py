"""The right-hand sides of all 76 directions on one tableau.

They are +e_1..+e_6 and the corners with + in the first coordinate: opposite directions have
opposite basic solutions. A direction is coded 2 j for side j, 2 j + 1 for its opposite. Column 0 of
a tableau is tau.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.tableau import pivot

SIDES = 38
"""Right-hand sides in a tableau: one for each pair of opposite directions."""


@compiled
def width(m: int, N: int) -> int:
    """Return how long a tableau's rows are: rounded up, so that they begin where vectors do."""
    return (N + m + SIDES + 7) // 8 * 8


@compiled
def number(code: int) -> int:
    """Return the number 0..75 of a coded direction."""
    j = code // 2
    if code % 2:
        return 2 * j + 1 if j < 6 else 81 - j
    return 2 * j if j < 6 else 6 + j


@compiled
def fill_in(raw: Array, cost: float, T: Array, d: Array, basis: IntArray) -> None:
    """Fill the tableau from the raw columns (m, N) with the all-artificial basis, sides aside."""
    m, N = raw.shape
    for i in range(m):
        for j in range(N):
            T[i, j] = raw[i, j]
        for j in range(m):
            T[i, N + j] = 0.0
        T[i, N + i] = 1.0
        basis[i] = N + i
    for j in range(N + m):
        d[j] = 0.0
    d[0] = cost


@compiled
def start(raw: Array, cost: float, L: Array, T: Array, d: Array, basis: IntArray) -> None:
    """Fill the tableau as ``fill_in`` does, with all right-hand sides."""
    fill_in(raw, cost, T, d, basis)
    raise_sides(L, T, d, len(raw), raw.shape[1])


@compiled
def raise_sides(L: Array, T: Array, d: Array, m: int, N: int) -> None:
    """Write all right-hand sides, from the inverse of the basis that the tableau holds."""
    first = N + m
    end = first + SIDES
    sides = np.empty((6, SIDES))
    for j in range(SIDES):
        side = L[number(2 * j)]
        for t in range(6):
            sides[t, j] = side[t]
    for i in range(m + 1):
        row = T[i, first:end] if i < m else d[first:end]
        factors = T[i, N : N + 6] if i < m else d[N : N + 6]
        a, b, c = factors[0], factors[1], factors[2]
        e, f, g = factors[3], factors[4], factors[5]
        for j in range(SIDES):
            row[j] = ((a * sides[0, j] + b * sides[1, j]) + (c * sides[2, j] + e * sides[3, j])) + (
                f * sides[4, j] + g * sides[5, j]
            )


@compiled
def move_tau(change: Array, L: Array, T: Array, d: Array, basis: IntArray, m: int, N: int) -> bool:
    """Add ``change`` (m,) to the raw tau column, the basis kept; False where that is not optimal.

    All right-hand sides are written anew.
    """
    for j in range(m):
        if change[j] != 0.0:
            for i in range(m):
                T[i, 0] += change[j] * T[i, N + j]
            d[0] += change[j] * d[N + j]
    for r in range(m):
        if basis[r] == 0:
            if abs(T[r, 0]) < 1e-6:
                return False
            pivot(T, d, basis, m, N + m, r, 0 * r)
    for j in range(N):
        if d[j] < 0.0:
            if d[j] < -1e-10:
                return False
            d[j] = 0.0
    raise_sides(L, T, d, m, N)
    return True


@compiled
def refactor(raw: Array, cost: float, L: Array, T: Array, d: Array, basis: IntArray) -> None:
    """Fill the tableau anew at its basis: rounding adds up with every pivot, this forgets it.

    A basic column enters in the free row where it is largest. One that has nothing left there
    (the basis was singular but for rounding) stays out, and an artificial variable in its row.
    """
    m, N = raw.shape
    columns, free = basis.copy(), np.ones(m, dtype=np.bool_)
    start(raw, cost, L, T, d, basis)
    for c in columns:
        largest, row = 1e-9, -1
        for r in range(m):
            if free[r] and abs(T[r, c]) > largest:
                largest, row = abs(T[r, c]), r
        if row >= 0:
            free[row] = False
            pivot(T, d, basis, m, N + m + SIDES, row, c)


@compiled
def dual_error(raw: Array, cost: float, tau: float, y: Array) -> float:
    """Return how far y (m,) is from proving a tau (inf: any), relative to its largest entry.

    It does where y . a <= 0 for all columns but tau's, y . a <= cost for that one (0 for any tau).
    What a fingertip's column misses counts as often as the fingertip may press.
    """
    m, N = raw.shape
    size, worst = 1e-300, 0.0
    dots, weights = np.zeros(N), np.ones(N)
    for t in range(m):
        row, factor, cap = raw[t], y[t], -raw[t, 0] / cost
        size = max(size, abs(factor))
        for j in range(N):
            dots[j] += row[j] * factor
        if t >= 6 and cap > 1.0:
            for j in range(1, N):
                weights[j] = max(weights[j], row[j] * cap)
    if tau < np.inf:
        dots[0] -= cost
    for j in range(N):
        error = weights[j] * dots[j]
        worst = error if error > worst else worst
    return worst / size
