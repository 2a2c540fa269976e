"""Problem (6) for the best f_com, in exact arithmetic: by cutting planes, or in one program."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.reference.exact import LENGTHS, SIDES, Effort, ExactTableau, columns_of, exact_margin
from gm_ompl.reference.statics import Statics

ROUNDS = 60
"""Cuts on z(f_com) at most."""
GAP = 1e-9
"""Cutting stops where both bounds on z lie within this, relative to max(z, 1e-2)."""


class ExactBest(NamedTuple):
    """z for the best f_com, between two bounds that are exact but for the last digit.

    Attributes:
        least: z at ``f_com``.
        most: no f_com does better; negative where no forces balance the load.
        f_com: (n,), 0 under position control.
        direction: number of a direction that limits z, or -1.
    """

    least: float
    most: float
    f_com: Array
    direction: int


def exact_best(model: Statics, force: BoolArray, effort: Effort) -> ExactBest:
    """Solve Problem (6) for the best f_com by exact cuts z <= c + slopes . f_com (Kelley).

    Args:
        model: the mechanics.
        force: (n,), which fingers are force-controlled.
        effort: what it may cost.

    Raises:
        SolverError: where that does not suffice.
    """
    return exact_common([model], [np.ones(model.fingers)], model.f_max, force, effort)


def exact_common(
    models: Sequence[Statics], presses: Sequence[Array], most_f: Array, force: BoolArray,
    effort: Effort,
) -> ExactBest:  # fmt: skip
    """Solve Problem (6) likewise for the f_com that is best in the worst of several cases.

    Args:
        models: the mechanics of each case.
        presses: (n,) per case, what a command of 1 presses with.
        most_f: (n,), the largest commands.
        force: (n,), which fingers are force-controlled.
        effort: what it may cost.

    Raises:
        SolverError: where that does not suffice.
    """
    f_com, best, cuts = 0.5 * most_f, None, list[tuple[float, Array]]()
    while True:
        found, ceiling, bounded = None, np.inf, False
        for model, press in zip(models, presses, strict=True):
            limits = np.where(force, f_com * press, model.f_max)
            margin = exact_margin(model, limits.tolist(), force, effort)
            at = np.inf
            if margin.wrench:
                c, slopes = _cut(model, margin.wrench, force)
                cuts.append((c, slopes * press[force]))
                at, bounded = c + float(slopes @ limits[force]), True
            if found is None or margin.z < found.z:
                found = margin
            ceiling = min(ceiling, at)
        assert found is not None, "there is a case"
        z = min(found.z, max(ceiling, 0.0))
        if best is None or z > best.least or (z == best.least and ceiling > best.most):
            best = ExactBest(z, ceiling, np.where(force, f_com, 0.0), found.direction)
        if not force.any() or not bounded:
            return best
        most, f = _trial(cuts, most_f[force], effort)
        if most - best.least <= GAP * max(most, 1e-2) or len(cuts) >= ROUNDS * len(models):
            return best._replace(most=most)
        f_com = most_f.copy()
        f_com[force] = f


def _trial(
    cuts: Sequence[tuple[float, Array]], f_max: Array, effort: Effort
) -> tuple[float, Array]:
    """Return the largest z under the cuts, and the f_com that allows it.

    Solved as its dual: min c . mu + f_max . nu, sum mu = 1, nu >= sum_j mu_j slopes_j, with z
    shifted so that all costs are positive.
    """
    n = len(f_max)
    shift = 1.0 - min(c for c, _ in cuts)
    costs = [Fraction(c) + Fraction(shift) for c, _ in cuts]
    columns = [[Fraction(1), *(-Fraction(s) for s in slopes.tolist())] for _, slopes in cuts]
    for i, most in enumerate(f_max.tolist()):
        for sign, cost in ((1, Fraction(most)), (-1, Fraction(0))):
            columns.append([Fraction(sign * (j == 1 + i)) for j in range(1 + n)])
            costs.append(cost)
    tableau = ExactTableau(columns, costs, effort)
    z = tableau.solve([1])
    assert z is not None, "weights that add up to 1 exist"
    f = [min(max(float(value), 0.0), most) for value, most in
         zip(tableau.duals()[1 : 1 + n], f_max.tolist(), strict=True)]  # fmt: skip
    return float(z - Fraction(shift)), np.array(f)


def _cut(model: Statics, y: Sequence[Fraction], force: BoolArray) -> tuple[float, Array]:
    """Return c and the slopes of the cut that an exact wrench in the polar gives."""

    def dot(column: Array) -> Fraction:
        return sum((a * Fraction(b) for a, b in zip(y, column.tolist(), strict=True)), Fraction(0))

    h = max(dot(np.array(side, dtype=float)) * length
            for side, length in zip(SIDES, LENGTHS, strict=True))  # fmt: skip
    c, slopes = dot(model.load), []
    for i, own in enumerate(model.columns):
        sigma = max(
            dot(model.rob_wrenches[:, j]) / Fraction(float(model.normal_parts[i, j]))
            for j in range(own.start, own.stop)
        )
        if force[i]:
            slopes.append(float(sigma / h))
        else:
            c += Fraction(float(model.f_max[i])) * max(sigma, Fraction(0))
    return float(c / h), np.array(slopes)


def joint_best(model: Statics, force: BoolArray, effort: Effort) -> ExactBest:
    """Solve Problem (6) for the best f_com.

    A few directions in one program give f_com and a bound on z; the direction that this f_com
    resists least joins them, until it is resisted as well.

    Args:
        model: the mechanics.
        force: (n,), which fingers are force-controlled.
        effort: what it may cost.

    Raises:
        SolverError: where that does not suffice.
    """
    limits: list[Fraction] = [Fraction(most) for most in model.f_max.tolist()]
    for i in np.flatnonzero(force).tolist():
        limits[i] /= 2
    chosen, z = list[int](), None
    while True:
        found = exact_margin(model, limits, force, effort)
        f_com = np.where(force, [float(limit) for limit in limits], 0.0)
        resisted = z is not None and found.tau is not None and found.tau * z <= 1
        if resisted or not force.any() or found.z == np.inf:
            return ExactBest(found.z, found.z, f_com, found.direction)
        chosen.append(found.direction)
        tau, f = _joint(model, force, chosen, effort)
        if tau is None:
            return ExactBest(0.0, 0.0, f_com, found.direction)
        if tau == 0:
            return ExactBest(np.inf, np.inf, f_com, -1)
        z = 1 / tau
        for i in np.flatnonzero(force).tolist():
            limits[i] = f[i] / tau


def _joint(
    model: Statics, force: BoolArray, chosen: Sequence[int], effort: Effort
) -> tuple[Fraction | None, list[Fraction]]:
    """Return 1 / z for some directions, None where z is 0, and (n,) f_com / z that allows it.

    The tau program of every direction, with one tau, and f_com tau as variables.
    """
    n, rows = model.fingers, 6 + model.fingers
    limits = [
        Fraction(0) if force[i] else Fraction(most) for i, most in enumerate(model.f_max.tolist())
    ]
    tau, *columns = columns_of(model, limits, force)
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
        side += [sign * LENGTHS[number] for sign in SIDES[number]] + [0] * n
    side += [0] * (height - len(side))
    tableau = ExactTableau(program, [Fraction(1)] + [Fraction(0)] * (len(program) - 1), effort)
    least = tableau.solve(side)
    f = [Fraction(0)] * n
    for at, i in enumerate(caps):
        f[i] = tableau.value(1 + at, side)
    return least, f
