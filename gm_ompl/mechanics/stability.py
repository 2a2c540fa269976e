"""Problem (6), compiled: its columns, and z where no finger is force-controlled.

In the dual, each direction and each trial f_com yields a wrench y (a member of the polar of the
environment's cone) and with it the inequality, valid for every f_com and every placement,

    z h_P(y) <= q . y + sum_pos f_max max(0, sigma) + sum_force f_com sigma,
    sigma = max_k b_k . y over the finger's unit-normal-force columns, h_P(y) = max_i l_i . y.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.sides import SIDES, drift, move_tau, refactor, start
from gm_ompl.mechanics.simplex import (
    EXCEEDED,
    INFEASIBLE,
    NO_TAU,
    TROUBLE,
    search_directions,
)
from gm_ompl.mechanics.tableau import NEVER, feasible

A_LOOK = 24
"""Pivots spent on bounding z where its exact value is not wanted."""
DRIFT = 1e-9
"""Error of a basis' inverse beyond which its tableau is not trusted."""
ATTEMPTS = 4
"""Passes over the directions until a tableau can be trusted, the last by Bland's rule."""

REACHED, BELOW, UNBOUNDED, FAILED = 0, 1, 2, 3
"""z found; z proven below the threshold; z = +inf; numerical trouble."""


class Tableau(NamedTuple):
    """A tau program and its tableau.

    Attributes:
        raw: (m, N), columns.
        T: (m, W), the tableau.
        d: (W,), reduced costs.
        basis: (m,).
    """

    raw: Array
    T: Array
    d: Array
    basis: IntArray


@compiled
def new_tableau(n: int, e: int, s: int) -> Tableau:
    """Return room for the tau program of n fingers of s columns, e columns of the environment."""
    m, N = 6 + n, 1 + e + n * s + n
    W = N + m + SIDES
    return Tableau(np.empty((m, N)), np.empty((m, W)), np.empty(W), np.empty(m, dtype=np.int64))


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
def cut(q: Array, tips: Array, f_max: Array, force: BoolArray, y: Array, slopes: Array) -> float:
    """Return the constant c of the cut h z <= c + slopes . f that y gives (h = l_i . y).

    ``slopes`` gets one entry per force-controlled finger.
    """
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
def run_pass(
    raw: Array, cost: float, L: Array, T: Array, d: Array, basis: IntArray, change: Array,
    warm: bool, limit: float, enough: float, patience: int, y: Array,
) -> tuple[int, int, float]:  # fmt: skip
    """Search the directions for raw columns (m, N); see ``search_directions``.

    Args:
        raw: the tau program's columns.
        cost: of the tau column.
        L: (76, 6), the directions.
        T: the tableau.
        d: its reduced costs.
        basis: (m,), its basis.
        change: (m,), what was added to the tau column since the last pass.
        warm: whether the tableau is that of the last pass; else it is filled.
        limit: see ``search_directions``.
        enough: likewise.
        patience: likewise.
        y: output, likewise.
    """
    m, N = raw.shape
    if not warm or not move_tau(change, L, T, d, basis, m, N):
        start(raw, cost, L, T, d, basis, m, N)
    for attempt in range(ATTEMPTS):
        bland = attempt == ATTEMPTS - 1
        end, direction, tau = search_directions(
            T, d, basis, m, N, cost, limit, enough, patience, bland, y
        )
        if bland or (end != TROUBLE and drift(raw, T, basis, m, N) < DRIFT):
            break
        # Rounding has spoilt the tableau: again from this basis, factored anew. Where that does
        # not help, or the pivots went round in circles: from the beginning, with care.
        if end != TROUBLE and attempt < ATTEMPTS - 2:
            refactor(raw, cost, L, T, d, basis, m, N)
            least = 0.0
            for j in range(N):
                least = min(least, d[j])
                d[j] = max(d[j], 0.0)
            if least >= -DRIFT:
                continue
        start(raw, cost, L, T, d, basis, m, N)
    return end, direction, tau


@inlined
def position_margin(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float, exact: bool,
    tableau: Tableau, y: Array,
) -> tuple[int, float, int]:  # fmt: skip
    """z where nobody is force-controlled: one pass over the directions.

    Args:
        env: (e, 6), the environment's columns.
        q: (6,), the load.
        tips: (n, s, 6), the fingers' columns for unit normal force.
        f_max: (n,), over force_scale.
        L: (76, 6), the directions.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        exact: whether z is wanted where it is at least ``below``; else a few pivots are made
            in search of a proof that it is smaller, and an upper bound will do.
        tableau: output, as the pass has left it.
        y: output (6,): the wrench of the cut that proves the bound on z.

    Returns:
        How it ended, z or an upper bound on it, the direction.
    """
    raw, prices = tableau.raw, np.empty(6 + len(tips))
    cost = fill(env, q, tips, f_max, np.zeros(len(tips), dtype=np.bool_), f_max, raw)
    limit = 1.0 / below if below > 0.0 else np.inf
    enough = 0.0 if exact or below <= 0.0 else limit
    end, direction, tau = run_pass(
        raw, cost, L, tableau.T, tableau.d, tableau.basis, prices, False, limit, enough,
        NEVER if exact else A_LOOK, prices,
    )  # fmt: skip
    for t in range(6):
        y[t] = prices[t]
    if end == TROUBLE:
        return FAILED, 0.0, direction
    if end == INFEASIBLE:
        return BELOW if below > 0.0 else REACHED, 0.0, direction
    if end == EXCEEDED and tau > limit:
        return BELOW, 1.0 / tau, direction
    if tau <= NO_TAU:
        return UNBOUNDED, np.inf, direction
    return REACHED, 1.0 / tau, direction


@compiled
def equilibrium(env: Array, q: Array, tips: Array, f_max: Array, L: Array, f: Array) -> bool:
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
    for i in range(n):
        f[i] = 0.0
    for r in range(m):
        if 1 + e <= basis[r] < 1 + e + n * s:
            f[(basis[r] - 1 - e) // s] += max(x[r], 0.0)
    for i in range(n):
        f[i] = min(f[i], f_max[i])
    return True
