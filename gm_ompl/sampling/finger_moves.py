"""Local moves of a plan's fingers: other points of the faces around those that it names."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Final, final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.holds.spots import Spot, rows_of
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Move, Problem
from gm_ompl.sampling.lane_sample import LaneSample
from gm_ompl.sampling.lane_store import LaneStore, SetDraw, as_sets
from gm_ompl.sampling.placing import Placing
from gm_ompl.sampling.plan_way import way_and_legs
from gm_ompl.sampling.route import Route

FIRST_REACH: Final = 0.25
"""How far away points are first, in half sizes of the face."""

NEAREST: Final = 0.02
"""How near they come: this much of the gap that the scenario asks for."""

LITTLE: Final = 0.1
"""Points come nearer where a move gains less than this much of the gap."""

SETS: Final = 512
"""Sets around one of the plan's at most; beyond, they are drawn at random."""

TRIED: Final = 20
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
        moves: the best plan so far.
        table: the placements that it names.
        cost: its cost, +inf as long as none was judged.
        over: whether no move is left to try.
    """

    def __init__(
        self, placing: Placing, problem: Problem, moves: Sequence[Move], rng: np.random.Generator
    ) -> None:
        self._placing, self._rng, self._gap = placing, rng, placing.gap
        self._way, self._legs = way_and_legs(problem, moves)
        self.moves, self.table = tuple(moves), problem.fingers.placements
        self.cost, self._reach = math.inf, FIRST_REACH

    @property
    def over(self) -> bool:
        """Whether no move is left to try."""
        return self._reach < NEAREST * self._gap

    def step(self, stop: Stop) -> bool:
        """Try the moves around the plan at once; return whether the best of them is cheaper."""
        before = self.cost
        better = self._look(stop)
        if not better or before - self.cost < LITTLE * self._gap * self.cost:
            self._reach /= 2.0
        return better

    def _look(self, stop: Stop) -> bool:
        placing, spots = self._placing, self._placing.spots
        places = {row: spots.of(self.table, row) for row in rows_of(self.moves)}
        near = {row: spots.around([place], self._reach) for row, place in places.items()}
        judge = placing.judge(itertools.chain.from_iterable(near.values()))
        try:
            sample = self._sample(judge, near)
            legs = sample.improve(self.cost, TRIED, stop)
            if legs is None:
                return False
            self.moves = moves_of(judge, self._way, legs)
        finally:
            placing.done(judge)
        self._legs, self.table = legs, judge.problem.fingers.placements
        self.cost = math.fsum(move.cost for move in self.moves)
        return True

    def _sample(self, judge: Judge, near: Mapping[int, Sequence[Spot]]) -> LaneSample:
        """Return the lanes whose fingers are near those of the plan's."""
        problem, spots = judge.problem, self._placing.spots
        table, rows = problem.fingers.placements, defaultdict[Spot, list[int]](list)
        for row in range(len(table)):
            rows[spots.of(table, row)].append(row)
        store = LaneStore(judge, PlacementSets(problem.fingers.groups()), Route(judge, self._way))
        sample, draw = LaneSample(problem, store), SetDraw(problem, judge, 0.0, 1.0)
        for lane, _, _ in self._legs:
            options = [[r for spot in near[row] for r in rows[spot]] for row in lane]
            sample.add(draw.fitting(self._sets(options)))
        return sample

    def _sets(self, options: Sequence[Sequence[int]]) -> IntArray:
        """Return one of its options per finger: all combinations, or some at random if many."""
        if math.prod(map(len, options)) <= SETS:
            return as_sets(itertools.product(*options), len(options))
        sets = np.stack([self._rng.choice(rows, size=SETS) for rows in options], axis=1)
        for i, rows in enumerate(options):
            sets[: SETS // 2, i] = rows[0]  # one finger elsewhere, or none
        k = 0
        for i, rows in enumerate(options):
            for row in rows:
                sets[k % (SETS // 2), i] = row
                k += 1
        return sets
