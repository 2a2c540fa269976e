"""Problem (6), compiled: one pass over its directions, and z where no finger is force-controlled.

In the dual, each direction and each trial f_com yields a wrench y (a member of the polar of the
environment's cone) and with it the inequality, valid for every f_com and every placement,

    z h_P(y) <= q . y + sum_pos f_max max(0, sigma) + sum_force f_com sigma,
    sigma = max_k b_k . y over the finger's unit-normal-force columns, h_P(y) = max_i l_i . y.
"""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.mechanics.certificate import (
    CLOSE,
    into_polar,
    proven,
    support,
    unattained,
    upper_bound,
)
from gm_ompl.mechanics.program import Program, Separation
from gm_ompl.mechanics.resistance import lower_bound, refine, refine_duals
from gm_ompl.mechanics.sides import dual_error, move_tau, number, refactor, start
from gm_ompl.mechanics.simplex import (
    EXCEEDED,
    INFEASIBLE,
    NO_TAU,
    SOLVED,
    TROUBLE,
    Care,
    Target,
    search_directions,
)
from gm_ompl.mechanics.tableau import CAREFUL, FEASIBLE, FINEST, NEVER, PIVOT
from gm_ompl.mechanics.tau import Tableau, fill

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


@compiled
def cut(program: Program, force: BoolArray, y: Array, slopes: Array) -> float:
    """Return the constant c of the cut h z <= c + slopes . f that y gives (h = l_i . y).

    ``slopes`` gets one entry per force-controlled finger.
    """
    _, q, tips, f_max, _ = program
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
    tableau: Tableau, cost: float, L: Array, change: Array, warm: bool, target: Target
) -> tuple[int, int, float, float]:
    """Search the directions for a tableau's raw columns; see ``search_directions``.

    Args:
        tableau: output, with the tau program's columns.
        cost: of the tau column.
        L: (76, 6), the directions.
        change: (m,), what was added to the tau column since the last pass.
        warm: whether the tableau is that of the last pass; else it is filled.
        target: where to stop.

    Returns:
        As ``search_directions``, and where all directions are resisted the proven z, at least
        1 / max(tau, enough) but for CLOSE; else, or where a rough answer would do, 0.
    """
    raw, T, d, basis, y, found = tableau
    if not warm or not move_tau(change, L, T, d, basis, len(raw), raw.shape[1]):
        start(raw, cost, L, T, d, basis)
    direction, tau = -1, 0.0
    for attempt in range(len(PIVOTS)):
        if attempt % 2:
            refactor(raw, cost, L, T, d, basis)
        elif attempt:
            start(raw, cost, L, T, d, basis)
        care = Care(PIVOTS[attempt], CAREFUL if attempt else FEASIBLE, attempt > 3)
        end, code, tau = search_directions(tableau, cost, target, care)
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
        good = (end == SOLVED and target.enough > 0.0) or dual_error(raw, cost, tau, y) <= accepted
        if end == SOLVED and target.patience == NEVER:
            v = lower_bound(raw, cost, L, found)
            most = max(tau, target.enough)
            good = good and (v * most >= 1.0 - accepted or (attempt > 0 and proven(v, 1.0 / most)))
        if good:
            return end, direction, tau, v
    return TROUBLE, direction, tau, 0.0


@inlined
def position_margin(
    program: Program, separation: Separation, below: float, exact: bool, tableau: Tableau, y: Array
) -> tuple[int, float, int]:
    """z where nobody is force-controlled: one pass over the directions.

    Args:
        program: whose z.
        separation: of the environment's columns.
        below: a threshold; where z is proven smaller, stop with an upper bound on z.
        exact: whether z is wanted where it is at least ``below``; else a few pivots are made
            in search of a proof that it is smaller, and an upper bound will do.
        tableau: output, as the pass has left it.
        y: output (6,): the wrench of the cut that proves the bound on z, in the polar of the
            environment's cone; zero where it is not, so that it bounds nothing.

    Returns:
        How it ended, z (-inf: no equilibrium) or an upper bound on it, the direction.
    """
    (env, _, tips, f_max, L), (raw, _, _, _, prices, _) = program, tableau
    nobody = np.zeros(len(tips), dtype=np.bool_)
    cost = fill(program, nobody, f_max, raw)
    limit = 1.0 / below if below > 0.0 else np.inf
    enough = 0.0 if exact or below <= 0.0 else limit
    prices[:] = 0.0
    end, direction, tau, v = run_pass(
        tableau, cost, L, prices, False, Target(limit, enough, NEVER if exact else A_LOOK)
    )
    for t in range(6):
        y[t] = prices[t]
    if not into_polar(env, separation, y):
        for t in range(6):
            y[t] = 0.0
    U = upper_bound(program, nobody, y.reshape(1, 6))
    if end == TROUBLE:
        return FAILED, U, direction
    if below <= 0.0 and unattained(program, nobody, y) > BALANCED:
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
