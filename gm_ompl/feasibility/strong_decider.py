"""Decisions by z_strong for the placements of one problem."""

from __future__ import annotations

from typing import TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.contact.state import ContactState
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.program import Program
from gm_ompl.mechanics.strongest import Met, StrongHand, as_strong, environment_rows
from gm_ompl.problem import Placements, Problem

Columns: TypeAlias = tuple[Array, Array, Array]
"""The environment's (e, 6), the load (6,), the fingers' at all placements (n, P, s, 6)."""


@final
class StrongDecider:
    """Looks for modes and commands that are best for z_strong.

    Args:
        problem: whose placements.
        U: (6, 6), see ``wrench_norm``.
    """

    def __init__(self, problem: Problem, U: Array) -> None:
        self._scale, self._U = problem.force_scale, U
        self._mu = problem.environment.friction
        self._met: Met = {}
        self._friction = problem.fingers.friction
        self._limits = problem.fingers.max_normal_force
        self._f_max = self._limits / self._scale

    def decide(
        self, z: float, contacts: ContactState, columns: Columns, hand: IntArray,
        rows: Placements, below: float,
    ) -> ModeDecision | None:  # fmt: skip
        """Return the decision for fingers ``hand`` at ``rows``; None where nothing is proven.

        Where z_strong stays below ``below``, as it does where the best ``z`` is, it is BELOW.
        """
        if z < below:
            return ModeDecision(Outcome.BELOW, z)
        env, q, tips = columns
        around = environment_rows(contacts, np.full(len(contacts.points), self._mu), env, self._U)
        own = tips[hand, np.array(rows, dtype=np.int64)]
        program = Program(env, q, own, self._f_max[hand], DIRECTIONS)
        asked = StrongHand(around, program, self._friction[hand], self._met)
        best = asked.best(below / self._scale)
        if asked.lost:
            return None
        return as_strong(best, asked.bound, self._scale, self._limits[hand], below)
