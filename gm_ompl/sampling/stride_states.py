"""What judging a stride of free motion needs, found once for all that are alike."""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple, final

from gm_ompl.arrays import BoolArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.problem import Problem
from gm_ompl.sampling.screws import Stride


class StatesAlong(NamedTuple):
    """What judging a stride needs.

    Attributes:
        numbers: contact states of its segments.
        free: (placements,) per finger, where fingertips are free all along.
    """

    numbers: tuple[int, ...]
    free: tuple[BoolArray, ...]


@final
class StrideStates:
    """What judging strides needs.

    Args:
        judge: answers about the problem.
    """

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._known: dict[Hashable, StatesAlong | None] = {}

    def of(self, stride: Stride) -> StatesAlong | None:
        """Return what judging a stride needs; None where the object penetrates something."""
        arc = stride.arc
        key: Hashable = (stride.tail, arc.head, arc.arc.key) if arc.kind is None else arc.kind
        if key not in self._known:
            along, found = self._judge.along(arc.arc), None
            if along.object_free:
                found = StatesAlong(self._judge.environments(arc), along.free)
            self._known[key] = found
        return self._known[key]


def may_lift(problem: Problem) -> bool:
    """Whether a hand may carry the object where it touches nothing.

    Two points of contact resist no moment about the line that joins them.
    """
    hand, needed = problem.fingers, problem.mechanics.z_min > 0.0
    return not (needed and not hand.soft.any() and hand.count < 3)
