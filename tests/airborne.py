"""Plans that tests assemble by hand: their regrasps need ways through the air."""

from __future__ import annotations

from collections.abc import Sequence

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.ways import with_ways
from gm_ompl.problem import Move, Problem


def airborne(problem: Problem, moves: Sequence[Move]) -> tuple[Move, ...]:
    """The moves, each regrasp with its way."""
    return with_ways(Judge(problem, make_backend(problem)).reach, moves)
