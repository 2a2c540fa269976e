"""A search that ends at its first plan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Move
from gm_ompl.sampling.explorer import Course, Explorer


@final
class FirstPlan:
    """An explorer that turns what it finds into moves.

    Args:
        judge: answers about the problem.
        explorer: searches.

    Attributes:
        cost: of the plan, +inf without one.
        moves: the plan's.
    """

    def __init__(self, judge: Judge, explorer: Explorer) -> None:
        self._judge, self._explorer = judge, explorer
        self.cost, self.moves = math.inf, tuple[Move, ...]()

    @property
    def branches(self) -> int:
        """Branches of all trees."""
        return self._explorer.branches

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far."""
        return self._explorer.courses

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether it found a plan."""
        found = self._explorer.step(stop)
        if found is None:
            return False
        course, legs = found
        moves = moves_of(self._judge, course.store.route.way, legs)
        self.cost, self.moves = math.fsum(move.cost for move in moves), moves
        return True
