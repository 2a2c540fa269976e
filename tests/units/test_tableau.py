"""The tableau: what a pivot keeps, who leaves and enters, and one right-hand side to the end."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.arrays import Array, IntArray
from gm_ompl.mechanics.tableau import FEASIBLE, PIVOT, entering, feasible, leaving, pivot

M, N = 4, 9


def _tableau(rng: np.random.Generator) -> tuple[Array, Array, Array, IntArray]:
    """Return columns, tableau, reduced costs (dual feasible) and basis: all artificial."""
    columns = rng.normal(size=(M, N))
    T = np.hstack([columns, np.eye(M)])
    d = np.concatenate([rng.uniform(0.1, 1.0, N), np.zeros(M)])
    return columns, T, d, np.arange(N, N + M)


@pytest.mark.parametrize("seed", range(5))
def test_a_pivot_keeps_the_inverse_of_the_basis(seed: int) -> None:
    """Artificial columns hold the inverse, reduced costs c - y A, after any number of pivots."""
    columns, T, d, basis = _tableau(np.random.default_rng(seed))
    costs = d[:N].copy()
    for r, c in ((0, 3), (2, 5), (1, 7), (0, 1)):
        pivot(T, d, basis, M, N + M, r, c)
    every = np.hstack([columns, np.eye(M)])
    np.testing.assert_allclose(T[:, N:] @ every[:, basis], np.eye(M), atol=1e-9)
    np.testing.assert_allclose(T[:, N:] @ columns, T[:, :N], atol=1e-9)
    np.testing.assert_allclose(d[:N], costs + d[N:] @ columns, atol=1e-9)
    assert basis[0] == 1


def test_who_leaves() -> None:
    """The most infeasible row, an artificial variable by its size; by Bland's rule the first."""
    x, basis = np.array([-1.0, 2.0, -0.5, 3.0]), np.array([8, 2, 4, N])
    assert leaving(x, basis, M, N, FEASIBLE, False) == 3
    assert leaving(x, basis, M, N, FEASIBLE, True) == 2
    assert leaving(np.abs(x), np.arange(M), M, N, FEASIBLE, False) == -1


def test_who_enters() -> None:
    """The least ratio, of equal ones the largest pivot; nobody where no entry has the sign."""
    T = np.array([[-1.0, -2.0, -4.0, 1.0, 1.0]])
    d = np.array([1.0, 1.0, 2.0, 1.0, 0.0])
    assert entering(T, d, 0, 1.0, PIVOT, False, np.empty(4)) == 2
    assert entering(T, d, 0, 1.0, PIVOT, True, np.empty(4)) == 1
    assert entering(np.abs(T), d, 0, 1.0, PIVOT, False, np.empty(4)) == -1


@pytest.mark.parametrize("seed", range(40))
def test_one_right_hand_side(seed: int) -> None:
    """The optimum, its duals, or the ray that proves there is none, as HiGHS finds it."""
    rng = np.random.default_rng(seed)
    columns, T, d, basis = _tableau(rng)
    if seed % 2:
        columns[0] = T[0, :N] = np.abs(columns[0])  # then b[0] < 0 has no solution
    costs, b, x, y = d[:N].copy(), rng.normal(size=M), np.empty(M), np.empty(M)
    found = feasible(T, d, basis, b, FEASIBLE, x, y)
    expected = linprog(costs, A_eq=columns, b_eq=b)
    assert found == (1 if expected.success else 0)
    if expected.success:
        assert y @ b == pytest.approx(expected.fun, abs=1e-8)
        assert (costs - y @ columns > -1e-8).all()
    else:
        assert y @ b > 0.0
        assert (y @ columns < 1e-8).all()
