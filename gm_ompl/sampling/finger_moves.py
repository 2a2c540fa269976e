"""Local moves of a plan's fingers: other points of the faces around those that it names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

import numpy as np

from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.holds.spots import PlacedPlan
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Move, Problem
from gm_ompl.sampling.lane_sample import LaneSample
from gm_ompl.sampling.lane_store import LaneStore
from gm_ompl.sampling.near import FIRST_REACH, SETS, Near, hand_of
from gm_ompl.sampling.placing import Placing
from gm_ompl.sampling.plan_way import way_and_legs
from gm_ompl.sampling.route import Route

NEAREST: Final = 0.02
"""How near points come, in half sizes of the face: this much of the gap that is asked for."""

LITTLE: Final = 0.1
"""Points come nearer where a move gains less than this much of the gap."""

TRIED: Final = 100
"""Plans judged per move at most."""


@final
class FingerMoves:
    """A plan whose fingers are moved, a little less each time that it does not pay.

    The object keeps its way; where on it fingers are regrasped, each move finds anew.

    Args:
        placing: makes problems of few placements.
        problem: what was planned, with the table that the moves name.
        moves: the plan, at least one move.
        rng: the source of randomness.

    Attributes:
        plan: the best so far; its cost is +inf as long as none was judged.
        over: whether no move is left to try.
    """

    def __init__(
        self, placing: Placing, problem: Problem, moves: Sequence[Move], rng: np.random.Generator
    ) -> None:
        self._placing, self._rng = placing, rng
        self._way, legs = way_and_legs(problem, moves)
        table, self._reach, self._alone = problem.fingers.placements, FIRST_REACH, False
        self.plan = PlacedPlan(tuple(moves), table, math.inf)
        self._hands = [hand_of(placing.spots, table, lane) for lane, _, _ in legs]

    @property
    def over(self) -> bool:
        """Whether no move is left to try."""
        return self._reach < NEAREST * self._placing.gap

    def step(self, stop: Stop) -> bool:
        """Try the moves around the plan at once; return whether the best of them is cheaper.

        Those of several fingers at once come first; where they do not pay, those of one alone; then
        points come nearer.
        """
        if self.plan.cost == math.inf:
            return self._look(0.0, 1, stop)
        before = self.plan.cost
        better = self._look(self._reach, 1 if self._alone else SETS, stop)
        if not better or before - self.plan.cost < LITTLE * self._placing.gap * self.plan.cost:
            self._reach /= 2.0 if self._alone else 1.0
            self._alone = not self._alone
        return better

    def _look(self, reach: float, most: int, stop: Stop) -> bool:
        placing = self._placing
        near = Near.around(placing, self._hands, reach, self._rng)
        judge = near.judge(placing)
        problem = judge.problem
        try:
            sets = PlacementSets(problem.fingers.groups())
            sample = LaneSample(problem, LaneStore(judge, sets, Route(judge, self._way)))
            sample.add(near.sets(placing, judge, most, self._rng))
            legs = sample.improve(self.plan.cost, TRIED, stop)
            if legs is None:
                return False
            moves = moves_of(judge, self._way, legs)
        finally:
            placing.done(judge)
        table = problem.fingers.placements
        self._hands = [hand_of(placing.spots, table, lane) for lane, _, _ in legs]
        self.plan = PlacedPlan(moves, table, math.fsum(move.cost for move in moves))
        return True
