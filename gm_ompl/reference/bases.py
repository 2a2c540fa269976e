"""Problem (6) for fixed f_com, tried on the bases that were optimal before.

Along an arc the contact state changes a little from segment to segment, and so do the cases of one
instant. The optimal bases of the last program then mostly are those of the next, and whether they
are takes a few products of small matrices to see. A basis that is dual feasible is so for every
direction, so all are tried on all directions; from there the dual simplex takes a few pivots, for
all directions that are left at once. What holds is as good as the solver's own answer, which is
asked for the rest.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.stability import DIRECTIONS, NEGLIGIBLE, direction_program
from gm_ompl.reference.statics import Statics

SINGULAR = 1e-12
"""A matrix with a determinant below this is no basis."""


PIVOTS = 20
"""Pivots of one direction before the solver is asked."""


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


class Bases:
    """Optimal bases, under keys that name like programs."""

    def __init__(self) -> None:
        self._bases: dict[Hashable, IntArray] = {}

    def margins(
        self, key: Hashable, model: Statics, force: BoolArray, f_com: Array, like: Hashable = None
    ) -> Margins | None:
        """Return Problem (6) for fixed f_com (n,); None where a direction has no optimum here.

        Bases under the key ``like`` are tried where those under ``key`` do not hold.
        """
        limits = np.where(force, f_com, model.f_max)
        program = direction_program(model, limits, force.astype(np.float64))
        table = _Table(program, force)
        for name in (key, like):
            if name in self._bases:
                table.take(self._bases[name])
        table.pivot()
        if len(table.left):
            solver, first = highs.Solver(program), len(table.left) == len(DIRECTIONS)
            while len(table.left):
                if not table.ask(solver, int(table.left[0])):
                    return None
                if first:
                    table.pivot()
                first = False
        self._bases[key] = np.unique(table.bases, axis=0)
        return Margins(table.tau, table.dual, limits)


class _Table:
    """The programs of all directions: ``columns x = right[i]``, x >= 0, x[0] = tau least.

    Attributes:
        left: the directions without an answer.
        tau: (76,), the answers.
        dual: (76, m), their multipliers.
        bases: (76, m), their bases.
    """

    def __init__(self, program: LinearProgram, force: BoolArray) -> None:
        m, N = len(program.row_lower), len(DIRECTIONS)
        self._columns = np.hstack([program.matrix.toarray(), np.eye(m)])
        self._right = np.hstack([DIRECTIONS, np.zeros((N, m - 6))])
        self._open = np.isinf(program.row_lower)
        # The slack of an equation is 0: it may be basic there, and its price is free.
        self._fixed = np.zeros(self._columns.shape[1], dtype=bool)
        self._fixed[-m:] = np.append(np.ones(6, dtype=bool), force)
        self.left = np.arange(N)
        self.tau, self.dual = np.zeros(N), np.zeros((N, m))
        self.bases = np.zeros((N, m), dtype=np.int64)

    def take(self, bases: IntArray) -> None:
        """Answer what ``bases`` (b, m) prove the optimum of."""
        if not len(self.left) or bases.max() >= self._columns.shape[1]:
            return
        square = self._columns[:, bases].transpose(1, 0, 2)
        usable = np.abs(np.linalg.det(square)) > SINGULAR
        square, bases = square[usable], bases[usable]
        prices = (bases == 0).astype(np.float64)
        dual = np.linalg.solve(square.transpose(0, 2, 1), prices[:, :, None])[:, :, 0]
        reduced = -(dual @ self._columns)
        reduced[:, 0] += 1.0
        sound = ((reduced >= -highs.TOLERANCE) | self._fixed).all(axis=1)
        square, bases, prices, dual = square[sound], bases[sound], prices[sound], dual[sound]
        if not len(bases):
            return
        x = np.linalg.solve(square, self._right[self.left].T[None])  # (b, m, directions left)
        low = np.where(self._fixed[bases][:, :, None], -np.abs(x), x).min(axis=1)
        first, proven = low.argmax(axis=0), low.max(axis=0) >= -highs.TOLERANCE
        new, own = self.left[proven], first[proven]
        self.tau[new] = (x * prices[:, :, None]).sum(axis=1)[own, proven]
        self.dual[new], self.bases[new] = dual[own], bases[own]
        self.left = self.left[~proven]

    def pivot(self) -> None:
        """Go on from the answers to what is left."""
        left, known = self.left, np.flatnonzero(self.bases.any(axis=1))
        if not len(left) or not len(known):
            return
        near = known[(DIRECTIONS[left] @ DIRECTIONS[known].T).argmax(axis=1)]
        found = pivoted(self._columns, self._fixed, self._right[left], self.bases[near])
        self.take(np.unique(found, axis=0))

    def ask(self, solver: highs.Solver, i: int) -> bool:
        """Let the solver answer direction ``i``; False where it has no optimum."""
        rows = self._right[i]
        try:
            solution = solver.solve_for(np.where(self._open, -np.inf, rows), rows)
        except SolverError:
            return False
        if solution.status is not LpStatus.OPTIMAL:
            return False
        self.tau[i], self.dual[i] = solution.objective, solution.dual
        self.bases[i] = solver.basis()
        self.left = self.left[self.left != i]
        self.take(self.bases[i][None])
        return True


def pivoted(columns: Array, fixed: BoolArray, right: Array, bases: IntArray) -> IntArray:
    """Return bases (L, m) after some pivots of the dual simplex, each for a right-hand side.

    The programs are ``columns x = right``, x >= 0, x[0] least. Nothing is proven of what comes out.

    Args:
        columns: (m, N).
        fixed: (N,), what must be 0.
        right: (L, m).
        bases: (L, m), dual feasible.
    """
    bases, open_ = bases.copy(), np.arange(len(bases))
    for _ in range(PIVOTS):
        own = bases[open_]
        square = columns[:, own].transpose(1, 0, 2)
        try:
            inverse = np.linalg.inv(square)
        except np.linalg.LinAlgError:
            break
        x = np.einsum("lij,lj->li", inverse, right[open_])
        low = np.where(fixed[own], -np.abs(x), x)
        row, rows = low.argmin(axis=1), np.arange(len(own))
        cost = (own == 0).astype(np.float64)
        reduced = -np.einsum("li,lij->lj", cost, inverse) @ columns
        reduced[:, 0] += 1.0
        # Who leaves must grow, or fall where it is fixed and too large.
        grow = -(inverse[rows, row] @ columns) * np.where(x[rows, row] < 0.0, 1.0, -1.0)[:, None]
        ratio = np.full(grow.shape, np.inf)
        able = (grow > highs.TOLERANCE) & ~fixed
        np.divide(np.maximum(reduced, 0.0), grow, out=ratio, where=able)
        np.put_along_axis(ratio, own, np.inf, axis=1)
        enters = ratio.argmin(axis=1)
        on = (low[rows, row] < -highs.TOLERANCE) & np.isfinite(ratio[rows, enters])
        if not on.any():
            break
        bases[open_[on], row[on]] = enters[on]
        open_ = open_[on]
    return bases
