"""The only import of highspy: solves a LinearProgram with HiGHS."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import highspy
import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import SolverError
from gm_ompl.reference.program import LinearProgram, LpSolution, LpStatus

TOLERANCE = 1e-9
"""Largest violation of a row, a bound or a reduced cost that HiGHS accepts. Programs are
stated in units of the object's weight, so this means the same at any scale."""

_OPTIONS: dict[str, Any] = {
    "output_flag": False,
    "threads": 1,
    "solver": "simplex",
    "primal_feasibility_tolerance": TOLERANCE,
    "dual_feasibility_tolerance": TOLERANCE,
}
_STATUS = {
    highspy.HighsModelStatus.kOptimal: LpStatus.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: LpStatus.INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: LpStatus.UNBOUNDED,
}
_EMPTY = np.zeros(0)


class _Silent(highspy.Highs):  # type: ignore[misc]  # it has no types
    """HiGHS that prints nothing: 1.16 writes a banner to stdout while it is being made."""

    def enableCallbacks(self) -> None:
        """Do what the constructor asks for, but silently."""
        self.setOptionValue("output_flag", False)
        super().enableCallbacks()


class Solver:
    """One program held in HiGHS, solved for as many right-hand sides as asked.

    Each solve starts from the last basis: the dual simplex then needs a few pivots.

    Args:
        program: the program.
        options: HiGHS's, where they are not to be the usual ones.
    """

    def __init__(self, program: LinearProgram, **options: Any) -> None:
        self._program = program
        self._highs = _Silent()
        for name, value in {**_OPTIONS, **options}.items():
            self._highs.setOptionValue(name, value)
        # Presolve would discard the warm start, and hides rays behind its own reductions; it is
        # the last resort.
        self._highs.setOptionValue("presolve", "off")
        self._highs.passModel(_highs_lp(program))
        self._rows = np.arange(len(program.row_lower), dtype=np.int32)

    def solve(self) -> LpSolution:
        """Solve the program as it stands.

        Raises:
            SolverError: HiGHS returned neither an optimum nor a certificate, however asked.
        """
        self._highs.run()
        for presolve in ("off", "on"):
            if self._highs.getModelStatus() in _STATUS:
                break
            self._highs.clearSolver()  # a fresh start where the last basis led astray
            self._highs.setOptionValue("presolve", presolve)
            self._highs.run()
        self._highs.setOptionValue("presolve", "off")
        found = self._highs.getModelStatus()
        if found not in _STATUS:
            raise SolverError(f"HiGHS ended with {self._highs.modelStatusToString(found)!r}")
        return self._solution(_STATUS[found])

    def solve_for(self, row_lower: Array, row_upper: Array) -> LpSolution:
        """Replace the bounds on the rows, each (m,), and solve.

        Raises:
            SolverError: as for ``solve``.
        """
        self._program = replace(self._program, row_lower=row_lower, row_upper=row_upper)
        self._highs.changeRowsBounds(len(self._rows), self._rows, row_lower, row_upper)
        return self.solve()

    def solve_within(self, col_upper: Array) -> LpSolution:
        """Replace the upper bounds (n,) on the variables, and solve.

        Raises:
            SolverError: as for ``solve``.
        """
        self._program = replace(self._program, col_upper=col_upper)
        lower, n = self._program.col_lower, len(col_upper)
        self._highs.changeColsBounds(n, np.arange(n, dtype=np.int32), lower, col_upper)
        return self.solve()

    def basis(self) -> list[int]:
        """Return the last optimum's basis: columns, and n + i for the activity of row i."""
        basis, basic = self._highs.getBasis(), highspy.HighsBasisStatus.kBasic
        columns = [j for j, status in enumerate(basis.col_status) if status == basic]
        n = len(basis.col_status)
        return columns + [n + i for i, status in enumerate(basis.row_status) if status == basic]

    def _solution(self, status: LpStatus) -> LpSolution:
        if status is not LpStatus.OPTIMAL:
            return LpSolution(self._program, status, _EMPTY, _EMPTY, np.nan, self._ray(status))
        solution = self._highs.getSolution()
        return LpSolution(
            self._program,
            status,
            np.asarray(solution.col_value, dtype=np.float64),
            np.asarray(solution.row_dual, dtype=np.float64),
            float(self._highs.getInfo().objective_function_value),
            _EMPTY,
        )

    def _ray(self, status: LpStatus) -> Array:
        infeasible = status is LpStatus.INFEASIBLE
        answer = self._highs.getDualRay() if infeasible else self._highs.getPrimalRay()
        _, exists, ray = answer
        return np.asarray(ray, dtype=np.float64) if exists else _EMPTY


def solve(program: LinearProgram, **options: Any) -> LpSolution:
    """Solve one program; ``options`` as for ``Solver``.

    Raises:
        SolverError: HiGHS returned neither an optimum nor a certificate.
    """
    return Solver(program, **options).solve()


def _highs_lp(program: LinearProgram) -> highspy.HighsLp:
    lp = highspy.HighsLp()
    lp.num_row_, lp.num_col_ = program.matrix.shape
    lp.col_cost_ = program.cost
    lp.col_lower_, lp.col_upper_ = program.col_lower, program.col_upper
    lp.row_lower_, lp.row_upper_ = program.row_lower, program.row_upper
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_ = program.matrix.indptr
    lp.a_matrix_.index_ = program.matrix.indices
    lp.a_matrix_.value_ = program.matrix.data
    if program.maximise:
        lp.sense_ = highspy.ObjSense.kMaximize
    return lp
