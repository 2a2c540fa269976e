"""Problem (6), compiled: z for given modes, f_com by cutting planes.

In the dual, each direction and each trial f_com yields a wrench y (a member of the polar of the
environment's cone) and with it the inequality, valid for every f_com and every placement,

    z h_P(y) <= q . y + sum_pos f_max max(0, sigma) + sum_force f_com sigma,
    sigma = max_k b_k . y over the finger's unit-normal-force columns, h_P(y) = max_i l_i . y.

Infeasible directions give such a cut as well (with a right-hand side <= 0 at the trial point), so
thin ranges of feasible f_com need no special care.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.mechanics.blocks import MAX_BLOCKS, joint_margin
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.master import best_command
from gm_ompl.mechanics.simplex import (
    EXCEEDED,
    INFEASIBLE,
    SIDES,
    SOLVED,
    TROUBLE,
    feasible,
    restart,
    start,
    worst_direction,
)

MAX_CUTS = 40
"""Cuts over f_com before the directions met are put into one program."""
GAP = 1e-10
"""Cutting stops where the bound is within this of z, relative to max(z, 1e-3)."""
ZERO = 1e-10
"""z up to this (over force_scale) is no margin at all."""

REACHED, BELOW, UNBOUNDED, FAILED = 0, 1, 2, 3
"""z found; z proven below the threshold; z = +inf; numerical trouble."""


@compiled
def fill(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, f: Array, raw: Array
) -> float:
    """Write the raw columns of the tau program; return the cost of the scaled tau column.

    Columns: tau, environment, s per finger, one slack per finger (zero under force control).
    """
    e, n, s = len(env), len(tips), tips.shape[1]
    raw[:, :] = 0.0
    scale = 1.0
    for i in range(n):
        scale = max(scale, f_max[i])
    for t in range(6):
        raw[t, 0] = q[t] / scale
        for j in range(e):
            raw[t, 1 + j] = env[j, t]
    for i in range(n):
        raw[6 + i, 0] = -(f[i] if force[i] else f_max[i]) / scale
        for k in range(s):
            for t in range(6):
                raw[t, 1 + e + i * s + k] = tips[i, k, t]
            raw[6 + i, 1 + e + i * s + k] = 1.0
        if not force[i]:
            raw[6 + i, 1 + e + n * s + i] = 1.0
    return 1.0 / scale


@compiled
def support(tips: Array, i: int, y: Array) -> float:
    """Return sigma, the largest b_k . y of finger i's unit-normal-force columns."""
    best = -np.inf
    for k in range(tips.shape[1]):
        dot = 0.0
        for t in range(6):
            dot += tips[i, k, t] * y[t]
        best = max(best, dot)
    return best


@compiled
def cut(
    q: Array, tips: Array, f_max: Array, force: BoolArray, y: Array, slopes: Array
) -> float:
    """Return the constant c of the cut h z <= c + slopes . f that y gives (h = l_i . y)."""
    c, j = 0.0, 0
    for t in range(6):
        c += q[t] * y[t]
    for i in range(len(tips)):
        sigma = support(tips, i, y)
        if force[i]:
            slopes[j] = sigma
            j += 1
        else:
            c += f_max[i] * max(0.0, sigma)
    return c


@compiled
def _position_margin(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, below: float,
    y: Array,
) -> tuple[int, float, int]:  # fmt: skip
    """z where nobody is force-controlled: one pass over the directions."""
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, duals = np.empty(m, dtype=np.int64), np.empty(m)
    cost = fill(env, q, tips, f_max, force, f_max, raw)
    start(raw, cost, L, T, d, basis, m, N)
    limit = 1.0 / below if below > 0.0 else np.inf
    end, direction, tau = worst_direction(T, d, basis, m, N, cost, limit, duals)
    y[:] = duals[:6]
    if end == TROUBLE:
        return FAILED, 0.0, direction
    if end == INFEASIBLE:
        return BELOW if below > 0.0 else REACHED, 0.0, direction
    if end == EXCEEDED:
        return BELOW, 1.0 / tau, direction
    if tau <= 1e-13:
        return UNBOUNDED, np.inf, direction
    return REACHED, 1.0 / tau, direction


@compiled
def _joint(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, below: float,
    met: IntArray, f: Array,
) -> tuple[int, float, int]:  # fmt: skip
    """z where cutting creeps: the last directions met in one program, more as they are violated."""
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, y = np.empty(m, dtype=np.int64), np.empty(m)
    chosen, count = np.empty(MAX_BLOCKS, dtype=np.int64), 0
    for K in range(len(met) - 1, -1, -1):
        if count < 1 + n and not (chosen[:count] == met[K]).any():
            chosen[count] = met[K]
            count += 1
    while True:
        solved, z = joint_margin(env, q, tips, f_max, force, L, chosen, count, f)
        if not solved:
            return FAILED, 0.0, -1
        if below > 0.0 and z < below:
            return BELOW, z, chosen[0]
        if z <= ZERO:
            return REACHED, 0.0, chosen[0]
        cost = fill(env, q, tips, f_max, force, f, raw)
        start(raw, cost, L, T, d, basis, m, N)
        limit = (1.0 + 1e-9) / z
        end, direction, _ = worst_direction(T, d, basis, m, N, cost, limit, y)
        if end == SOLVED:
            return REACHED, z, direction
        if end == TROUBLE or count == MAX_BLOCKS or (chosen[:count] == direction).any():
            return FAILED, 0.0, direction
        chosen[count] = direction
        count += 1


