"""States of free motion to which some hand brings the object."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Final, final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.planners.ompl.free_motions import FreeMotions
from gm_ompl.planners.ompl.hands import REGRASPS, Hands, elsewhere
from gm_ompl.problem import Placements
from gm_ompl.sampling.motions import UNPLACED, HybridState
from gm_ompl.sampling.pose_tree import GOAL_SHARE, ROAMING_SHARE, TRIED, nearest_in
from gm_ompl.sampling.screws import Leap, Stride

WHOLE: Final = 0.5
"""Share of the others that are followed by more than one leap."""

TURNED: Final = 0.3, 0.6
"""Shares of the wishes: turned as the goal wants, up to the second as the object is."""

BESIDE: Final = 0.1
"""Share of the wishes that are met by a regrasp on the spot."""

LEAPS: Final = 6
"""Leaps after one another that meet a wish."""


@final
class Steering:
    """Finds states to which some hand brings the object, near a wish.

    Args:
        motions: what motions consist of; it judges what is found.
        rng: the source of randomness.
    """

    def __init__(self, motions: FreeMotions, rng: np.random.Generator) -> None:
        self._motions, self._model, self._rng = motions, motions.free, rng
        self._hands = Hands(motions.free, rng)
        self.known: list[HybridState] = []
        self._positions, self._rotations = np.zeros((0, 3)), np.zeros((0, 3, 3))
        self._learn(motions.model.start_state())
        self._to_goal = lru_cache(maxsize=10_000)(self._approach)

    def _learn(self, state: HybridState) -> None:
        pose = self._model.pose(state.q)
        self.known.append(state)
        self._positions = np.concatenate([self._positions, pose.position[None]])
        self._rotations = np.concatenate([self._rotations, pose.rotation[None]])

    def settle(self, origin: HybridState | None, wish: Pose) -> HybridState | None:
        """Return a state near a wish to which a motion leads, or None where none was found.

        Args:
            origin: where the motion begins; None: at any state that is known.
            wish: where the object might be.
        """
        if origin is None:
            weights = np.ones(len(self.known))
            metric = self._model.metric
            near = metric.nearest(self._positions, self._rotations, wish, weights)
            origin = self.known[near]
        for found in self._candidates(origin, wish):
            if self._reached(origin, found):
                return found
        return None

    def _reached(self, origin: HybridState, found: HybridState) -> bool:
        if self._motions.expand(origin, found) is None:
            return False
        self._learn(found)
        return True

    def _candidates(self, origin: HybridState, wish: Pose) -> Iterator[HybridState]:
        rng, model, place = self._rng, self._model, self._model.number(origin.q)
        if UNPLACED not in origin.placements and rng.random() < BESIDE:
            yield self._beside(origin)
            return
        if rng.random() < GOAL_SHARE:
            onwards = self._to_goal(place)
            if onwards:
                yield from self._followed(origin, onwards)
                return
        target = self._meant(model.screws.pose(place), wish)
        leaps = model.leaps(place, target)
        if rng.random() < ROAMING_SHARE:
            first = [leaps[k] for k in rng.permutation(len(leaps)).tolist()[:TRIED]]
        else:
            first = self._helping(place, leaps, target)
        more = rng.random() < WHOLE
        for leap in first:
            chain = self._onwards(leap, target) if more else [leap]
            yield from self._followed(origin, model.strides(chain))

    def _onwards(self, leap: Leap, target: Pose) -> list[Leap]:
        """Return a leap and others that bring the object ever nearer to a target."""
        chain, model = [leap], self._model
        while len(chain) < LEAPS:
            here = model.screws.number(chain[-1].end)
            helping = self._helping(here, model.leaps(here, target), target)
            if not helping:
                break
            chain.append(helping[0])
        return chain

    def _meant(self, here: Pose, wish: Pose) -> Pose:
        """Return what a wish is taken for: turned as it says, as the goal wants, or not at all."""
        chance = self._rng.random()
        if chance < TURNED[0]:
            return Pose(nearest_in(self._model.motion.goal, here).rotation, wish.position)
        return Pose(here.rotation if chance < TURNED[1] else wish.rotation, wish.position)

    def _helping(self, place: int, leaps: Sequence[Leap], target: Pose) -> list[Leap]:
        """Return the leaps that bring the object nearer to a target, the most helpful first."""
        here = self._model.screws.pose(place)
        return self._model.metric.nearer(leaps, here, target)[:TRIED]

    def _beside(self, origin: HybridState) -> HybridState:
        """Return the same pose with one finger elsewhere."""
        free = self._model.judge.node(self._model.pose(origin.q)).free
        finger = int(self._rng.integers(len(origin.placements)))
        rows = np.flatnonzero(free[finger])
        row = int(self._rng.choice(rows)) if len(rows) else origin.placements[finger]
        return HybridState(origin.q, elsewhere(origin.placements, finger, row))

    def _followed(
        self, origin: HybridState, strides: Sequence[Stride], *, whole: bool = False
    ) -> Iterator[HybridState]:
        """Yield states along strides to which some hand brings the object, the farthest first.

        Args:
            origin: where they begin.
            strides: they follow each other.
            whole: whether only their end will do.
        """
        if not strides:
            return
        sets, far, regrasps = np.array([origin.placements]), 0, len(origin.placements)
        if UNPLACED in origin.placements:
            sets, regrasps = self._begun(origin, strides), 0
        stops, since = list[tuple[IntArray, int]](), 0
        for k in range(regrasps + 1):
            since, (sets, far) = far, self._hands.along(strides, far, sets)
            if not len(sets):
                break
            stops.append((sets, far))
            if far == len(strides) or k == regrasps:
                break
            sets = self._hands.one_elsewhere(sets, origin.placements, strides[since : far + 1])
        for sets, far in reversed(stops):
            if whole and far < len(strides):
                return
            for row in self._rng.permutation(sets)[:REGRASPS].tolist():
                if far or tuple(row) != origin.placements:
                    yield self._at(strides, far, tuple(row))

    def _begun(self, origin: HybridState, strides: Sequence[Stride]) -> IntArray:
        """Return sets that hold the longest from the start and have the fingers that touch."""
        given = self._model.problem.fingers.start
        placed = (None if row == UNPLACED else row for row in origin.placements)
        wanted = tuple(b if a is None else a for a, b in zip(placed, given, strict=True))
        return self._hands.fresh(strides, wanted)

    def _at(self, strides: Sequence[Stride], far: int, placements: Placements) -> HybridState:
        head = strides[far - 1].arc.head if far else strides[0].tail
        return HybridState(self._model.coordinates(head), placements)

    def _approach(self, place: int) -> tuple[Stride, ...] | None:
        model, goal = self._model, self._model.motion.goal
        target = nearest_in(goal, model.screws.pose(place))
        leaps = model.search(place, target, lambda there: goal.contains(model.screws.pose(there)))
        return None if leaps is None else model.strides(leaps)

    def arriving(self) -> HybridState | None:
        """Return a goal state to which a motion leads from a known state."""
        origin = self._somewhere()
        strides = self._to_goal(self._model.number(origin.q))
        for found in self._followed(origin, strides or (), whole=True):
            if self._model.in_goal(found) and self._motions.expand(origin, found) is not None:
                return found
        return None

    def entering(self) -> HybridState | None:
        """Return a goal state whose hand holds as long as it can before."""
        origin, wanted = self._somewhere(), self._model.problem.fingers.goal
        onwards = self._to_goal(self._model.number(origin.q))
        if not onwards:
            return None
        strides = onwards[::-1]
        for row in self._rng.permutation(self._hands.fresh(strides, wanted)).tolist():
            found = HybridState(self._model.coordinates(strides[0].arc.head), tuple(row))
            if self._model.in_goal(found):
                return found
        return None

    def _somewhere(self) -> HybridState:
        """Return a known state, often the start."""
        some = self._rng.random() < WHOLE
        return self.known[int(self._rng.integers(len(self.known)))] if some else self.known[0]
