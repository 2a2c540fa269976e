import subprocess
import sys

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog

from gm_ompl.arrays import Array
from gm_ompl.reference import highs
from gm_ompl.reference.program import LinearProgram, LpStatus


def program(
    cost: list[float], rows: list[list[float]], low: list[float], high: list[float],
    *, maximise: bool = False,
) -> LinearProgram:  # fmt: skip
    n = len(cost)
    return LinearProgram(
        np.array(cost), sparse.csc_array(np.array(rows)), np.array(low), np.array(high),
        np.zeros(n), np.full(n, np.inf), maximise,
    )  # fmt: skip


def test_textbook_program() -> None:
    """Maximise 3x + 5y; x <= 4, 2y <= 12, 3x + 2y <= 18: (2, 6), 36 (Hillier, Lieberman)."""
    lp = program(
        [3.0, 5.0], [[1, 0], [0, 2], [3, 2]], [-np.inf] * 3, [4.0, 12.0, 18.0], maximise=True
    )
    solution = highs.solve(lp)
    assert solution.status is LpStatus.OPTIMAL
    np.testing.assert_allclose(solution.x, [2.0, 6.0], atol=1e-12)
    np.testing.assert_allclose(solution.dual, [0.0, 1.5, 1.0], atol=1e-12)
    assert solution.objective == pytest.approx(36.0)
    assert solution.dual_bound() == pytest.approx(36.0)
    assert solution.primal_residual() < 1e-12
    assert solution.dual_residual() < 1e-12


def test_residuals_see_a_wrong_point_and_wrong_multipliers() -> None:
    """A solution moved off its optimum shows a residual, and false multipliers a gap."""
    lp = program([1.0, 1.0], [[1, 1]], [1.0], [np.inf])
    solution = highs.solve(lp)
    moved = type(solution)(
        lp, LpStatus.OPTIMAL, np.array([0.2, 0.3]), -solution.dual, 0.5, solution.ray
    )
    assert moved.primal_residual() == pytest.approx(0.5)
    assert moved.dual_residual() > 0.5


def test_infeasible_comes_with_a_ray() -> None:
    """The rows x + y >= 3 and x + y <= 1 cannot hold; the ray combines them into 0 >= 2."""
    solution = highs.solve(program([1.0, 1.0], [[1, 1], [1, 1]], [3.0, -np.inf], [np.inf, 1.0]))
    assert solution.status is LpStatus.INFEASIBLE
    assert len(solution.ray) == 2
    assert solution.ray.sum() == pytest.approx(0.0)
    assert np.isnan(solution.objective)


def test_unbounded_comes_with_a_ray() -> None:
    """The row x - y = 0 lets x + y grow for ever, along (1, 1)."""
    solution = highs.solve(program([1.0, 1.0], [[1, -1]], [0.0], [0.0], maximise=True))
    assert solution.status is LpStatus.UNBOUNDED
    assert solution.ray[0] == pytest.approx(solution.ray[1])
    assert solution.ray[0] > 0


def random_rows(rng: np.random.Generator) -> tuple[Array, Array]:
    A = rng.normal(size=(6, 20))
    return A, A @ rng.uniform(0, 1, size=20) if rng.random() < 0.7 else rng.normal(size=6)


def test_random_programs_agree_with_scipy_and_prove_themselves() -> None:
    """On 60 random programs status and optimum equal scipy's, and weak duality closes the gap."""
    statuses = set()
    for seed in range(60):
        rng = np.random.default_rng(seed)
        A, b = random_rows(rng)
        cost = rng.uniform(0.0, 1.0, size=20) if seed % 3 else rng.normal(size=20)
        lp = LinearProgram(cost, sparse.csc_array(A), b, b, np.zeros(20), np.full(20, np.inf))
        ours = highs.solve(lp)
        theirs = linprog(cost, A_eq=A, b_eq=b, bounds=(0, None), method="highs")
        statuses.add(ours.status)
        assert {0: LpStatus.OPTIMAL, 2: LpStatus.INFEASIBLE, 3: LpStatus.UNBOUNDED}[
            theirs.status
        ] is ours.status
        if ours.status is LpStatus.OPTIMAL:
            assert ours.objective == pytest.approx(theirs.fun, rel=1e-8, abs=1e-8)
            assert ours.dual_bound() == pytest.approx(ours.objective, rel=1e-8, abs=1e-8)
            assert max(ours.primal_residual(), ours.dual_residual()) < 1e-8
    assert LpStatus.OPTIMAL in statuses
    assert len(statuses) > 1


def test_warm_starts_do_not_change_answers() -> None:
    """One solver asked for 40 right-hand sides in turn answers as 40 fresh solvers do."""
    rng = np.random.default_rng(5)
    A = rng.normal(size=(6, 30))
    cost = rng.uniform(0.0, 1.0, size=30)
    zero = np.zeros(6)
    held = highs.Solver(
        LinearProgram(cost, sparse.csc_array(A), zero, zero, np.zeros(30), np.full(30, np.inf))
    )
    for _ in range(40):
        b = rng.normal(size=6)
        warm = held.solve_for(b, b)
        cold = highs.solve(warm.program)
        assert warm.status is cold.status
        np.testing.assert_allclose(warm.objective, cold.objective, rtol=1e-9, atol=1e-9)


def test_the_solver_prints_nothing() -> None:
    """Not even on the file descriptor: `check --json` prints one object and nothing else."""
    program = (
        "import numpy as np; from scipy import sparse\n"
        "from gm_ompl.reference import highs\n"
        "from gm_ompl.reference.program import LinearProgram\n"
        "one = np.ones(1)\n"
        "lp = LinearProgram(one, sparse.csc_array([[1.0]]), one, one, 0 * one, one)\n"
        "print(highs.solve(lp).x)"
    )
    done = subprocess.run([sys.executable, "-P", "-c", program], capture_output=True, check=True)
    assert done.stdout.split() == [b"[1.]"]