@compiled
def _force_margin(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, below: float,
    f: Array,
) -> tuple[int, float, int]:  # fmt: skip
    """z where some fingers are force-controlled: Kelley's cutting planes over f_com."""
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N, nf = 6 + n, 1 + e + n * s + n, int(force.sum())
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, old, y = np.empty(m, dtype=np.int64), np.empty(m, dtype=np.int64), np.empty(m)
    met = np.empty(MAX_CUTS, dtype=np.int64)
    h, c, slopes = np.empty(MAX_CUTS), np.empty(MAX_CUTS), np.empty((MAX_CUTS, nf))
    limits, trial = np.empty(nf), np.empty(nf)
    j = 0
    for i in range(n):
        if force[i]:
            limits[j], trial[j] = f_max[i], 0.5 * f_max[i]
            j += 1
    command = f_max.copy()
    bound, best, best_direction, warm = np.inf, -np.inf, -1, False
    for K in range(MAX_CUTS):
        j = 0
        for i in range(n):
            if force[i]:
                command[i] = trial[j]
                j += 1
        cost = fill(env, q, tips, f_max, force, command, raw)
        old[:] = basis
        if not warm or not restart(raw, cost, L, T, d, basis, old, m, N):
            start(raw, cost, L, T, d, basis, m, N)
        aim = bound - GAP * max(bound, 1e-3)
        limit = 1.0 / aim if np.isfinite(aim) and aim > 0.0 else np.inf
        end, direction, tau = worst_direction(T, d, basis, m, N, cost, limit, y)
        if end == TROUBLE:
            return FAILED, 0.0, direction
        warm = True
        met[K] = direction
        size = np.abs(y[:6]).max()
        if size <= 1e-13:
            return UNBOUNDED, np.inf, direction
        h[K] = 0.0
        for t in range(6):
            y[t] /= size
            h[K] += L[direction, t] * y[t]
        c[K] = cut(q, tips, f_max, force, y, slopes[K])
        z = c[K]
        for j in range(nf):
            z += slopes[K, j] * trial[j]
        z /= h[K]
        if end != EXCEEDED and end != INFEASIBLE and z > best:
            best, best_direction = z, direction
            f[:] = command
        bound = min(bound, best_command(h, c, slopes, K + 1, limits, nf, trial))
        if below > 0.0 and bound < below:
            return BELOW, bound, direction
        if bound <= ZERO:
            return REACHED, 0.0, direction
        if best >= bound - GAP * max(bound, 1e-3):
            return REACHED, best, best_direction
    return _joint(env, q, tips, f_max, force, L, below, met, f)


@compiled
def margin(
    env: Array, q: Array, tips: Array, f_max: Array, force: BoolArray, L: Array, below: float,
    f: Array, y: Array,
) -> tuple[int, float, int]:  # fmt: skip
    """z of Problem (6) for given modes, the best f_com, and the direction that limits z.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale, as all forces here.
        force: (n,), who is force-controlled.
        L: (76, 6), the directions.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        f: output (n,): f_com for the force-controlled fingers.
        y: output (6,): where nobody is force-controlled, the wrench of the cut that proves z.

    Returns:
        How it ended, z (or its bound, never below 0), the direction.
    """
    if force.any():
        end, z, direction = _force_margin(env, q, tips, f_max, force, L, below, f)
    else:
        end, z, direction = _position_margin(env, q, tips, f_max, force, L, below, y)
    return end, max(z, 0.0), direction


@compiled
def equilibrium(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, f: Array
) -> bool:
    """Whether any forces within the limits balance the load; ``f`` (n,) gets the normal forces.

    The choice of modes does not matter: some f_com gives whatever a position-controlled finger
    would. It is the tau program with tau = 1 and l = 0.
    """
    e, n, s = len(env), len(tips), tips.shape[1]
    m, N = 6 + n, 1 + e + n * s + n
    raw, T, d = np.empty((m, N)), np.empty((m, N + m + SIDES)), np.empty(N + m + SIDES)
    basis, b, x = np.empty(m, dtype=np.int64), np.empty(m), np.empty(m)
    fill(env, q, tips, f_max, np.zeros(n, dtype=np.bool_), f_max, raw)
    raw[:, 0] = 0.0
    for t in range(6):
        b[t] = -q[t]
    for i in range(n):
        b[6 + i] = f_max[i]
    start(raw, 0.0, L, T, d, basis, m, N)
    if feasible(T, d, basis, m, N, N + m, b, x) != 1:
        return False
    f[:] = 0.0
    for r in range(m):
        if 1 + e <= basis[r] < 1 + e + n * s:
            f[(basis[r] - 1 - e) // s] += max(x[r], 0.0)
    for i in range(n):
        f[i] = min(f[i], f_max[i])
    return True
