"""Dual simplex on a dense tableau.

Row r of a tableau belongs to the variable basis[r]. Columns 0..N-1 are real variables, N..N+m-1
artificial ones, fixed at zero (they hold the inverse of the basis), then right-hand sides. ``d``
holds the reduced costs; the duals are y = -d[N:N+m], and -d of a right-hand side l is y . l.

Loops run over views of rows: an index that may be negative, as r or N + j might be for all the
compiler knows, keeps a loop from being done several numbers at a time.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled

PIVOT = 1e-9
"""Smallest entry accepted as a pivot; columns have norms of order 1. And"""
FINEST = 1e-12
"""the smallest where such entries matter, as they do to fingers that may press hard."""
FEASIBLE = 1e-10
"""Tolerance on basic variables, relative to the largest of them (at least 1), and"""
CAREFUL = 1e-14
"""the same where some are so much larger than others that this overlooks what matters."""
DANTZIG_STEPS = 60
"""Pivots towards one right-hand side, and one more per column, before falling back to Bland's
rule: it cannot cycle, but it crawls, and many nearly equal columns need many honest pivots."""
MAX_STEPS = 2000
"""Pivots before giving up on a tableau; 50 more per column."""
MORE_STEPS = 50
SMALL = 16
"""Rows up to which a pivot does not look for rows that it could leave out."""
NEVER = 1 << 40
"""Stands for no limit on pivots where a rough answer would do."""


@compiled
def pivot(T: Array, d: Array, basis: IntArray, m: int, W: int, r: int, c: int) -> None:
    """Bring column c into the basis in row r."""
    chosen = T[r, :W]
    scale = 1.0 / chosen[c]
    for j in range(W):
        chosen[j] *= scale
    chosen[c] = 1.0
    sparse = m > SMALL
    for i in range(m):
        row = T[i, :W]
        if i == r or (sparse and row[c] == 0.0):
            continue
        factor = row[c]
        for j in range(W):
            row[j] -= factor * chosen[j]
        row[c] = 0.0
    costs, factor = d[:W], d[c]
    for j in range(W):
        costs[j] -= factor * chosen[j]
    costs[c] = 0.0
    basis[r] = c


@compiled
def leaving(x: Array, basis: IntArray, m: int, N: int, tolerance: float, bland: bool) -> int:
    """Return the row to leave, -1 for none: the most infeasible, or by Bland's rule the first.

    ``tolerance`` is relative to the largest entry of x (at least 1).
    """
    size = 1.0
    for r in range(m):
        size = max(size, abs(x[r]))
    least = tolerance * size
    best, row = least, -1
    for r in range(m):
        excess = abs(x[r]) if basis[r] >= N else -x[r]
        better = excess > best
        if bland:
            better = excess > least and (row < 0 or basis[r] < basis[row])
        best = excess if better else best
        row = r if better else row
    return row


@compiled
def entering(
    T: Array, d: Array, r: int, sign: float, least: float, bland: bool, room: Array
) -> int:
    """Return the entering column by the dual ratio test, or -1 where there is none.

    No entry up to ``least`` is accepted as a pivot. ``room`` (N,) is written to. What a loop
    decides per column is written down and compared in a loop of its own: the first has no branches
    then.
    """
    N = len(room)
    row, costs, nearest = T[r, :N], d[:N], np.inf
    for j in range(N):
        alpha = -sign * row[j]
        ratio = (costs[j] + 1e-12) / alpha
        room[j] = ratio if alpha > least else np.inf
    for j in range(N):
        nearest = room[j] if room[j] < nearest else nearest
    for j in range(N):
        alpha = -sign * row[j]
        room[j] = alpha if costs[j] <= nearest * alpha else 0.0
    best, column = least, -1
    for j in range(N):
        if room[j] > best:
            best, column = room[j], j
            if bland:
                break
    return column


@compiled
def feasible(
    T: Array, d: Array, basis: IntArray, b: Array, tolerance: float, x: Array, y: Array
) -> int:
    """Dual simplex for the one right-hand side ``b`` (m,), from a dual feasible tableau.

    ``T`` (m, N + m) has no right-hand sides. ``tolerance`` on basic variables is relative to the
    largest of them (at least 1).

    Returns:
        1 where ``x`` (m,) is the optimal basic solution, and ``y`` (up to m,) its duals; 0 where
        there is none, and ``y`` the ray with y . b > 0 that proves it; -1 in trouble.
    """
    m, W = T.shape
    N = W - m
    inverse, room = T[:, N : N + m], np.empty(N)
    for step in range(MAX_STEPS + MORE_STEPS * N):
        for r in range(m):
            x[r] = 0.0
            for j in range(m):
                x[r] += inverse[r, j] * b[j]
        bland = step > DANTZIG_STEPS * (1 + m // 12) + N
        r = leaving(x, basis, m, N, tolerance, bland)
        if r < 0:
            for j in range(len(y)):
                y[j] = -d[N + j]
            return 1
        sign = 1.0 if x[r] < 0.0 else -1.0
        least = PIVOT if tolerance >= FEASIBLE else FINEST
        c = entering(T, d, r, sign, least, bland, room)
        if c < 0:
            for j in range(len(y)):
                y[j] = -sign * inverse[r, j]
            return 0
        pivot(T, d, basis, m, W, r, c)
    return -1
