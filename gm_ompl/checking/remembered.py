"""What programs at earlier instants have proven, tried on the present one.

Along an arc the contact state changes a little from segment to segment. What proved the verdict of
Problem (5) then mostly does so again, as the bases of Problem (6) do (``reference/bases.py``).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.state import Instant
from gm_ompl.reference import highs
from gm_ompl.reference.bases import Bases, Margins
from gm_ompl.reference.cases import Case, cases, hardest, most_command
from gm_ompl.reference.internal_force import (
    InternalForce,
    cancelling,
    certify,
    judged,
    unit_wrenches,
)
from gm_ompl.reference.modes import squeezed
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.stability import DIRECTIONS, NEGLIGIBLE
from gm_ompl.reference.statics import Statics


class Mechanics(NamedTuple):
    """An instant's matrices.

    Attributes:
        cases: those of Problem (6), one case where nothing is uncertain.
        squeezed: those of Problem (5).
    """

    cases: tuple[Case, ...]
    squeezed: tuple[Statics, ...]


def mechanics(instant: Instant) -> Mechanics:
    """Return an instant's matrices."""
    return Mechanics(hardest(cases(instant)), squeezed(instant))


class Remembered:
    """Bases by direction, and certificates of Problem (5), under keys that name like instants.

    Attributes:
        bases: the bases.
    """

    def __init__(self) -> None:
        self.bases = Bases()
        self._verdicts: dict[Hashable, InternalForce] = {}

    def excessive(self, key: Hashable, models: Sequence[Statics], position: frozenset[int]) -> bool:
        """Whether Problem (5) finds excessive internal force with the columns of all models.

        Raises:
            SolverError: the solver returned no answer.
        """
        last = self._verdicts.get(key)
        A = np.hstack([unit_wrenches(model, position) for model in models])
        verdict = None if last is None else _again(last, A)
        if verdict is None:
            verdict = judged(A)
        self._verdicts[key] = verdict
        return verdict.excessive


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


def bound(among: Sequence[Case], force: BoolArray, found: Sequence[Margins]) -> float:
    """Return a bound on z over all f_com, from the multipliers at one, in units of the scale.

    Multipliers y of direction i prove ``z_i <= (y . (load, -limits)) / (y . l_i)`` whatever the
    limits are; the largest z within all 76, of all cases, is the bound.

    Raises:
        SolverError: the solver returned no answer.
    """
    rows = [_cuts(case, force, margins) for case, margins in zip(among, found, strict=True)]
    slopes, level = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    n = slopes.shape[1]
    solution = highs.solve(
        LinearProgram(
            cost=np.append(1.0, np.zeros(n)),
            matrix=sparse.csc_array(np.hstack([np.ones((len(level), 1)), slopes])),
            row_lower=np.full(len(level), -np.inf),
            row_upper=level,
            col_lower=np.zeros(1 + n),
            col_upper=np.append(np.inf, most_command(among)[force]),
            maximise=True,
        )
    )
    if solution.status is LpStatus.INFEASIBLE:
        return 0.0
    return solution.objective if solution.status is LpStatus.OPTIMAL else np.inf


def _cuts(case: Case, force: BoolArray, found: Margins) -> tuple[Array, Array]:
    """Return slopes (k, n) and levels (k,) of cuts z + slopes . f_com <= level in one case."""
    model = case.model
    price = np.einsum("ij,ij->i", found.dual[:, :6], DIRECTIONS)
    cuts = np.flatnonzero(price > NEGLIGIBLE)
    y = found.dual[cuts] / price[cuts, None]
    level = y[:, :6] @ model.load - y[:, 6:][:, ~force] @ model.f_max[~force]
    return (y[:, 6:] * case.press)[:, force], level
