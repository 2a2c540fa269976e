"""Problems whose fingers may be at a few points of the faces, and judges of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.holds.spots import Spot, Spots


@final
class Placing:
    """Makes judges of a problem with other placements.

    Args:
        judge: of the problem, which asks for placements anywhere on faces.

    Attributes:
        spots: where fingers may be placed.
        gap: by how much a plan may be dearer than the least, relatively.
    """

    def __init__(self, judge: Judge) -> None:
        where, backend = judge.problem.fingers.anywhere, judge.backend
        assert where is not None, "the scenario asks for it"
        assert isinstance(backend, KernelBackend), "the scenario asks for it"
        self._judge, self._backend = judge, backend
        self.spots, self.gap = Spots(judge.problem), where.gap
        self._open: list[Judge] = []
        self._done = 0

    @property
    def mode_decisions(self) -> int:
        """Mode decisions that all judges made so far."""
        return self._done + sum(judge.mode_decisions for judge in self._open)

    def judge(self, spots: Iterable[Spot]) -> Judge:
        """Return a judge of the problem with these placements, until it is ``done``."""
        problem = self.spots.placed(spots)
        judge = self._judge.of_hand(problem, self._backend.of_hand(problem))
        self._open.append(judge)
        return judge

    def done(self, judge: Judge) -> None:
        """Let go of a judge; its decisions stay counted."""
        self._open.remove(judge)
        self._done += judge.mode_decisions
