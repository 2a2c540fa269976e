"""Motions between hybrid states, remembered, and random states for them to lead to."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import TypeAlias, final

import numpy as np

from gm_ompl.caches import kept
from gm_ompl.holds.goals import restricted
from gm_ompl.holds.sets import ordered_sets
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Move, Placements, Problem
from gm_ompl.sampling.lines import coarse_to_fine, same, strides_needed, unwrapped
from gm_ompl.sampling.motions import UNPLACED, ContinuousModel, HybridState

MOTION_BYTES = 500
"""About what a motion takes; the latest asked for are kept."""

NEAR_NODE = 1e-6
"""A motion that ends this close to a lattice node, relative to the range, is not divided there."""

Moves: TypeAlias = tuple[Move, ...]


@final
class Motions:
    """What a motion from one hybrid state to another consists of.

    A motion is: fingers without a placement get their first one (free), then the regrasps at its
    start in a deterministic order, then one straight displacement. Motions are directed.

    Attributes:
        model: expands motions.
        start: the start state; only there a finger may be without placement.
        asked: motions asked for.
        valid: motions found valid.
        proven: sets of placements that held over a displacement, in the order of discovery.
    """

    def __init__(self, model: ContinuousModel, start: HybridState) -> None:
        self.model, self.start = model, start
        self.asked = self.valid = 0
        self.proven: dict[Placements, None] = {}
        self._arc = lru_cache(kept(MOTION_BYTES))(model.displacement)
        self._known = lru_cache(kept(MOTION_BYTES))(self._judged)

    def state_valid(self, state: HybridState) -> bool:
        """Whether nothing penetrates; without all placements, whether it is the start state."""
        if UNPLACED in state.placements and state != self.start:
            return False
        return self.model.state_valid(state.q, state.placements)

    def expand(self, origin: HybridState, target: HybridState) -> Moves | None:
        """Return the moves from ``origin`` to ``target``, or None where one is infeasible."""
        return self._known(origin, target)

    def _judged(self, origin: HybridState, target: HybridState) -> Moves | None:
        """Expand a motion that is not remembered, and count it."""
        self.asked += 1
        moves = self._expand(origin, target)
        if moves is not None:
            self.valid += 1
            if origin.q != target.q:
                self.proven.setdefault(target.placements)
        return moves

    def cost(self, origin: HybridState, target: HybridState) -> float:
        """Return Eqs. (9) and (10) summed over the motion's moves; +inf where infeasible."""
        moves = self.expand(origin, target)
        return math.inf if moves is None else math.fsum(move.cost for move in moves)

    def _expand(self, origin: HybridState, target: HybridState) -> Moves | None:
        points = waypoints(self.model.problem, origin.q, target.q)
        if UNPLACED in target.placements or len(points) < 3:
            found = self.model.expand(origin, target)
            return None if found is None else tuple(found)
        if not self.model.state_valid(target.q, target.placements):
            return None
        regrasps = self.model.expand(origin, HybridState(origin.q, target.placements))
        if regrasps is None:
            return None
        arcs = list(pairwise(points))
        found_arcs: dict[int, Moves] = {}
        for k in _cheap_first(len(arcs)):
            arc = self._arc(*arcs[k], target.placements)
            if arc is None:
                return None
            found_arcs[k] = arc
        return (*regrasps, *(move for k in range(len(arcs)) for move in found_arcs[k]))


def waypoints(problem: Problem, start: Coordinates, end: Coordinates) -> list[Coordinates]:
    """Return the ends of the arcs that the straight motion from ``start`` to ``end`` consists of.

    With one degree of freedom it is divided at the lattice's nodes: what is known of an arc then
    serves every motion that passes through it. Otherwise it is one arc.
    """
    if len(start) != 1 or problem.lattice.periods[0] is not None:
        return [start, end]
    u, v = start[0], end[0]
    margin = NEAR_NODE * problem.motion.extents[0]
    axis = problem.lattice.axes[0].tolist()
    between = [(node,) for node in axis if min(u, v) + margin < node < max(u, v) - margin]
    return [start, *(between if u < v else reversed(between)), end]


def _cheap_first(arcs: int) -> list[int]:
    """Return the order in which arcs are judged.

    Those from node to node come first: their geometry is known from other motions.
    """
    return [*(k + 1 for k in coarse_to_fine(arcs - 2)), arcs - 1, 0]


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
        node = judge.node(self._problem.motion.pose(q))
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
            drawn = HybridState(q, placements)
            if not self._model.leaves(drawn):
                continue
            valid = drawn
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

    def stuck(self, state: HybridState) -> bool:
        """Whether the fingers cannot leave a goal state, though they must."""
        placed = UNPLACED not in state.placements
        return placed and self._problem.goal.contains(state.q) and not self._model.leaves(state)

    def to_goal(self, q: Coordinates) -> float:
        """Return how far ``q`` is from the goal: the most over the coordinates' ranges."""
        goal, worst = self._problem.goal, 0.0
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
