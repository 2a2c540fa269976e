"""Linear programs and their solutions as values; a solution can prove itself."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array


class LpStatus(enum.Enum):
    """How a linear program ended; the value is a sentence for the user."""

    OPTIMAL = "the program has an optimal solution"
    INFEASIBLE = "no point satisfies the constraints"
    UNBOUNDED = "the objective grows without limit"


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """Optimise ``cost @ x`` within bounds on ``x`` and on ``matrix @ x``.

    Attributes:
        cost: (n,), objective coefficients.
        matrix: (m, n), compressed sparse columns.
        row_lower: (m,), lower bounds on the rows; -inf where there is none.
        row_upper: (m,), upper bounds on the rows; +inf where there is none.
        col_lower: (n,), lower bounds on the variables.
        col_upper: (n,), upper bounds on the variables.
        maximise: whether the objective is maximised instead of minimised.
    """

    cost: Array
    matrix: sparse.csc_array
    row_lower: Array
    row_upper: Array
    col_lower: Array
    col_upper: Array
    maximise: bool = False


@dataclass(frozen=True, eq=False)
class LpSolution:
    """What a solver found for a program.

    Attributes:
        program: the program solved.
        status: how it ended.
        x: (n,), the optimal point; empty unless OPTIMAL.
        dual: (m,), one multiplier per row, the objective's derivative with respect to the
            row's active bound; empty unless OPTIMAL.
        objective: the optimal value; NaN unless OPTIMAL.
        ray: (m,) where INFEASIBLE, multipliers of the rows whose combination no point within
            the bounds can satisfy; (n,) where UNBOUNDED, the direction that improves for
            ever; empty where OPTIMAL, or where the solver gave none.
    """

    program: LinearProgram
    status: LpStatus
    x: Array
    dual: Array
    objective: float
    ray: Array

    def primal_residual(self) -> float:
        """Return the largest violation of a row or a bound by ``x`` (0 for an empty program)."""
        lp = self.program
        rows = lp.matrix @ self.x
        gaps = np.concatenate([
            lp.row_lower - rows, rows - lp.row_upper, lp.col_lower - self.x, self.x - lp.col_upper
        ])  # fmt: skip
        return max(0.0, float(gaps.max(initial=0.0)))

    def dual_bound(self) -> float:
        """Return the bound on the objective that ``dual`` proves by weak duality.

        It equals ``objective`` at an optimum. Multipliers and reduced costs that point at an
        infinite bound within rounding count as zero.
        """
        lp = self.program
        sign = -1.0 if lp.maximise else 1.0
        dual = sign * self.dual
        reduced = sign * lp.cost - lp.matrix.T @ dual
        bound = _support(dual, lp.row_lower, lp.row_upper)
        return sign * (bound + _support(reduced, lp.col_lower, lp.col_upper))

    def dual_residual(self) -> float:
        """Return the largest multiplier or reduced cost with the wrong sign."""
        lp = self.program
        sign = -1.0 if lp.maximise else 1.0
        dual = sign * self.dual
        reduced = sign * lp.cost - lp.matrix.T @ dual
        wrong = [
            np.where(np.isinf(lower), np.maximum(values, 0.0), 0.0)
            + np.where(np.isinf(upper), np.maximum(-values, 0.0), 0.0)
            for values, lower, upper in (
                (dual, lp.row_lower, lp.row_upper),
                (reduced, lp.col_lower, lp.col_upper),
            )
        ]
        return float(np.concatenate(wrong).max(initial=0.0))


def _support(values: Array, lower: Array, upper: Array) -> float:
    """Return the least of ``values @ x`` over the box, infinite bounds left out."""
    low = np.where(np.isfinite(lower), lower, 0.0)
    high = np.where(np.isfinite(upper), upper, 0.0)
    return float(np.where(values > 0, values * low, values * high).sum())
