"""Random states: goal states, and states from anywhere that lean to placements that have held."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from typing import TypeAlias, TypeVar, final

import numpy as np

from gm_ompl.holds.goals import fits, restricted
from gm_ompl.holds.sets import ordered_sets
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.planners.ompl.motions import MacroMotions
from gm_ompl.problem import Placements
from gm_ompl.sampling.lines import same, strides_needed, unwrapped
from gm_ompl.sampling.motions import UNPLACED, HybridModel, HybridState

QUICK_TRIES = 20
"""Hands drawn finger by finger before all hands are gone through in random order."""

PROVEN_SHARE = 0.5
"""How often a state is drawn with placements that have held over a displacement."""

RECENT = 50
"""Of those, only the latest are drawn: they belong to what the search extends now."""

THROUGHOUT_TRIES = 60
"""Goal states drawn at first in search of one whose placements hold all the way from the start."""

THROUGHOUT_SHARE = 0.5
"""How often a goal state that was found to be such a one is drawn again."""

OUTSIDE = 1e-9
"""States outside the goal are at least so far from it."""

PLACES = 20
"""Goal states drawn in search of one that can be reached from just before; else any will do."""

Item = TypeVar("Item")

Anything: TypeAlias = tuple[int | None, ...]


class Draws(ABC):
    """Draws states of one problem.

    Attributes:
        rng: the only source of randomness.
        goals: goal states that are offered where nothing else is said.
    """

    goals = 100

    def __init__(self, model: HybridModel, rng: np.random.Generator) -> None:
        self._hybrid, self.rng = model, rng
        self._problem = model.problem
        self._any: Anything = (None,) * self._problem.fingers.count

    @abstractmethod
    def start_and_goal_possible(self) -> bool:
        """Whether start and goal may have valid placements; False is a proof that one has none."""

    @abstractmethod
    def goal(self) -> HybridState | None:
        """Return a valid goal state, or None where none was found."""

    @abstractmethod
    def anywhere(self) -> HybridState | None:
        """Return a valid state, or None where none was found."""

    @abstractmethod
    def to_goal(self, q: Coordinates) -> float:
        """Return how far the object is from the goal at ``q``; 0 only inside."""

    def stuck(self, state: HybridState) -> bool:
        """Whether the fingers cannot leave a goal state, though they must."""
        placed = UNPLACED not in state.placements
        return placed and self._hybrid.arrived(state.q) and not self._hybrid.leaves(state)

    def hand(self, q: Coordinates, wanted: Anything | None = None) -> Placements | None:
        """Return valid placements at ``q``, or None where there are none.

        Args:
            q: the object's coordinates.
            wanted: per finger, the placement it must have, or None for any.
        """
        judge, hand = self._hybrid.judge, self._problem.fingers
        node = judge.node(self._hybrid.pose(q))
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

    def one_of(self, items: Sequence[Item]) -> Item:
        """Return any of some items."""
        return items[int(self.rng.integers(len(items)))]


@final
class StateDraws(Draws):
    """Draws states along a path or in the plane.

    Args:
        motions: what motions consist of.
        rng: the only source of randomness.
    """

    def __init__(self, motions: MacroMotions, rng: np.random.Generator) -> None:
        super().__init__(motions.straight, rng)
        self._motions, self._model = motions, motions.straight
        self._through: dict[HybridState, None] = {}
        self._failed = Counter[int]()
        self._asked = False

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
        that holds over the last lattice step, seen from the start, is preferred, and one that
        holds all along the straight way from the start is drawn again and again. The first call
        looks for such a one.
        """
        found = None
        for _ in range(1 if self._asked else THROUGHOUT_TRIES):
            drawn = self._entering_goal()
            if drawn is None:
                break
            found = drawn
            if self._throughout(found):
                self._through.setdefault(found)
                self._asked = True
                return found
        self._asked = True
        if self._through:
            if self.rng.random() < THROUGHOUT_SHARE:
                return self.one_of(list(self._through))
            return found
        return self._proven_goal() or found

    def _proven_goal(self) -> HybridState | None:
        """Return, now and then, a goal state with placements that held over a displacement."""
        proven, goal = self._motions.proven, self._problem.goal
        if not proven or self.rng.random() >= PROVEN_SHARE:
            return None
        recent = list(proven)[-RECENT:]
        drawn = HybridState(self._place(goal.low, goal.high), self.one_of(recent))
        held = fits(drawn.placements, self._problem.fingers.goal) and self._model.state_valid(
            *drawn
        )
        return drawn if held and self._model.leaves(drawn) and self._entered(drawn) else None

    def _entering_goal(self) -> HybridState | None:
        """Return a valid goal state that the object can be moved into, where one is found."""
        valid = None
        for _ in range(PLACES):
            q = self._place(self._problem.goal.low, self._problem.goal.high)
            placements = self.hand(q, self._problem.fingers.goal)
            if placements is None:
                continue
            drawn = HybridState(q, placements)
            if not self._model.leaves(drawn):
                continue
            valid = drawn
            if self._entered(valid):
                break
        return valid

    def _throughout(self, state: HybridState) -> bool:
        """Whether the placements hold all along the straight way from the start to ``state``.

        Where most have failed is asked first.
        """
        if not fits(state.placements, self._problem.fingers.start):
            return False
        way = self._motions.way(self._problem.start, state.q)
        for arc in sorted(range(way.arcs), key=lambda arc: -self._failed[arc]):
            if way.carried(arc, state.placements) is None:
                self._failed[arc] += 1
                return False
        return self._model.lands(state.placements)

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
            placements = self.one_of(list(proven)[-RECENT:])
            if self._model.state_valid(q, placements):
                return HybridState(q, placements)
        drawn = self.hand(q)
        return None if drawn is None else HybridState(q, drawn)

    def to_goal(self, q: Coordinates) -> float:
        """Return how far ``q`` is from the goal: the most over the coordinates' ranges."""
        goal, worst = self._problem.goal, OUTSIDE
        if goal.contains(q):
            return 0.0
        for value, low, high, period, extent in zip(
            q, goal.low, goal.high, goal.periods, self._problem.motion.extents, strict=True
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
