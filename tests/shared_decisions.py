"""Decisions that several searches share."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.feasibility.keys import contact_key
from gm_ompl.problem import Problem
from gm_ompl.reference.modes import Modes, decide_modes


@final
class SharedDecisions:
    """The reference's mode decisions, each made once for all searches of one problem."""

    def __init__(self, problem: Problem) -> None:
        self._diagonal = problem.body.diagonal
        self._memo: dict[tuple[object, ...], ModeDecision] = {}

    def __call__(self, instant: Instant, prefer: Modes | None = None) -> ModeDecision:
        key = (
            contact_key(instant.contacts, self._diagonal),
            np.round(instant.points / self._diagonal, 9).tobytes(),
            instant.max_normal_force.tobytes(),
            instant.friction.tobytes(),
        )
        if key not in self._memo:
            self._memo[key] = decide_modes(instant, prefer)
        return self._memo[key]
