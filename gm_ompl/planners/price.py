"""A price on regrasps that cost nothing: of plans of equal cost, those with fewest come first.

Where X_regr is 0, searches would be free to regrasp for nothing, also in circles. They are given
the same problem with a price far below every cost that is told apart, and their plans are then
counted by the true costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from gm_ompl.problem import Move, Problem, Regrasp

LEAST: Final = 1e-9
"""The least price, in diagonals of the object: far above rounding, and hundreds of regrasps are
still far below the relative 1e-6 to which a plan is optimal."""


def priced(problem: Problem) -> Problem:
    """Return the problem that is searched: as it is, but for regrasps dearer than nothing."""
    least = LEAST * problem.body.diagonal
    if problem.cost.regrasp >= least:
        return problem
    return replace(problem, cost=replace(problem.cost, regrasp=least))


def at_true_cost(problem: Problem, moves: Sequence[Move]) -> tuple[Move, ...]:
    """Return ``moves``, found on the priced problem, with the costs of ``problem``."""
    cost = problem.cost.regrasp
    return tuple(replace(m, cost=cost) if isinstance(m, Regrasp) else m for m in moves)
