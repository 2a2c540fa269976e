"""Problem (6) with force-controlled fingers, stated for a few directions at once.

Cutting planes over f_com can creep where only a thin range of f_com balances the load at all. This
is the remedy: the program of several directions together, coupled by f_com, in the tau form

    min tau  subject to  tau q + A k_i = l_i  for the directions i at hand,
    per finger sum_k of k_i = phi (force), <= f_max tau (position),  phi <= f_max tau,

with phi = f_com tau. Directions join as they turn out to be violated; each round is exact.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.tableau import feasible

MAX_BLOCKS = 24
"""Directions coupled at most; a vertex of the program is fixed by 1 + n of them."""


@compiled
def _fill(program: Program, force: BoolArray, count: int, scale: float, T: Array) -> None:
    """Write the program's columns: tau, phi and its slack per finger, then block by block."""
    env, q, tips, f_max, _ = program
    e, n, s = len(env), len(tips), tips.shape[1]
    block, height = e + n * s + n, 6 + n
    for i in range(n):
        row = count * height + i
        if force[i]:
            T[row, 1 + i], T[row, 1 + n + i], T[row, 0] = 1.0, 1.0, -f_max[i] / scale
    for b in range(count):
        row, column = b * height, 1 + 2 * n + b * block
        for t in range(6):
            T[row + t, 0] = q[t] / scale
            for j in range(e):
                T[row + t, column + j] = env[j, t]
        for i in range(n):
            for k in range(s):
                for t in range(6):
                    T[row + t, column + e + i * s + k] = tips[i, k, t]
                T[row + 6 + i, column + e + i * s + k] = 1.0
            if force[i]:
                T[row + 6 + i, 1 + i] = -1.0
            else:
                T[row + 6 + i, 0] = -f_max[i] / scale
                T[row + 6 + i, column + e + n * s + i] = 1.0


@compiled
def joint_margin(
    program: Program, force: BoolArray, chosen: IntArray, tolerance: float, f: Array, Y: Array
) -> tuple[bool, float]:
    """Return (whether solved, z) for some chosen directions together; f (n,) gets f_com.

    z = 0 where the directions cannot all be resisted under one f_com. Y (a row for each) gets the
    wrenches whose cuts, added up, bound z to that. ``tolerance`` is that of ``feasible``.
    """
    env, _, tips, f_max, L = program
    count, n, s = len(chosen), len(tips), tips.shape[1]
    m = count * (6 + n) + n
    N = 1 + 2 * n + count * (len(env) + n * s + n)
    T, d = np.zeros((m, N + m)), np.zeros(N + m)
    basis, b, x = np.empty(m, dtype=np.int64), np.zeros(m), np.empty(m)
    scale = 1.0
    for i in range(n):
        scale = max(scale, f_max[i])
    _fill(program, force, count, scale, T)
    d[0] = 1.0 / scale
    for r in range(m):
        T[r, N + r] = 1.0
        basis[r] = N + r
    for i in range(count):
        for t in range(6):
            b[i * (6 + n) + t] = L[chosen[i], t]
    y = np.empty(m)
    end = feasible(T, d, basis, b, tolerance, x, y)
    for i in range(count):
        for t in range(6):
            Y[i, t] = y[i * (6 + n) + t]
    tau, phi = 0.0, np.zeros(n)
    for r in range(m):
        if basis[r] == 0:
            tau = x[r] / scale
        elif basis[r] <= n:
            phi[basis[r] - 1] = x[r]
    if end <= 0 or tau <= 1e-13:
        return end == 0, 0.0
    for i in range(n):
        f[i] = min(max(phi[i] / tau, 0.0), f_max[i]) if force[i] else f_max[i]
    return True, 1.0 / tau
