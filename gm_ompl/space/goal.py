"""The goal for OMPL: a region from which states are drawn, and draws that lean to what works."""

from __future__ import annotations

import math
from typing import Any, final

from ompl import base as ob

from gm_ompl.sampling.motions import UNPLACED, HybridState
from gm_ompl.space.convert import Codec
from gm_ompl.space.draws import StateDraws
from gm_ompl.space.guard import Guard


@final
class GoalRegion(ob.GoalSampleableRegion):
    """All valid placements with the object in the goal.

    Args:
        si: OMPL's space information.
        codec: the state space.
        draws: where states come from.
        guard: keeps errors.
        count: how many different goal states to draw at most.
        elsewhere: the share of draws that are not goal states but states from anywhere. OMPL
            offers no other way to bring samplers of one's own to planners with a goal bias; what
            is a goal is still decided by ``distanceGoal``.
    """

    def __init__(
        self,
        si: Any,
        codec: Codec,
        draws: StateDraws,
        guard: Guard,
        count: int,
        elsewhere: float = 0.0,
    ) -> None:
        super().__init__(si)
        self._codec, self._draws, self._guard = codec, draws, guard
        self._count, self._elsewhere = count, elsewhere

    def distanceGoal(self, state: Any) -> float:
        """Return how far ``state`` is from the goal, 0 inside; relative to the ranges."""
        try:
            return self._distance(self._codec.read(state))
        except BaseException as error:
            self._guard.keep(error)
            return math.inf

    def _distance(self, state: HybridState) -> float:
        goal = self._codec.problem.goal
        wanted = zip(state.placements, self._codec.problem.fingers.goal, strict=True)
        wrong = sum(
            have == UNPLACED or (want is not None and have != want) for have, want in wanted
        )
        away = 0.0 if goal.contains(state.q) else max(self._draws.to_goal(state.q), 1e-9)
        return float(wrong + away)

    def sampleGoal(self, state: Any) -> None:
        """Draw a goal state (or, as the share ``elsewhere`` says, any state) into ``state``.

        Where none is found the result is no valid state.
        """
        try:
            draws, guard = self._draws, self._guard
            anywhere = self._elsewhere and draws.rng.random() < self._elsewhere
            drawn = None
            if not guard.closed():
                drawn = draws.anywhere() if anywhere else draws.goal()
            self._codec.write(state, drawn or self._codec.nowhere, draws.rng.random())
        except BaseException as error:
            self._guard.keep(error)

    def maxSampleCount(self) -> int:
        """Return how many goal states there are to draw."""
        return self._count
