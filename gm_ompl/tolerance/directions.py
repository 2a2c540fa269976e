"""Problem (6) for fixed commands as far as z is concerned: few of the 76 directions are solved.

A basis that is optimal for one direction is dual feasible for all, and where its solution for
another is not negative, that is solved, too. A solution that is a little negative is made feasible
by adding balances, solutions of opposite directions; where that costs no more than the direction
that limits z, the direction cannot limit z, and what was found resists z l_i.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.reference import highs
from gm_ompl.reference.bases import SINGULAR, pivoted
from gm_ompl.reference.equilibrium import blocks
from gm_ompl.reference.program import LpStatus
from gm_ompl.reference.stability import DIRECTIONS, direction_program
from gm_ompl.reference.statics import Statics

FEASIBLE: Final = 1e-10
"""A basic variable below 0 by no more, over the largest of its solution, is 0."""

N: Final = len(DIRECTIONS)
OPPOSITE: Final = np.array([k ^ 1 if k < 12 else 87 - k for k in range(N)])
"""The number of each direction's opposite."""


@dataclass(eq=False)
class Resisted:
    """Solutions of Problem (6) by direction, in tau form.

    Attributes:
        tau: (76,), as small as was found; NaN where nothing was.
        k: (76, c), forces that resist l_i at that tau, on the columns as in ``blocks``.
        bases: (76, 6 + n), what was solved last.
        balance: (c + 7 + n,), tau, forces and slacks that balance nothing but the load.
        most: a lower bound on 1 / z, which it is where that is of interest; +inf where some
            direction cannot be resisted at all.
    """

    tau: Array
    k: Array
    bases: IntArray
    balance: Array
    most: float

    @property
    def direction(self) -> int:
        """The number of the direction with the largest tau found."""
        return int(np.nan_to_num(self.tau, nan=-1.0).argmax())


