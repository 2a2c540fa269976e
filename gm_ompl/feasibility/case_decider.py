"""Mode decisions for all cases at once, where a problem says what is not known exactly."""

from __future__ import annotations

from itertools import pairwise
from typing import final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.state import ContactState
from gm_ompl.cores import share_out
from gm_ompl.feasibility.keys import spots
from gm_ompl.mechanics.batch import Decisions, unanswered
from gm_ompl.mechanics.case_alternatives import CaseAlternatives
from gm_ompl.mechanics.central import Answer
from gm_ompl.mechanics.family import hand_tips, surroundings
from gm_ompl.mechanics.robust import (
    Surroundings,
    Tips,
    cases_at,
    decide_case_rows,
    decide_cases,
)
from gm_ompl.problem import Problem


@final
class CaseDecider:
    """Asks the kernel about the cases of one problem's contact states.

    Args:
        problem: whose.
        U: (6, 6), see ``wrench_norm``.

    Attributes:
        tips: the columns of the hand at every placement.
    """

    def __init__(self, problem: Problem, U: Array) -> None:
        hand = problem.fingers
        self.tips: Tips = hand_tips(
            *spots(problem), hand.friction, hand.soft, problem.mechanics.cone_edges, U,
            problem.uncertainty, f_max=hand.max_normal_force / problem.force_scale,
        )  # fmt: skip
        self._problem, self._U, self._scale = problem, U, problem.force_scale
        self._around: dict[int, Surroundings] = {}
        self._loads: dict[bytes, Array] = {}

    def register(self, number: int, contacts: ContactState) -> None:
        """Keep the columns of a contact state."""
        instant = self._problem.instant(contacts, (), ())
        found = surroundings(instant, self._problem.uncertainty, self._U, self._loads)
        self._around[number] = found

    def load(self, environment: int, number: int) -> Array:
        """Return a load (6,) of a contact state."""
        load: Array = self._around[environment].loads[number]
        return load

    def decide(
        self, environment: int, hand: IntArray, rows: IntArray, below: float, f_com: Array,
        y: Array,
    ) -> tuple[Answer, int]:  # fmt: skip
        """Return the kernel's answer, and under which load ``y`` is a cut.

        Args:
            environment: number of the contact state.
            hand: (k,), who touches.
            rows: (k,), where.
            below: in the scenario's units, a threshold.
            f_com: output (k,).
            y: output (6,).
        """
        cases = cases_at(self._around[environment], self.tips, hand, rows)
        end, z, direction, mask, load = decide_cases(cases, below / self._scale, -1, -1, f_com, y)
        return (end, z, direction, mask), load

    def decide_many(self, which: IntArray, rows: IntArray, below: float) -> Decisions:
        """Return the answers for the whole hand at many placements (K, n).

        ``which`` (K,) are the contact states.
        """
        answers = unanswered(*rows.shape)
        order = np.argsort(which, kind="stable")

        def work(part: slice) -> None:
            own = order[part]
            cuts = np.flatnonzero(np.diff(which[own], prepend=-1, append=-1))
            for a, b in pairwise(cuts.tolist()):
                around = self._around[which[own[a]]]
                decide_case_rows(around, self.tips, below / self._scale, rows, own[a:b], answers)

        share_out(work, len(rows))
        return answers

    def alternatives(self, environment: int, hand: IntArray, rows: IntArray) -> CaseAlternatives:
        """Return what Sec. 3.4 could have chosen; arguments as for ``decide``."""
        return CaseAlternatives(self._scale, self._around[environment], self.tips, hand, rows)
