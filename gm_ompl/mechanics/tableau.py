"""Dual simplex on a dense tableau.

Row r of a tableau belongs to the variable basis[r]. Columns 0..N-1 are real variables, N..N+m-1
artificial ones, fixed at zero (they hold the inverse of the basis), then right-hand sides. ``d``
holds the reduced costs; the duals are y = -d[N:N+m], and -d of a right-hand side l is y . l.
"""

from __future__ import annotations

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

PIVOT = 1e-9
"""Smallest entry accepted as a pivot; columns have norms of order 1."""
FEASIBLE = 1e-10
"""Tolerance on basic variables, relative to the largest of them (at least 1)."""
DANTZIG_STEPS = 60
"""Pivots towards one right-hand side, and one more per column, before falling back to Bland's
rule: it cannot cycle, but it crawls, and many nearly equal columns need many honest pivots."""
MAX_STEPS = 2000
"""Pivots before giving up on a tableau; 50 more per column."""
MORE_STEPS = 50
NEVER = 1 << 40
"""Stands for no limit on pivots where a rough answer would do."""


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
def leaving(x: Array, basis: IntArray, m: int, N: int, bland: bool) -> int:
    """Return the row to leave, -1 for none: the most infeasible, or by Bland's rule the first."""
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
def entering(T: Array, d: Array, N: int, r: int, sign: float, bland: bool) -> int:
    """Return the entering column by the dual ratio test, or -1 where there is none."""
    top, under = 1.0, 0.0
    for j in range(N):
        alpha = -sign * T[r, j]
        # Cross-multiplied: the least ratio without a division.
        if alpha > PIVOT and (d[j] + 1e-12) * under < top * alpha:
            top, under = d[j] + 1e-12, alpha
    best, column = 0.0, -1
    for j in range(N):
        alpha = -sign * T[r, j]
        if alpha > PIVOT and d[j] * under <= top * alpha and alpha > best:
            best, column = alpha, j
            if bland:
                break
    return column


@compiled
def feasible(
    T: Array, d: Array, basis: IntArray, m: int, N: int, W: int, b: Array, x: Array
) -> int:
    """Dual simplex for the one right-hand side ``b`` (m,), from a dual feasible tableau.

    Returns:
        1 where ``x`` (m,) is the optimal basic solution, 0 where there is none, -1 in trouble.
    """
    for step in range(MAX_STEPS + MORE_STEPS * N):
        for r in range(m):
            x[r] = 0.0
            for j in range(m):
                x[r] += T[r, N + j] * b[j]
        bland = step > DANTZIG_STEPS * (1 + m // 12) + N
        r = leaving(x, basis, m, N, bland)
        if r < 0:
            return 1
        c = entering(T, d, N, r, 1.0 if x[r] < 0.0 else -1.0, bland)
        if c < 0:
            return 0
        pivot(T, d, basis, m, W, r, c)
    return -1
