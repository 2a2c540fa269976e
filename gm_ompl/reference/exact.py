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

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.errors import SolverError
from gm_ompl.reference.statics import Statics

DANTZIG_STEPS = 8
"""Pivots per row towards one right-hand side before Bland's rule takes over: it cannot cycle."""
MISSED = 1e-9
"""Forces that miss equilibrium by less than this (over M g) balance (convention)."""
MAX_STEPS = 60
"""Pivots per row before giving up."""


@dataclass(frozen=True)
class ExactMargin:
    """z for given f_com.

    Attributes:
        z: 0 where some direction cannot be resisted at all; +inf where all can, to any degree.
        direction: number of a direction that limits z, or -1.
        tau: 1 / z; None where z is 0.
    """

    z: float
    direction: int
    tau: Fraction | None


def exact_margin(
    model: Statics, limits: Sequence[float | Fraction], force: BoolArray
) -> ExactMargin:
    """Solve Problem (6) for given f_com.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
    """
    columns = _columns(model, limits, force)
    tableau = _Tableau(columns, [Fraction(1)] + [Fraction(0)] * (len(columns) - 1))
    worst, direction = Fraction(0), -1
    for number, signs in enumerate(_SIDES):
        tau = tableau.solve(signs)
        if tau is None:
            return ExactMargin(0.0, number, None)
        tau *= _LENGTHS[number]
        if tau > worst:
            worst, direction = tau, number
    return ExactMargin(float(1 / worst) if worst else np.inf, direction, worst)


def balanced(model: Statics, limits: Array, force: BoolArray) -> bool:
    """Whether forces balance the load (Eq. (3), no disturbance), up to MISSED.

    Args:
        model: the mechanics.
        limits: (n,), f_com under force control, else f_max, in units of ``Statics.scale``.
        force: (n,), which fingers are force-controlled.
    """
    columns = _columns(model, limits.tolist(), force)
    tableau = _Tableau(columns[1:], [Fraction(0)] * (len(columns) - 1))
    if tableau.solve([-value for value in columns[0]]) is not None:
        return True
    # The ray is a wrench that does work on the load for which no contact makes up.
    y = np.array([float(value) for value in tableau.ray])
    missed = -float(y @ model.load)
    for i, (limit, sigma) in enumerate(zip(limits, _supports(model, y), strict=True)):
        missed -= float(limit) * (sigma if force[i] else max(sigma, 0.0))
    return missed <= MISSED * float(np.linalg.norm(y))


def _supports(model: Statics, y: Array) -> list[float]:
    """Return per finger the most work that y (6,) gets from a unit normal force."""
    s, found = model.edges, []
    for i in range(model.fingers):
        tips = slice(i * s, (i + 1) * s)
        found.append(float(((y @ model.rob_wrenches[:, tips]) / model.normal_parts[i, tips]).max()))
    return found


def _columns(
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
_SIDES: list[list[int]] = [
    *([sign * (i == j) for j in range(6)] for i in range(6) for sign in (1, -1)),
    *([1 - 2 * (code >> (5 - j) & 1) for j in range(6)] for code in range(64)),
]
"""The directions of ``stability.DIRECTIONS`` without their length, which is that of"""
_LENGTHS = [Fraction(_K)] * 12 + [Fraction(_K / np.sqrt(6.0))] * 64


class _Tableau:
    """Dual simplex on integers: true entries are ``rows`` over ``denominator``.

    Columns: the program's, then one artificial variable per row, fixed at zero, which hold the
    inverse of the basis. The last row holds the reduced costs, none of which may begin below 0.
    """

    def __init__(self, columns: Sequence[Sequence[Fraction]], costs: Sequence[Fraction]) -> None:
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


@dataclass(frozen=True, eq=False)
class ExactBest:
    """z for the best f_com, exact but for the last digit.

    Attributes:
        z: 0 where no f_com resists all directions; +inf where one does to any degree.
        f_com: (n,), 0 under position control.
        direction: number of a direction that limits z, or -1.
    """

    z: float
    f_com: Array
    direction: int


def exact_best(model: Statics, force: BoolArray) -> ExactBest:
    """Solve Problem (6) for the best f_com.

    A few directions in one program give f_com and a bound on z; the direction that this f_com
    resists least joins them, until it is resisted as well.

    Args:
        model: the mechanics.
        force: (n,), which fingers are force-controlled.
    """
    limits: list[Fraction] = [Fraction(most) for most in model.f_max.tolist()]
    for i in np.flatnonzero(force).tolist():
        limits[i] /= 2
    chosen, z = list[int](), None
    while True:
        found = exact_margin(model, limits, force)
        f_com = np.where(force, [float(limit) for limit in limits], 0.0)
        resisted = z is not None and found.tau is not None and found.tau * z <= 1
        if resisted or not force.any() or found.z == np.inf:
            return ExactBest(found.z, f_com, found.direction)
        chosen.append(found.direction)
        tau, f = _joint(model, force, chosen)
        if tau is None:
            return ExactBest(0.0, f_com, found.direction)
        if tau == 0:
            return ExactBest(np.inf, f_com, -1)
        z = 1 / tau
        for i in np.flatnonzero(force).tolist():
            limits[i] = f[i] / tau


def _joint(
    model: Statics, force: BoolArray, chosen: Sequence[int]
) -> tuple[Fraction | None, list[Fraction]]:
    """Return 1 / z for some directions, None where z is 0, and (n,) f_com / z that allows it.

    The tau program of every direction, with one tau, and f_com tau as variables.
    """
    n, rows = model.fingers, 6 + model.fingers
    limits = [
        Fraction(0) if force[i] else Fraction(most) for i, most in enumerate(model.f_max.tolist())
    ]
    tau, *columns = _columns(model, limits, force)
    caps = np.flatnonzero(force).tolist()
    height = rows * len(chosen) + len(caps)
    nothing = [Fraction(0)] * rows

    def stacked(
        block: Sequence[Fraction], k: int, end: Sequence[int | Fraction] = ()
    ) -> list[Fraction]:
        """Return a column with ``block`` in the rows of direction k (-1: of all)."""
        whole = [block if k in (-1, j) else nothing for j in range(len(chosen))]
        tail = [Fraction(value) for value in end] or [Fraction(0)] * len(caps)
        return [value for part in whole for value in part] + tail

    program = [stacked(tau, -1, [-Fraction(model.f_max[i]) for i in caps])]
    for at, i in enumerate(caps):
        commanded = [Fraction(-(row == 6 + i)) for row in range(rows)]
        program.append(stacked(commanded, -1, [int(other == at) for other in range(len(caps))]))
    for at in range(len(caps)):
        program.append(stacked(nothing, -1, [int(other == at) for other in range(len(caps))]))
    program += [stacked(column, k) for k in range(len(chosen)) for column in columns]
    side: list[int | Fraction] = []
    for number in chosen:
        side += [sign * _LENGTHS[number] for sign in _SIDES[number]] + [0] * n
    side += [0] * (height - len(side))
    tableau = _Tableau(program, [Fraction(1)] + [Fraction(0)] * (len(program) - 1))
    least = tableau.solve(side)
    f = [Fraction(0)] * n
    for at, i in enumerate(caps):
        f[i] = tableau.value(1 + at, side)
    return least, f