class Programs:
    """The programs of all directions: ``columns x = right[i]``, x >= 0, x[0] = tau least.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
    """

    def __init__(self, model: Statics, limits: Array, force: BoolArray) -> None:
        self._model, self._limits, self._force = model, limits, force
        A, normal = blocks(model)
        rows = 6 + len(limits)
        tau = np.append(model.load, -limits)
        self.columns: Array = np.hstack([tau[:, None], np.vstack([A, normal]), np.eye(rows)])
        self.right: Array = np.hstack([DIRECTIONS, np.zeros((N, len(limits)))])
        # The slack of an equation is 0: it may be basic there, and its price is free.
        self._fixed = np.zeros(self.columns.shape[1], dtype=bool)
        self._fixed[-rows:] = np.append(np.ones(6, dtype=bool), force)
        self._x = np.full((N, self.columns.shape[1]), np.nan)
        self._bases = np.zeros((N, rows), dtype=np.int64)
        self._low = np.full(N, -np.inf)
        self._found, self._sound = np.zeros(N, dtype=bool), np.zeros(N, dtype=bool)
        self._fine, self._nearby = 0.0, np.zeros(self.columns.shape[1])

    def solve(
        self, last: Resisted | None = None, fine: float = 0.0, enough: float = np.inf,
        even: bool = False,
    ) -> Resisted:  # fmt: skip
        """Find what limits z, as far as that is of interest.

        Args:
            last: an answer for a world nearby.
            fine: a tau so small is fine, least or not.
            enough: one tau larger than this says enough.
            even: whether forces should be like those of worlds nearby where there is a choice;
                it takes longer.

        Raises:
            SolverError: the solver returned no answer.
        """
        self._fine, most = fine, -1
        if last is not None and last.bases.shape == self._bases.shape:
            if len(last.balance) == self.columns.shape[1]:
                self._carry(last.balance)
            self._keep(last.bases)
            most = last.direction
        turns = not even
        while not self._found.all() and self._most <= enough:
            self._spare()
            left = np.flatnonzero(~self._found)
            if not len(left):
                break
            if turns and self._sound.any():
                self._pivot(left)
                turns = False
                continue
            # What limited z nearby may again.
            i = most if most in left else int(left[np.argmax(self._low[left])])
            if not self._ask(i):
                return self._result(np.inf)
        return self._result(self._most)

    @property
    def _most(self) -> float:
        return float(self._low.max())

    @property
    def _spared(self) -> float:
        """The largest tau that need not be the least."""
        return max(self._fine, self._most)

    def _result(self, most: float) -> Resisted:
        end = self.columns.shape[1] - self.columns.shape[0]
        balance = self._balanced()
        return Resisted(self._x[:, 0], self._x[:, 1:end], self._bases, balance, most)

    def _balanced(self) -> Array:
        """Return the sum of opposite solutions, and of the balance that came from nearby."""
        pairs = self._found & self._found[OPPOSITE]
        balance: Array = self._nearby + np.maximum(self._x[pairs], 0.0).sum(axis=0)
        balance[self._fixed] = 0.0
        return balance

    def _carry(self, balance: Array) -> None:
        """Take a balance from nearby: its own columns change to make up for what is missing now."""
        balance = balance / (balance.sum() or 1.0)
        weighted = self.columns * balance**2
        missing = self.columns @ balance
        change = weighted.T @ np.linalg.lstsq(weighted @ self.columns.T, missing, rcond=None)[0]
        carried = balance - change
        if carried.min() >= 0.0 and np.abs(self.columns @ carried).max() <= FEASIBLE:
            self._nearby = carried

    def _keep(self, bases: IntArray) -> None:
        """Keep earlier bases (76, m), one per direction, where they still do.

        Forces then change little from world to world, which proofs of what lies between rest on.
        """
        if bases.max() >= self.columns.shape[1]:
            return
        square = self.columns[:, bases].transpose(1, 0, 2)
        rows = np.flatnonzero(np.abs(np.linalg.det(square)) > SINGULAR)
        if not len(rows):
            return
        own, square = bases[rows], square[rows]
        values = np.linalg.solve(square, self.right[rows][:, :, None])[:, :, 0]
        prices = (own == 0).astype(np.float64)
        dual = np.linalg.solve(square.transpose(0, 2, 1), prices[:, :, None])[:, :, 0]
        x = np.zeros((len(rows), self.columns.shape[1]))
        np.put_along_axis(x, own, values, axis=1)
        sound = self._dual_feasible(dual)
        self._x[rows], self._bases[rows], self._sound[rows] = x, own, sound
        self._low[rows[sound]] = (dual[sound, :6] * DIRECTIONS[rows[sound]]).sum(axis=1)
        feasible = self._feasible(x)
        # What is feasible but perhaps not the least is found once it cannot limit z.
        self._found[rows[feasible & sound]] = True
        waiting = rows[feasible & ~sound]
        self._found[waiting] = self._x[waiting, 0] <= self._spared
        if sound.any():
            self._lend(own[sound])

    def _lend(self, bases: IntArray) -> None:
        """Use bases (b, m), of whatever directions, for those that are not found yet."""
        left = np.flatnonzero(~self._found)
        if not len(left):
            return
        bases = np.unique(bases, axis=0)
        square = self.columns[:, bases].transpose(1, 0, 2)
        usable = np.abs(np.linalg.det(square)) > SINGULAR
        square, bases = square[usable], bases[usable]
        prices = (bases == 0).astype(np.float64)[:, :, None]
        dual = np.linalg.solve(square.transpose(0, 2, 1), prices)[:, :, 0]
        sound = self._dual_feasible(dual)
        square, bases, dual = square[sound], bases[sound], dual[sound]
        if not len(bases):
            return
        bounds = DIRECTIONS[left] @ dual[:, :6].T
        self._low[left] = np.maximum(self._low[left], bounds.max(axis=1))
        values = np.linalg.solve(square, self.right[left].T[None])
        # Of several solutions that lack something, the one that lacks least is the best start.
        best = values.min(axis=1).argmax(axis=0)
        x = np.zeros((len(left), self.columns.shape[1]))
        chosen = np.take_along_axis(values, best[None, None], axis=0)[0].T
        np.put_along_axis(x, bases[best], chosen, axis=1)
        known = np.nan_to_num(self._x[left], nan=-np.inf).min(axis=1)
        feasible = self._feasible(x)
        taken = feasible | (x.min(axis=1) > known)
        self._x[left[taken]], self._bases[left[taken]] = x[taken], bases[best[taken]]
        self._sound[left[taken]] = True
        self._found[left[feasible]] = True

    def _dual_feasible(self, dual: Array) -> BoolArray:
        reduced = -(dual @ self.columns)
        reduced[:, 0] += 1.0
        sound: BoolArray = (reduced >= -highs.TOLERANCE) | self._fixed
        good: BoolArray = np.all(sound, axis=1)
        return good

    def _feasible(self, x: Array) -> BoolArray:
        size = FEASIBLE * np.maximum(np.abs(x).max(axis=1, initial=1.0), 1.0)[:, None]
        low: Array = np.where(self._fixed, -np.abs(x), x)
        good: BoolArray = np.all(low >= -size, axis=1)
        return good

    def _spare(self) -> None:
        """Find directions that cannot limit z, by adding balances to what is known of them."""
        left = np.flatnonzero(~self._found & ~np.isnan(self._x[:, 0]))
        balance = self._balanced()
        if not balance.any() or not len(left):
            return
        x = self._x[left]
        missing = np.where(x < 0.0, -x, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            needed = np.where(missing > 0.0, missing / balance, 0.0)
        share = needed.max(axis=1)
        stuck = (np.abs(x[:, self._fixed]) > FEASIBLE).any(axis=1) | ~np.isfinite(share)
        better = x + np.where(stuck, 0.0, share)[:, None] * balance
        spared = ~stuck & (better[:, 0] <= self._spared)
        self._x[left[spared]] = better[spared]
        self._found[left[spared]] = True

    def _pivot(self, left: IntArray) -> None:
        """Go on from the bases of directions, or of ones nearby."""
        known = np.flatnonzero(self._sound)
        near = known[(DIRECTIONS[left] @ DIRECTIONS[known].T).argmax(axis=1)]
        start = self._bases[np.where(self._sound[left], left, near)]
        self._lend(pivoted(self.columns, self._fixed, self.right[left], start))

    @cached_property
    def _solver(self) -> highs.Solver:
        self._program = direction_program(self._model, self._limits, self._force.astype(np.float64))
        return highs.Solver(self._program)

    def _ask(self, i: int) -> bool:
        """Solve a direction, and others by its basis; return whether it can be resisted at all."""
        solver, rows = self._solver, self.right[i]
        lower = np.where(np.isinf(self._program.row_lower), -np.inf, rows)
        solution = solver.solve_for(lower, rows)
        if solution.status is not LpStatus.OPTIMAL:
            return False
        own, wide = np.array(solver.basis()), len(solution.x)
        self._x[i, :wide] = np.maximum(solution.x, 0.0)
        self._x[i, wide:] = rows - self.columns[:, :wide] @ solution.x
        self._bases[i], self._found[i], self._sound[i] = own, True, True
        self._low[i] = max(self._low[i], solution.objective)
        self._lend(own[None])
        return True
