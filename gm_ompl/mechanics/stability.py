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
from gm_ompl.mechanics.certificate import (
    CLOSE,
    into_polar,
    proven,
    support,
    unattained,
    upper_bound,
)
from gm_ompl.mechanics.resistance import (
    Resistance,
    lower_bound,
    new_resistance,
    refine,
    refine_duals,
)
from gm_ompl.mechanics.sides import dual_error, move_tau, number, refactor, start, width
from gm_ompl.mechanics.simplex import (
    EXCEEDED,
    INFEASIBLE,
    NO_TAU,
    SOLVED,
    TROUBLE,
    search_directions,
)
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, FINEST, NEVER, PIVOT

A_LOOK = 24
"""Pivots spent on bounding z where its exact value is not wanted."""
PIVOTS = (PIVOT, FINEST, 1e-6, 1e-6, 1e-5, 1e-5)
"""The smallest pivots of the attempts at a pass, made until one proves its answer: as the tableau
stands, factored anew; twice more from the beginning, the last by Bland's rule. Where columns depend
on each other almost, small pivots let rounding grow, and what they would gain is smaller still."""
GOOD = 1e-9
"""A first attempt is taken as it is if it is as close as this; a later one, if it is CLOSE."""
BALANCED = 1e-9
"""Forces that balance the load up to this (over force_scale) are in equilibrium (convention)."""

REACHED, BELOW, UNBOUNDED, FAILED = 0, 1, 2, 3
"""z found; z proven below the threshold; z = +inf; numerical trouble."""


class Tableau(NamedTuple):
    """A tau program and its tableau.

    Attributes:
        raw: (m, N), columns.
        T: (m, W), the tableau.
        d: (W,), reduced costs.
        basis: (m,).
        found: what resists each direction.
    """

    raw: Array
    T: Array
    d: Array
    basis: IntArray
    found: Resistance


@compiled
def new_tableau(n: int, e: int, s: int) -> Tableau:
    """Return room for the tau program of n fingers of s columns, e columns of the environment."""
    m, N = 6 + n, 1 + e + n * s + n
    W = width(m, N)
    return Tableau(
        np.empty((m, N)), np.empty((m, W)), np.empty(W), np.empty(m, dtype=np.int64),
        new_resistance(m),
    )  # fmt: skip


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
    warm: bool, limit: float, enough: float, patience: int, y: Array, found: Resistance,
) -> tuple[int, int, float, float]:  # fmt: skip
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
        found: output, likewise.

    Returns:
        As ``search_directions``, and where all directions are resisted the proven z, at least
        1 / max(tau, enough) but for CLOSE; else, or where a rough answer would do, 0.
    """
    m, N = raw.shape
    if not warm or not move_tau(change, L, T, d, basis, m, N):
        start(raw, cost, L, T, d, basis, m, N)
    direction, tau = -1, 0.0
    for attempt in range(len(PIVOTS)):
        if attempt % 2:
            refactor(raw, cost, L, T, d, basis, m, N)
        elif attempt:
            start(raw, cost, L, T, d, basis, m, N)
        end, code, tau = search_directions(
            T, d, basis, m, N, cost, limit, enough, patience, PIVOTS[attempt],
            CAREFUL if attempt else FEASIBLE, attempt > 3, y, found,
        )  # fmt: skip
        if end == TROUBLE:
            continue
        direction = number(code)
        if attempt and end != INFEASIBLE:
            refine_duals(raw, cost, found.basis[code], y)
        if attempt and end == SOLVED:
            refine(raw, L, found)
        accepted, v = GOOD if attempt == 0 else CLOSE, 0.0
        if end == INFEASIBLE:
            accepted *= 1e-2
        good = (end == SOLVED and enough > 0.0) or dual_error(raw, cost, tau, y) <= accepted
        if end == SOLVED and patience == NEVER:
            v = lower_bound(raw, cost, L, found)
            most = max(tau, enough)
            good = good and (v * most >= 1.0 - accepted or (attempt > 0 and proven(v, 1.0 / most)))
        if good:
            return end, direction, tau, v
    return TROUBLE, direction, tau, 0.0


@inlined
def position_margin(
    env: Array, q: Array, tips: Array, f_max: Array, L: Array, below: float, exact: bool,
    tableau: Tableau, w: Array, margin: float, y: Array,
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
        w: (6,), a wrench that separates the environment's columns, with its
        margin: see ``into_polar``.
        y: output (6,): the wrench of the cut that proves the bound on z, in the polar of the
            environment's cone; zero where it is not, so that it bounds nothing.

    Returns:
        How it ended, z (-inf: no equilibrium) or an upper bound on it, the direction.
    """
    raw, n = tableau.raw, len(tips)
    prices, nobody = np.zeros(6 + n), np.zeros(n, dtype=np.bool_)
    cost = fill(env, q, tips, f_max, nobody, f_max, raw)
    limit = 1.0 / below if below > 0.0 else np.inf
    enough = 0.0 if exact or below <= 0.0 else limit
    end, direction, tau, v = run_pass(
        raw, cost, L, tableau.T, tableau.d, tableau.basis, prices, False, limit, enough,
        NEVER if exact else A_LOOK, prices, tableau.found,
    )  # fmt: skip
    for t in range(6):
        y[t] = prices[t]
    if not into_polar(env, w, margin, y):
        for t in range(6):
            y[t] = 0.0
    U = upper_bound(q, tips, f_max, nobody, L, y.reshape(1, 6))
    if end == TROUBLE:
        return FAILED, U, direction
    if below <= 0.0 and unattained(q, tips, f_max, nobody, L, y) > BALANCED:
        return REACHED, -np.inf, direction
    if below > max(U, 0.0):
        return BELOW, max(U, 0.0), direction
    if not exact or end == EXCEEDED:
        return REACHED, U, direction
    if end == INFEASIBLE:
        return REACHED if proven(0.0, max(U, 0.0)) else FAILED, 0.0, direction
    if tau <= NO_TAU:
        return UNBOUNDED, np.inf, direction
    # The proof may know better: the tableau's own tau carries the rounding of all its pivots.
    return REACHED if proven(v, U) else FAILED, min(max(1.0 / tau, v), U), direction
