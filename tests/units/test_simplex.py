"""All directions on one tableau, against one linear program per direction."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.resistance import new_resistance, written_out
from gm_ompl.mechanics.sides import SIDES, number
from gm_ompl.mechanics.simplex import (
    EXCEEDED,
    INFEASIBLE,
    SOLVED,
    Care,
    Target,
    search_directions,
)
from gm_ompl.mechanics.tableau import FEASIBLE, NEVER, PIVOT
from gm_ompl.mechanics.tau import Tableau

M, N = 6, 22
CARE = Care(PIVOT, FEASIBLE, False)


@pytest.mark.parametrize("seed", range(8))
def test_the_worst_direction(seed: int) -> None:
    """The largest tau of 76 programs, its duals, and what resists every single direction."""
    rng = np.random.default_rng(seed)
    raw = rng.normal(size=(M, N))
    if seed % 4 == 3:
        raw[2] = np.abs(raw[2])  # nothing resists one side
    taus = []
    for direction in DIRECTIONS:
        cost = np.eye(N)[0]
        solved = linprog(cost, A_eq=raw, b_eq=direction)
        taus.append(solved.fun if solved.success else np.inf)
    T = np.hstack([raw, np.eye(M), np.empty((M, SIDES))])
    for s in range(SIDES):
        T[:, N + M + s] = DIRECTIONS[number(2 * s)]
    d = np.zeros(N + M + SIDES)
    d[0] = 1.0
    y, found = np.empty(M), new_resistance(M)
    tableau = Tableau(raw, T, d, np.arange(N, N + M), y, found)
    end, code, tau = search_directions(tableau, 1.0, Target(np.inf, 0.0, NEVER), CARE)
    side = DIRECTIONS[number(code)]
    if max(taus) == np.inf:
        assert end == INFEASIBLE
        assert y @ side > 0.0
        assert (y @ raw < 1e-8).all()
        return
    assert end == SOLVED
    assert tau == pytest.approx(max(taus), rel=1e-7, abs=1e-9)
    assert y @ side == pytest.approx(tau, rel=1e-7, abs=1e-9)
    solutions = np.empty((N, 2 * SIDES))
    written_out(found, solutions)
    sides = np.stack([DIRECTIONS[number(c)] for c in range(2 * SIDES)], axis=1)
    np.testing.assert_allclose(raw @ solutions, sides, atol=1e-6)
    assert (solutions[0] <= tau + 1e-7).all()


def test_it_stops_where_the_limit_is_passed() -> None:
    """One direction whose tau exceeds the limit is answer enough."""
    raw = np.hstack([np.full((M, 1), 0.1), np.eye(M), -np.eye(M)])
    raw[0, 0] = 2.0
    raw[:, 1] *= 0.0  # only tau resists +x
    n = raw.shape[1]
    T, d = np.hstack([raw, np.eye(M), np.empty((M, SIDES))]), np.zeros(n + M + SIDES)
    for s in range(SIDES):
        T[:, n + M + s] = DIRECTIONS[number(2 * s)]
    d[0] = 1.0
    tableau = Tableau(raw, T, d, np.arange(n, n + M), np.empty(M), new_resistance(M))
    end, _, tau = search_directions(tableau, 1.0, Target(0.01, 0.0, NEVER), CARE)
    assert end == EXCEEDED
    assert tau > 0.01
