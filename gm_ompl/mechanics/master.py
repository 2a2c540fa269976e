"""The small program over f_com: maximise z under cuts h_j z <= c_j + s_j . f, 0 <= f <= f_max."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined

_TOLERANCE = 1e-12
_DANTZIG_STEPS = 200
"""Pivots before falling back to Bland's rule, which cannot cycle."""
_MAX_STEPS = 2000


@inlined
def _columns(h: Array, c: Array, s: Array, f_max: Array, T: Array, cost: Array) -> None:
    """Fill in the dual program: min c.mu + f_max.nu, h.mu = 1, nu_f - slack_f = sum_j s_jf mu_j."""
    K, n = len(h), len(f_max)
    for j in range(K):
        T[0, j] = h[j]
        cost[j] = c[j]
        for f in range(n):
            T[1 + f, j] = -s[j, f]
    for f in range(n):
        T[1 + f, K + f] = 1.0
        cost[K + f] = f_max[f]
        T[1 + f, K + n + f] = -1.0
    T[0, K + 2 * n] = 1.0


@compiled
def _bring_in(T: Array, cost: Array, m: int, W: int, r: int, j: int) -> None:
    """Pivot column j into row r of the tableau and of the reduced costs."""
    scale = 1.0 / T[r, j]
    for t in range(W):
        T[r, t] *= scale
    for i in range(m):
        factor = T[i, j]
        if i != r and factor != 0.0:
            for t in range(W):
                T[i, t] -= factor * T[r, t]
    factor = cost[j]
    for t in range(W):
        cost[t] -= factor * T[r, t]


@inlined
def _leaving(T: Array, j: int) -> int:
    """Return the row to leave where column j enters, -1 for none."""
    m, N = len(T), T.shape[1] - 1
    ratio, r = np.inf, -1
    for i in range(m):
        if T[i, j] > 1e-12 and T[i, N] / T[i, j] < ratio:
            ratio, r = T[i, N] / T[i, j], i
    return r


@inlined
def _entering(cost: Array, bland: bool) -> int:
    """Return the column to enter, -1 for none: the least reduced cost, or the first below 0."""
    best, j = -_TOLERANCE, -1
    for t in range(len(cost) - 1):
        if cost[t] < best:
            best, j = cost[t], t
            if bland:
                break
    return j


@compiled
def best_command(
    h: Array, c: Array, s: Array, f_max: Array, f: Array, which: IntArray, weights: Array
) -> float:
    """Return the largest z under cuts (K,), s (K, n), and write the f (n,) that reaches it.

    Solved by the primal simplex on the dual program, which has only 1 + n rows; f and z are its
    multipliers, read from the reduced costs of nu and its slack. Its variables are the weights of
    the cuts that prove z: ``which`` (1 + n,) gets those cuts, -1 for none, and ``weights`` theirs.
    """
    K, n = len(h), len(f_max)
    m, N = 1 + n, K + 2 * n
    W = N + 1
    room = np.zeros((m + 1, W))
    T, cost = room[:m], room[m]
    _columns(h, c, s, f_max, T, cost)
    first = 0
    for j in range(K):
        if c[j] * h[first] < c[first] * h[j]:
            first = j
    _bring_in(T, cost, m, W, 0, first)
    which[0] = first
    for i in range(n):
        which[1 + i] = K + i if s[first, i] >= 0.0 else K + n + i
        _bring_in(T, cost, m, W, 1 + i, which[1 + i])
    for step in range(_MAX_STEPS):
        j = _entering(cost, step > _DANTZIG_STEPS)
        r = _leaving(T, j) if j >= 0 else -1
        if r < 0:
            break
        _bring_in(T, cost, m, W, r, j)
        which[r] = j
    for i in range(m):
        weights[i] = max(T[i, N], 0.0)
        if which[i] >= K:
            which[i] = -1
    for i in range(n):
        f[i] = min(max(cost[K + n + i], 0.0), f_max[i])
    return -cost[N]
