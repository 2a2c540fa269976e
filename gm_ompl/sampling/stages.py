"""A plan as stages, and refined: made cheaper by small changes, each judged anew; never dearer."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np

from gm_ompl.caches import Memo
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.goals import fits
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Displacement, Move, Placements, Problem, Regrasp
from gm_ompl.sampling.motions import CoordinateModel, HybridState

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

    def __init__(self, model: CoordinateModel) -> None:
        self._model = model
        self._known = Memo[Way, tuple[Displacement, ...] | None](DISPLACEMENT_BYTES)

    def moves(self, stages: Stages, below: float = math.inf) -> tuple[Move, ...] | None:
        """Return the moves of ``stages``; None where one fails or the cost is not below."""
        model = self._model
        hand = model.problem.fingers
        first, last = stages[0], stages[-1]
        if not (fits(first.placements, hand.start) and fits(last.placements, hand.goal)):
            return None
        if not (
            model.lands(first.placements)
            and model.leaves(HybridState(last.points[-1], last.placements))
        ):
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


CHEAPER: Final = 1.0 - 1e-9
"""A change that leaves as many regrasps is kept only where the cost falls by this factor."""

NOT_DEARER: Final = 1.0 + 1e-12
"""A change that leaves fewer regrasps may raise the cost by this factor: that of rounding."""

NEAR: Final = 0.5
"""Share of the placements tried that lie next to the present one."""

Change: TypeAlias = Callable[[Stages], Stages | None]


@final
class Refinement:
    """One plan being refined.

    Args:
        problem: what was planned.
        judge: answers about it.
        moves: the plan, at least one move.
        rng: the source of randomness.

    Attributes:
        moves: the best plan so far.
        cost: its cost.
        tidied: whether ``tidy`` was called.
    """

    def __init__(
        self, problem: Problem, judge: Judge, moves: Sequence[Move], rng: np.random.Generator
    ) -> None:
        self._problem, self._rng = problem, rng
        self._judge = judge
        self._stages = StageJudge(CoordinateModel(problem, judge))
        self._plan = stages_of(moves)
        self.tidied = False
        self.moves, self.cost = tuple(moves), math.fsum(move.cost for move in moves)
        self._changes: tuple[Change, ...] = (
            self._shortcut, self._move_regrasp, self._replace, self._replace,
        )  # fmt: skip

    def tidy(self, stop: Stop) -> bool:
        """Drop regrasps that are not needed and merge arcs; whether the plan got cheaper."""
        self.tidied = True
        any_better = False
        better = True
        while better and not stop():
            better = any(self._try(stages) for stages in self._simpler() if not stop())
            any_better = any_better or better
        return any_better

    def step(self) -> bool:
        """Try one random change; return whether the plan got cheaper."""
        change = self._changes[int(self._rng.integers(len(self._changes)))]
        stages = change(self._plan)
        return stages is not None and self._try(stages)

    def _try(self, stages: Stages) -> bool:
        # Of plans of equal cost that with fewer regrasps: they may cost nothing.
        fewer = len(stages) < len(self._plan)
        below = self.cost * (NOT_DEARER if fewer else CHEAPER)
        moves = self._stages.moves(stages, below)
        if moves is None:
            return False
        cost = math.fsum(move.cost for move in moves)
        if not cost < below:
            return False
        self._plan, self.moves, self.cost = stages, moves, cost
        return True

    def _simpler(self) -> Iterator[Stages]:
        """Yield the plan with a stage left out, then with a stage's way made straight."""
        plan = self._plan
        for k in range(len(plan)):
            yield from _without(plan, k)
        for k, stage in enumerate(plan):
            if len(stage.points) > 2:
                ends = (stage.points[0], stage.points[-1])
                yield (*plan[:k], Stage(stage.placements, ends), *plan[k + 1 :])

    def _shortcut(self, plan: Stages) -> Stages | None:
        """Join two points of a stage's way directly, or move one of its corners."""
        k = int(self._rng.integers(len(plan)))
        points = plan[k].points
        if len(points) < 3:
            return None
        i, j = sorted(int(m) for m in self._rng.choice(len(points), size=2, replace=False))
        if j - i >= 2:
            points = points[: i + 1] + points[j:]
        elif 0 < i < len(points) - 1:
            points = (*points[:i], self._between(points[i - 1], points[i + 1]), *points[i + 1 :])
        else:
            return None
        return (*plan[:k], Stage(plan[k].placements, points), *plan[k + 1 :])

    def _between(self, a: Coordinates, b: Coordinates) -> Coordinates:
        return between(a, b, float(self._rng.random()))

    def _move_regrasp(self, plan: Stages) -> Stages | None:
        """Regrasp at another point of the way."""
        if len(plan) < 2:
            return None
        k = int(self._rng.integers(len(plan) - 1))
        before, behind = plan[k], plan[k + 1]
        way = before.points + behind.points[1:]
        if len(way) < 2:
            return None
        i = int(self._rng.integers(len(way) - 1))
        at = self._between(way[i], way[i + 1])
        first = Stage(before.placements, (*way[: i + 1], at))
        second = Stage(behind.placements, (at, *way[i + 1 :]))
        return (*plan[:k], first, second, *plan[k + 2 :])

    def _replace(self, plan: Stages) -> Stages | None:
        """Put a finger elsewhere for as long as it stays in one place."""
        k, finger = (
            int(self._rng.integers(len(plan))), int(self._rng.integers(self._problem.fingers.count))
        )  # fmt: skip
        row = plan[k].placements[finger]
        first = last = k
        while first > 0 and plan[first - 1].placements[finger] == row:
            first -= 1
        while last < len(plan) - 1 and plan[last + 1].placements[finger] == row:
            last += 1
        other = self._other(finger, row)
        stages = []
        for m, stage in enumerate(plan):
            placements = stage.placements
            if first <= m <= last:
                placements = (*placements[:finger], other, *placements[finger + 1 :])
            stages.append(Stage(placements, stage.points))
        return tuple(stages)

    def _other(self, finger: int, row: int) -> int:
        """Return another placement: often a neighbour, else any."""
        count = len(self._problem.fingers.placements)
        if self._rng.random() >= NEAR:
            return int(self._rng.integers(count))
        centres = self._judge.centres(finger)
        distance = np.linalg.norm(centres - centres[row], axis=1)
        distance[row] = np.inf
        near = np.argsort(distance, kind="stable")[: min(8, count)]
        return int(near[int(self._rng.integers(len(near)))])


def _without(plan: Stages, k: int) -> Iterator[Stages]:
    """Yield the plan without stage ``k``: a neighbour takes over its way."""
    points = plan[k].points
    if k + 1 < len(plan):
        behind = plan[k + 1]
        longer = Stage(behind.placements, points + behind.points[1:])
        if k == 0 or len(changed(plan[k - 1].placements, behind.placements)) == 1:
            yield (*plan[:k], longer, *plan[k + 2 :])
        elif plan[k - 1].placements == behind.placements:
            before = plan[k - 1]
            whole = Stage(before.placements, before.points + points[1:] + behind.points[1:])
            yield (*plan[: k - 1], whole, *plan[k + 2 :])
    if k > 0:
        before = plan[k - 1]
        longer = Stage(before.placements, before.points + points[1:])
        if k + 1 == len(plan) or len(changed(before.placements, plan[k + 1].placements)) == 1:
            yield (*plan[: k - 1], longer, *plan[k + 1 :])
