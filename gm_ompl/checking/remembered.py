"""What programs at earlier instants have proven, tried on the present one.

Along an arc the contact state changes a little from segment to segment. The optimal basis, or the
certificate, of the last segment then mostly is that of the next, and whether it is takes a few
products of small matrices to see, all directions at once. What holds is as good as the solver's own
answer; the rest goes to the solver.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.internal_force import (
    InternalForce,
    cancelling,
    certify,
    excessive_internal_force,
    unit_wrenches,
)
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.stability import DIRECTIONS, NEGLIGIBLE, direction_program
from gm_ompl.reference.statics import Statics

Modes = tuple[bool, ...]
"""Per finger, whether it is force-controlled."""


@dataclass(frozen=True, eq=False)
class Margins:
    """Problem (6) for fixed f_com, solved per direction, each optimum with its proof.

    Attributes:
        tau: (76,), 1 / z_i.
        dual: (76, 6 + n), the rows' multipliers.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
    """

    tau: Array
    dual: Array
    limits: Array

    @property
    def z(self) -> float:
        """The margin, in units of ``Statics.scale``."""
        most = float(self.tau.max())
        return 1.0 / most if most > NEGLIGIBLE else np.inf


class Remembered:
    """Bases by direction, and certificates of Problem (5), under keys that name like instants."""

    def __init__(self) -> None:
        self._bases: dict[Hashable, IntArray] = {}
        self._verdicts: dict[Hashable, InternalForce] = {}

    def excessive(self, key: Hashable, model: Statics, position: frozenset[int]) -> bool:
        """Whether Problem (5) finds excessive internal force.

        Raises:
            SolverError: the solver returned no answer.
        """
        last = self._verdicts.get(key)
        verdict = None if last is None else _again(last, unit_wrenches(model, position))
        if verdict is None:
            verdict = excessive_internal_force(model, position)
        self._verdicts[key] = verdict
        return verdict.excessive

    def margins(
        self, key: Hashable, model: Statics, force: BoolArray, f_com: Array
    ) -> Margins | None:
        """Return Problem (6) for fixed f_com (n,); None where a direction has no optimum here."""
        limits = np.where(force, f_com, model.f_max)
        program = direction_program(model, limits, force.astype(np.float64))
        table = _Table(program, force)
        bases = self._bases.get(key)
        if bases is None or bases.max() >= table.columns.shape[1]:
            bases = np.zeros((len(DIRECTIONS), len(program.row_lower)), dtype=np.int64)
        bases = bases.copy()
        x, dual, proven = table.tried(bases)
        left = np.flatnonzero(~proven)
        if len(left):
            solver = highs.Solver(program)
            for i in left:
                rows = table.right[i]
                lower = np.where(np.isinf(program.row_lower), -np.inf, rows)
                try:
                    solution = solver.solve_for(lower, rows)
                except SolverError:
                    return None
                if solution.status is not LpStatus.OPTIMAL:
                    return None
                bases[i] = solver.basis()
                x[i], dual[i] = solution.objective, solution.dual
        self._bases[key] = bases
        return Margins(x, dual, limits)


def _again(last: InternalForce, A: Array) -> InternalForce | None:
    """Return the verdict for wrenches ``A`` that the last one's certificate proves, if any."""
    none = np.zeros(A.shape[1])
    if last.excessive and len(last.ray) == A.shape[1]:
        verdict = certify(A, cancelling(A, last.ray), np.zeros(6))
    elif not last.excessive and len(last.wrench) and A.shape[1]:
        verdict = certify(A, none, last.wrench)
    else:
        return None
    return None if verdict.marginal else verdict


class _Table:
    """The programs of all directions: ``columns x = right[i]``, x >= 0, x[0] = tau least."""

    def __init__(self, program: LinearProgram, force: BoolArray) -> None:
        m = len(program.row_lower)
        self.columns: Array = np.hstack([program.matrix.toarray(), np.eye(m)])
        self.right: Array = np.hstack([DIRECTIONS, np.zeros((len(DIRECTIONS), m - 6))])
        # The slack of an equation is 0: it may be basic there, and its price is free.
        self._fixed = np.zeros(self.columns.shape[1], dtype=bool)
        self._fixed[-m:] = np.append(np.ones(6, dtype=bool), force)

    def tried(self, bases: IntArray) -> tuple[Array, Array, BoolArray]:
        """Return tau and the multipliers at ``bases`` (76, m), and where both prove the optimum."""
        square = self.columns[:, bases].transpose(1, 0, 2)
        proven = np.abs(np.linalg.det(square)) > 1e-12
        square[~proven] = np.eye(square.shape[1])
        x = np.linalg.solve(square, self.right[:, :, None])[:, :, 0]
        prices = (bases == 0).astype(np.float64)
        dual = np.linalg.solve(square.transpose(0, 2, 1), prices[:, :, None])[:, :, 0]
        reduced = -(dual @ self.columns)
        reduced[:, 0] += 1.0
        tolerance = highs.TOLERANCE
        proven &= (np.where(self._fixed[bases], np.abs(x) <= tolerance, x >= -tolerance)).all(1)
        proven &= ((reduced >= -tolerance) | self._fixed).all(axis=1)
        return (x * prices).sum(axis=1), dual, proven


def bound(model: Statics, force: BoolArray, found: Margins) -> float:
    """Return a bound on z over all f_com, from the multipliers at one, in units of the scale.

    Multipliers y of direction i prove ``z_i <= (y . (load, -limits)) / (y . l_i)`` whatever the
    limits are; the largest z within all 76 is the bound.

    Raises:
        SolverError: the solver returned no answer.
    """
    price = np.einsum("ij,ij->i", found.dual[:, :6], DIRECTIONS)
    cuts = np.flatnonzero(price > NEGLIGIBLE)
    y = found.dual[cuts] / price[cuts, None]
    slopes = y[:, 6:][:, force]
    level = y[:, :6] @ model.load - y[:, 6:][:, ~force] @ model.f_max[~force]
    n = slopes.shape[1]
    solution = highs.solve(
        LinearProgram(
            cost=np.append(1.0, np.zeros(n)),
            matrix=sparse.csc_array(np.hstack([np.ones((len(cuts), 1)), slopes])),
            row_lower=np.full(len(cuts), -np.inf),
            row_upper=level,
            col_lower=np.zeros(1 + n),
            col_upper=np.append(np.inf, model.f_max[force]),
            maximise=True,
        )
    )
    if solution.status is LpStatus.INFEASIBLE:
        return 0.0
    return solution.objective if solution.status is LpStatus.OPTIMAL else np.inf
