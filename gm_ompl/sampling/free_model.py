"""What is possible in free motion, from any pose to any other: screws, and the hands for them."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Final, final

import numpy as np

from gm_ompl.caches import Memo, kept
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.cost import displacement_cost
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Displacement, Placements, Problem, Regrasp
from gm_ompl.sampling.motions import HybridModel, PointsOfWay
from gm_ompl.sampling.passages import Moves
from gm_ompl.sampling.pose_tree import Metric
from gm_ompl.sampling.screws import Leap, Screws, Stride
from gm_ompl.sampling.stride_states import StrideStates, may_lift

EXPANDED: Final = 24
"""Poses from which leaps are tried in search of a chain."""

CHAIN_BYTES: Final = 20_000
"""About what a chain takes."""

STRIDE_BYTES: Final = 5_000
"""About what a judged stride takes."""


def coordinates_of(pose: Pose) -> Coordinates:
    """Return a pose as seven numbers: x, y, z and the quaternion w, x, y, z."""
    return tuple(pose.position.tolist() + pose.quaternion().tolist())


@final
class FreeHybridModel(HybridModel):
    """What is possible where ``q`` are the seven numbers of a pose.

    Args:
        problem: of free motion.
        judge: answers about ``problem``.

    Attributes:
        motion: its motion.
        screws: the object's motions.
        metric: how far poses are apart.
        chain: from a place to another, by their numbers: strides, or None where none are found.
    """

    def __init__(self, problem: Problem, judge: Judge) -> None:
        super().__init__(problem, judge)
        assert isinstance(problem.motion, FreeMotion), "other motions have coordinates"
        self.motion = problem.motion
        self.screws, self.metric = Screws(problem), Metric(problem.body.diagonal)
        self.states, self._lifts = StrideStates(judge), may_lift(problem)
        self._numbers = Memo[Coordinates, int](400)
        self._displaced = Memo[object, Displacement | bool](STRIDE_BYTES)
        self.chain = lru_cache(kept(CHAIN_BYTES))(self._chain)
        self.coordinates = lru_cache(kept(400))(self._coordinates)

    @property
    def start(self) -> Coordinates:
        """The pose at the start."""
        return self.coordinates(self.screws.start)

    def number(self, q: Coordinates) -> int:
        """Return the number of a pose: the first one found stands for all next to it."""
        return self._numbers.of(q, lambda: self.screws.number(Pose.from_quaternion(q[:3], q[3:])))

    def _coordinates(self, place: int) -> Coordinates:
        return coordinates_of(self.screws.pose(place))

    def pose(self, q: Coordinates) -> Pose:
        """Return the pose."""
        return self.screws.pose(self.number(q))

    def noted(self, q: Coordinates) -> Coordinates:  # noqa: ARG002 (as for other motions)
        """Return nothing: moves have poses."""
        return ()

    def where(self, move: Regrasp) -> Coordinates:
        """Return the pose during a regrasp."""
        return self.coordinates(self.screws.number(move.pose))

    def same(self, a: Coordinates, b: Coordinates) -> bool:
        """Whether two poses are one."""
        return self.number(a) == self.number(b)

    def arrived(self, q: Coordinates) -> bool:
        """Whether a pose is in the goal."""
        return self.motion.goal.contains(self.pose(q))

    def leaps(self, place: int, target: Pose) -> list[Leap]:
        """Return the leaps towards a target along which some hand may carry the object."""
        leaps = self.screws.towards(place, target)
        return [leap for leap in leaps if self._lifts or not leap.bare]

    def _chain(self, begin: int, end: int) -> tuple[Stride, ...] | None:
        target = self.screws.pose(end)
        leaps = self.search(begin, target, lambda place: place == end)
        return None if leaps is None else self.strides(leaps)

    def strides(self, leaps: Sequence[Leap]) -> tuple[Stride, ...]:
        """Return leaps that follow each other as strides."""
        return tuple(itertools.chain.from_iterable(map(self.screws.strides, leaps)))

    def search(
        self, begin: int, target: Pose, there: Callable[[int], bool]
    ) -> tuple[Leap, ...] | None:
        """Return leaps from a place to one that is there, what is nearest to a target first."""
        if there(begin):
            return ()
        screws, far = self.screws, self.metric.between
        seen, count = {begin}, itertools.count()
        waiting = [(far(screws.pose(begin), target), next(count), begin, tuple[Leap, ...]())]
        for _ in range(EXPANDED):
            if not waiting:
                return None
            _, _, place, leaps = heapq.heappop(waiting)
            for leap in self.leaps(place, target):
                head = screws.number(leap.end)
                if head in seen:
                    continue
                seen.add(head)
                onwards = (*leaps, leap)
                if there(head):
                    return onwards
                heapq.heappush(waiting, (far(leap.end, target), next(count), head, onwards))
        return None

    def displaced(self, stride: Stride, placements: Placements) -> Moves | None:
        """Return the displacement along a stride, or None where it fails."""
        key = (stride.tail, stride.arc.head, stride.arc.arc.key, placements)
        made = self._displaced.of(key, lambda: self._displacement(stride, placements) or False)
        return (made,) if isinstance(made, Displacement) else None

    def _displacement(self, stride: Stride, placements: Placements) -> Displacement | None:
        states = self.states.of(stride)
        if states is None or not self.judge.apart(placements):
            return None
        if not all(mask[row] for mask, row in zip(states.free, placements, strict=True)):
            return None
        backend, numbers = self.judge.backend, tuple(dict.fromkeys(reversed(states.numbers)))
        for state in numbers:
            if backend.bound(state, self._fingers, placements) < self._z_min:
                return None
        found = {}
        for state in numbers:
            found[state] = backend.decide(state, self._fingers, placements, self._z_min)
            if not found[state].z >= self._z_min:
                return None
        decisions = tuple(found[state] for state in states.numbers)
        centres = np.array([self.judge.centres(i)[row] for i, row in enumerate(placements)])
        lengths = stride.arc.lengths(centres.reshape(-1, 3)).tolist()
        price, z = self.problem.cost, [decision.z for decision in decisions]
        cost = displacement_cost(lengths, z, price.stability, self.problem.z_floor)
        return Displacement(stride.arc.arc, (), (), placements, decisions, cost)


@final
class ScrewWay(PointsOfWay):
    """Strides that follow each other: a passage.

    Args:
        model: judges.
        begin: the number of the pose where they begin.
        strides: likewise.
    """

    def __init__(self, model: FreeHybridModel, begin: int, strides: Sequence[Stride]) -> None:
        places = [begin, *(stride.arc.head for stride in strides)]
        super().__init__(model, [model.coordinates(place) for place in places])
        self._model, self._strides = model, strides

    def carried(self, arc: int, placements: Placements) -> Moves | None:
        """Return the move along a stride, or None where it fails."""
        return self._model.displaced(self._strides[arc], placements)
