"""Problem (6) in exact arithmetic: the last word where floating point proves nothing.

The tau program of ``stability.direction_program``, for all 76 directions on one tableau of integers
with a common denominator (Edmonds, Systems of distinct representatives and linear algebra, J. Res.
NBS 71B, 1967; Avis, A revised implementation of the reverse search vertex enumeration algorithm,
2000). The numbers given are taken at their word: every double is a fraction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.errors import SolverError
from gm_ompl.reference.equilibrium import BALANCED
from gm_ompl.reference.statics import Statics

DANTZIG_STEPS = 8
"""Pivots per row towards one right-hand side before Bland's rule takes over: it cannot cycle."""
MAX_STEPS = 60
"""Pivots per row before giving up."""
MOST_WORK = 10**10
"""Products of digits that the pivots for one set of modes may take: half a minute."""
DIGIT = 30
"""Bits of a digit of Python's integers."""
OVERHEAD = 10
"""Digits, at least: a product of small integers costs as much as one of these."""


class Effort:
    """What is left of MOST_WORK, shared by all programs for a set of modes."""

    def __init__(self) -> None:
        self._left = MOST_WORK

    def spend(self, numbers: int, bits: int) -> None:
        """Take off what it costs to multiply so many integers of so many bits.

        Raises:
            SolverError: where no work is left.
            LimitError: where a limit in force is reached.
        """
        limits.check()
        self._left -= numbers * (OVERHEAD + bits // DIGIT) ** 2
        if self._left < 0:
            raise SolverError("exact arithmetic takes too long")


@dataclass(frozen=True)
class ExactMargin:
    """z for given f_com, and what proves that it is no larger.

    Attributes:
        z: 0 where some direction cannot be resisted at all; +inf where all can, to any degree.
        direction: number of a direction that limits z, or -1.
        wrench: y (6,), in the polar of the environment's cone: z h(y) <= q . y + the fingers'
            share, with equality at this f_com; empty where z is +inf.
        tau: 1 / z, None where z is 0.
    """

    z: float
    direction: int
    wrench: tuple[Fraction, ...]
    tau: Fraction | None


def exact_margin(
    model: Statics, limits: Sequence[float | Fraction], force: BoolArray, effort: Effort
) -> ExactMargin:
    """Solve Problem (6) for given f_com.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
        effort: what it may cost.

    Raises:
        SolverError: where that does not suffice.
    """
    columns = columns_of(model, limits, force)
    tableau = ExactTableau(columns, [Fraction(1)] + [Fraction(0)] * (len(columns) - 1), effort)
    worst, direction, y = Fraction(0), -1, tuple[Fraction, ...]()
    for number, signs in enumerate(SIDES):
        tau = tableau.solve(signs)
        if tau is None:
            return ExactMargin(0.0, number, tableau.ray, None)
        tau *= LENGTHS[number]
        if tau > worst:
            worst, direction, y = tau, number, tableau.duals()
    return ExactMargin(float(1 / worst) if worst else np.inf, direction, y, worst)


def balanced(
    model: Statics, limits: Array, force: BoolArray, effort: Effort, allowed: float = BALANCED
) -> bool:
    """Whether forces balance the load (Eq. (3), no disturbance), up to ``allowed``.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
        effort: what it may cost.
        allowed: forces that miss equilibrium by no more (over M g) balance.

    Raises:
        SolverError: where that does not suffice.
    """
    columns = columns_of(model, limits.tolist(), force)
    tableau = ExactTableau(columns[1:], [Fraction(0)] * (len(columns) - 1), effort)
    if tableau.solve([-value for value in columns[0]]) is not None:
        return True
    # The ray is a wrench that does work on the load for which no contact makes up.
    y = np.array([float(value) for value in tableau.ray])
    missed = -float(y @ model.load)
    for i, (limit, sigma) in enumerate(zip(limits, _supports(model, y), strict=True)):
        missed -= float(limit) * (sigma if force[i] else max(sigma, 0.0))
    return missed <= allowed * float(np.linalg.norm(y))


def _supports(model: Statics, y: Array) -> list[float]:
    """Return per finger the most work that y (6,) gets from a unit normal force."""
    return [
        float(((y @ model.rob_wrenches[:, own]) / model.normal_parts[i, own]).max())
        for i, own in enumerate(model.columns)
    ]


def columns_of(
    model: Statics, limits: Sequence[float | Fraction], force: BoolArray
) -> list[list[Fraction]]:
    """Return tau's column, the edges' columns, and a slack per position-controlled finger."""
    A = np.hstack([model.env_wrenches, model.rob_wrenches])
    normal = np.hstack([np.zeros((model.fingers, model.env_wrenches.shape[1])), model.normal_parts])
    slack = np.vstack([np.zeros((6, model.fingers)), np.eye(model.fingers)])[:, ~force]
    whole = np.hstack([np.vstack([A, normal]), slack])
    tau = [*map(Fraction, model.load.tolist()), *(-Fraction(limit) for limit in limits)]
    return [tau, *([Fraction(value) for value in column] for column in whole.T.tolist())]


_K = 2.0 * np.sqrt(3.0 - np.sqrt(6.0))
SIDES: list[list[int]] = [
    *([sign * (i == j) for j in range(6)] for i in range(6) for sign in (1, -1)),
    *([1 - 2 * (code >> (5 - j) & 1) for j in range(6)] for code in range(64)),
]
"""The directions of ``stability.DIRECTIONS`` without their length, which is that of"""
LENGTHS = [Fraction(_K)] * 12 + [Fraction(_K / np.sqrt(6.0))] * 64


class ExactTableau:
    """Dual simplex on integers: true entries are ``rows`` over ``denominator``.

    Columns: the program's, then one artificial variable per row, fixed at zero, which hold the
    inverse of the basis. The last row holds the reduced costs, none of which may begin below 0.
    """

    def __init__(
        self, columns: Sequence[Sequence[Fraction]], costs: Sequence[Fraction], effort: Effort
    ) -> None:
        self._effort = effort
        self._m, self._N = len(columns[0]), len(columns)
        # Powers of two make integers of doubles; every column may have its own.
        self._scales = [max(value.denominator for value in column) for column in columns]
        self.rows = [
            [int(column[i] * scale) for column, scale in zip(columns, self._scales, strict=True)]
            + [int(i == j) for j in range(self._m)]
            for i in range(self._m)
        ]
        # So may the costs together.
        self._unit = max((cost.denominator for cost in costs), default=1)
        self.rows.append(
            [int(cost * self._unit * scale)
             for cost, scale in zip(costs, self._scales, strict=True)] + [0] * self._m
        )  # fmt: skip
        self.basis = list(range(self._N, self._N + self._m))
        self.denominator = 1
        self.ray: tuple[Fraction, ...] = ()

    def solve(self, side: Sequence[int | Fraction]) -> Fraction | None:
        """Return the least tau for a right-hand side, None where it cannot be reached.

        The side may be shorter than the rows: the rest is zero.
        """
        step = 0
        while True:
            x = [self._times(row, side) for row in self.rows[:-1]]
            r = self._leaving(x, bland=step > DANTZIG_STEPS * self._m)
            if r is None:
                return -self._times(self.rows[-1], side) / (self.denominator * self._unit)
            sign = 1 if x[r] < 0 else -1
            c = self._entering(r, sign)
            if c is None:
                row = self.rows[r][self._N :]
                longest = max(abs(value) for value in row)
                self.ray = tuple(Fraction(-sign * value, longest) for value in row[:6])
                return None
            self._pivot(r, c)
            step += 1
            if step > MAX_STEPS * self._m:
                raise SolverError(f"no end after {step} exact pivots")

    def duals(self) -> tuple[Fraction, ...]:
        """Return the first six multipliers of the present basis."""
        row = self.rows[-1][self._N : self._N + 6]
        return tuple(Fraction(-value, self.denominator * self._unit) for value in row)

    def value(self, column: int, side: Sequence[int | Fraction]) -> Fraction:
        """Return what a variable is in the present basic solution."""
        if column not in self.basis:
            return Fraction(0)
        row = self.rows[self.basis.index(column)]
        return self._times(row, side) * self._scales[column] / self.denominator

    def _times(self, row: Sequence[int], side: Sequence[int | Fraction]) -> Fraction:
        return Fraction(sum(a * b for a, b in zip(row[self._N :], side, strict=False)))

    def _leaving(self, x: Sequence[Fraction], bland: bool) -> int | None:
        excess = [abs(value) if self.basis[r] >= self._N else -value for r, value in enumerate(x)]
        wrong = [r for r, value in enumerate(excess) if value > 0]
        if not wrong:
            return None
        if bland:
            return min(wrong, key=lambda r: self.basis[r])
        return max(wrong, key=lambda r: float(excess[r] / self.denominator))

    def _entering(self, r: int, sign: int) -> int | None:
        """Return the column of least ratio; the first among equals."""
        row, costs, best = self.rows[r], self.rows[-1], None
        for j in range(self._N):
            alpha = -sign * row[j]
            if alpha > 0 and (best is None or costs[j] * -sign * row[best] < costs[best] * alpha):
                best = j
        return best

    def _pivot(self, r: int, c: int) -> None:
        chosen, before = self.rows[r], self.denominator
        self._effort.spend(len(self.rows) * len(chosen), before.bit_length())
        pivot = chosen[c]
        if pivot < 0:
            chosen = self.rows[r] = [-value for value in chosen]
            pivot = -pivot
        for i, row in enumerate(self.rows):
            if i != r:
                factor = row[c]
                self.rows[i] = [
                    (pivot * a - factor * b) // before for a, b in zip(row, chosen, strict=True)
                ]
        self.denominator = pivot
        self.basis[r] = c
