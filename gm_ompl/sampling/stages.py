"""A plan as stages: what refinement changes, and how it is judged anew."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

from gm_ompl.caches import Memo
from gm_ompl.holds.goals import fits
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Displacement, Move, Placements, Regrasp
from gm_ompl.sampling.motions import ContinuousModel, HybridState

Way: TypeAlias = tuple[Coordinates, Coordinates, Placements]
"""From where to where, and the placements."""

DISPLACEMENT_BYTES: Final = 5000
"""About what a judged displacement takes."""


@dataclass(frozen=True)
class Stage:
    """A stretch of a plan between two regrasps.

    Attributes:
        placements: per physical finger.
        points: the object's way, a polyline; a single point where it rests.
    """

    placements: Placements
    points: tuple[Coordinates, ...]


Stages: TypeAlias = tuple[Stage, ...]
"""Each starts where the last one ends, with one finger elsewhere."""


def stages_of(moves: Sequence[Move]) -> Stages:
    """Return the stages of a plan that has at least one move."""
    first = moves[0]
    points = [first.start if isinstance(first, Displacement) else first.at]
    placements, stages = first.placements, []
    for move in moves:
        if isinstance(move, Displacement):
            points.append(move.end)
        else:
            stages.append(Stage(placements, tuple(points)))
            placements, points = after(move), [points[-1]]
    return (*stages, Stage(placements, tuple(points)))


def after(move: Regrasp) -> Placements:
    """Return the placements after a regrasp."""
    return (*move.placements[: move.finger], move.target, *move.placements[move.finger + 1 :])


def states_along(moves: Sequence[Move]) -> Iterator[HybridState]:
    """Yield the states that ``moves`` lead through, first and last included."""
    for k, move in enumerate(moves):
        if isinstance(move, Displacement):
            if k == 0:
                yield HybridState(move.start, move.placements)
            yield HybridState(move.end, move.placements)
        else:
            if k == 0:
                yield HybridState(move.at, move.placements)
            yield HybridState(move.at, after(move))


def changed(a: Placements, b: Placements) -> list[int]:
    """Return the fingers that are elsewhere."""
    return [i for i, (u, v) in enumerate(zip(a, b, strict=True)) if u != v]


@final
class StageJudge:
    """Judges stages; what was judged before is remembered.

    Args:
        model: expands motions.
    """

    def __init__(self, model: ContinuousModel) -> None:
        self._model = model
        self._known = Memo[Way, tuple[Displacement, ...] | None](DISPLACEMENT_BYTES)

    def moves(self, stages: Stages, below: float = math.inf) -> tuple[Move, ...] | None:
        """Return the moves of ``stages``; None where one fails or the cost is not below."""
        model = self._model
        hand = model.problem.fingers
        if not (fits(stages[0].placements, hand.start) and fits(stages[-1].placements, hand.goal)):
            return None
        moves: list[Move] = []
        cost = (len(stages) - 1) * model.problem.cost.regrasp
        for k, stage in enumerate(stages):
            if k:
                regrasp = self._regrasp(stages[k - 1], stage)
                if regrasp is None:
                    return None
                moves.append(regrasp)
            for a, b in itertools.pairwise(stage.points):
                way = self._displacement(a, b, stage.placements)
                cost += math.inf if way is None else sum(move.cost for move in way)
                if way is None or not cost < below:
                    return None
                moves.extend(way)
        return tuple(moves)

    def _regrasp(self, before: Stage, stage: Stage) -> Regrasp | None:
        fingers = changed(before.placements, stage.placements)
        if len(fingers) != 1:
            return None
        at, finger = stage.points[0], fingers[0]
        return self._model.regrasp(at, before.placements, finger, stage.placements[finger])

    def _displacement(
        self, a: Coordinates, b: Coordinates, placements: Placements
    ) -> tuple[Displacement, ...] | None:
        key = (a, b, placements)
        if key not in self._known:
            self._known[key] = self._model.displacement(a, b, placements)
        return self._known[key]
