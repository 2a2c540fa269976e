"""Random hybrid states: goal states, and states that lean to placements that have held."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from gm_ompl.graph.goals import restricted
from gm_ompl.graph.sets import ordered_sets
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.ompl.motions import Motions
from gm_ompl.problem import Placements
from gm_ompl.sampling.lines import between, extents, same, strides_needed, unwrapped
from gm_ompl.sampling.motions import HybridState

QUICK_TRIES = 20
"""Hands drawn finger by finger before all hands are gone through in random order."""

PROVEN_SHARE = 0.5
"""How often a state is drawn with placements that have held over a displacement."""

RECENT = 50
"""Of those, only the latest are drawn: they belong to what the search extends now."""

PLACES = 20
"""Goal states drawn in search of one that can be reached from just before; else any will do."""

Anything = tuple[int | None, ...]


@final
class StateDraws:
    """Draws states of one problem.

    Attributes:
        rng: the only source of randomness.
    """

    def __init__(self, motions: Motions, rng: np.random.Generator) -> None:
        self._motions, self.rng = motions, rng
        self._model = motions.model
        self._problem = motions.model.problem
        self._any: Anything = (None,) * self._problem.fingers.count

    def hand(self, q: Coordinates, wanted: Anything | None = None) -> Placements | None:
        """Return valid placements at ``q``, or None where there are none.

        Args:
            q: the object's coordinates.
            wanted: per finger, the placement it must have, or None for any.
        """
        judge, hand = self._model.judge, self._problem.fingers
        node = judge.node(q)
        if not node.object_free:
            return None
        masks = restricted(node.free, wanted or self._any)
        pools = [np.flatnonzero(mask) for mask in masks]
        if not all(len(pool) for pool in pools):
            return None
        for _ in range(QUICK_TRIES):
            drawn = tuple(int(self.rng.choice(pool)) for pool in pools)
            if judge.apart(drawn):
                return drawn
        keys = [self.rng.random(len(hand.placements))] * hand.count
        found = next(ordered_sets(hand.groups(), masks, keys, judge.clear), None)
        return None if found is None else found[1]

    def start_and_goal_possible(self) -> bool:
        """Whether start and goal may have valid placements; False is a proof that one has none.

        Of a goal region, one place without any proves nothing.
        """
        problem = self._problem
        if self.hand(problem.start, problem.fingers.start) is None:
            return False
        low, high = problem.goal.low, problem.goal.high
        if low != high or None in low:
            return True
        return self.hand(self._place(low, high), problem.fingers.goal) is not None

    def goal(self) -> HybridState | None:
        """Return a valid goal state, or None where none was found.

        Most sets of placements that fit the goal cannot hold the object on the way into it: one
        that holds over the last lattice step, seen from the start, is preferred.
        """
        valid = None
        for _ in range(PLACES):
            q = self._place(self._problem.goal.low, self._problem.goal.high)
            placements = self.hand(q, self._problem.fingers.goal)
            if placements is None:
                continue
            valid = HybridState(q, placements)
            if self._entered(valid):
                break
        return valid

    def _entered(self, state: HybridState) -> bool:
        """Whether the object can be moved the last step of the straight way to ``state``."""
        start = self._problem.start
        q = unwrapped(self._problem, state.q, start)
        steps = strides_needed(self._problem, start, q)
        if same(self._problem, start, q):
            return True
        before = between(q, start, 1.0 / steps)
        return self._model.displacement(before, q, state.placements) is not None

    def anywhere(self) -> HybridState | None:
        """Return a valid state; its placements may be some that held elsewhere."""
        motion = self._problem.motion
        q = self._place(motion.low, motion.high)
        proven = self._motions.proven
        if proven and self.rng.random() < PROVEN_SHARE:
            recent = list(proven)[-RECENT:]
            placements = recent[int(self.rng.integers(len(recent)))]
            if self._model.state_valid(q, placements):
                return HybridState(q, placements)
        drawn = self.hand(q)
        return None if drawn is None else HybridState(q, drawn)

    def to_goal(self, q: Coordinates) -> float:
        """Return how far ``q`` is from the goal: the most over the coordinates' ranges."""
        goal, worst = self._problem.goal, 0.0
        for value, low, high, period, extent in zip(
            q, goal.low, goal.high, goal.periods, extents(self._problem), strict=True
        ):
            if low is None or high is None:
                continue
            middle, half = (low + high) / 2.0, (high - low) / 2.0
            away = abs(value - middle if period is None else math.remainder(value - middle, period))
            worst = max(worst, (away - half) / extent)
        return worst

    def _place(self, low: tuple[float | None, ...], high: tuple[float | None, ...]) -> Coordinates:
        motion = self._problem.motion
        place = []
        for d, (least, most) in enumerate(zip(low, high, strict=True)):
            a = motion.low[d] if least is None else least
            b = motion.high[d] if most is None else most
            place.append(a if a == b else float(self.rng.uniform(a, b)))
        return tuple(place)
