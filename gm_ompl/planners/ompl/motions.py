"""Motions between hybrid states, remembered: one expansion for validity, cost and plan."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeAlias, final

from gm_ompl.caches import Memo, kept
from gm_ompl.holds.watch import Stop, never
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Displacement, Placements, Problem
from gm_ompl.sampling.lines import coarse_to_fine, same, strides_needed, unwrapped
from gm_ompl.sampling.motions import (
    UNPLACED,
    CoordinateModel,
    HybridModel,
    HybridState,
    PointsOfWay,
)
from gm_ompl.sampling.passages import Moves, Passage, regrasping

MOTION_BYTES = 500
"""About what a motion takes; the latest asked for are kept."""

NEAR_NODE = 1e-6
"""A motion that ends this close to a lattice node, relative to the range, is not divided there."""

Displace: TypeAlias = Callable[[Coordinates, Coordinates, Placements], Moves | None]


class HybridMotions(ABC):
    """What a motion from one hybrid state to another consists of.

    A motion is a way of the object. Fingers without a placement get their first one at its start
    (free); a finger that is elsewhere at the end is regrasped where it may be, anywhere along the
    way. Motions are directed.

    Attributes:
        model: judges displacements and regrasps.
        starts: the start states; only there a finger may be without placement.
        asked: motions asked for.
        valid: motions found valid.
        proven: sets of placements that held over a displacement, in the order of discovery.
        hurried: whether the search is after a first plan, and only that.
    """

    def __init__(self, model: HybridModel, start: HybridState) -> None:
        self.model, self.starts = model, {start}
        self.asked = self.valid = 0
        self.proven: dict[Placements, None] = {}
        self.hurried: Stop = never
        self._checked = Memo[tuple[HybridState, HybridState], bool](MOTION_BYTES)
        self._known = lru_cache(kept(MOTION_BYTES))(self._judged)

    def state_valid(self, state: HybridState) -> bool:
        """Whether nothing penetrates; without all placements, whether it is a start state."""
        if UNPLACED in state.placements and state not in self.starts:
            return False
        return self.model.state_valid(state.q, state.placements)

    def expand(self, origin: HybridState, target: HybridState) -> Moves | None:
        """Return the moves from ``origin`` to ``target``, or None where one is infeasible.

        Fingers never become UNPLACED again. Coordinates that wrap go the shorter way.
        """
        return self._known(origin, target)

    def _judged(self, origin: HybridState, target: HybridState) -> Moves | None:
        """Expand a motion that is not remembered, and count it."""
        self.asked += 1
        moves = self._expand(origin, target)
        if moves is not None:
            self.valid += 1
            for move in moves:
                if isinstance(move, Displacement):
                    self.proven.setdefault(move.placements)
        return moves

    def check(self, origin: HybridState, target: HybridState) -> bool:
        """Whether the motion from ``origin`` to ``target`` is feasible."""
        self._checked[origin, target] = valid = self.expand(origin, target) is not None
        return valid

    def compared(self, origin: HybridState, target: HybridState) -> float:
        """Return what a motion costs, as ``cost``; in a hurry +inf where it was never checked."""
        if (origin, target) not in self._checked and self.hurried():
            return math.inf
        return self.cost(origin, target)

    def cost(self, origin: HybridState, target: HybridState) -> float:
        """Return Eqs. (9) and (10) summed over the motion's moves; +inf where infeasible."""
        moves = self.expand(origin, target)
        return math.inf if moves is None else math.fsum(move.cost for move in moves)

    def _expand(self, origin: HybridState, target: HybridState) -> Moves | None:
        wanted, model = target.placements, self.model
        if UNPLACED in wanted:
            return None
        here = zip(origin.placements, wanted, strict=True)
        first = tuple(b if a == UNPLACED else a for a, b in here)
        if not (model.state_valid(target.q, wanted) and model.state_valid(origin.q, first)):
            return None
        if UNPLACED in origin.placements and not model.lands(first):
            return None
        way = self.way(origin.q, target.q, rests=first != wanted)
        if way is None:
            return None
        return held(way, wanted) if first == wanted else regrasping(way, first, wanted)

    @abstractmethod
    def way(self, start: Coordinates, end: Coordinates, *, rests: bool = True) -> Passage | None:
        """Return the way of the object from ``start`` to ``end``, or None where there is none.

        Args:
            start: where it begins.
            end: where it ends.
            rests: whether it must be divided for regrasps.
        """


@final
class MacroMotions(HybridMotions):
    """Motions along a path or in the plane: the object goes straight.

    Args:
        model: judges displacements and regrasps.
        start: the start state.

    Attributes:
        straight: the model.
    """

    def __init__(self, model: CoordinateModel, start: HybridState) -> None:
        super().__init__(model, start)
        self.straight = model
        self._arc: Displace = lru_cache(kept(MOTION_BYTES))(model.displacement)

    def way(self, start: Coordinates, end: Coordinates, *, rests: bool = True) -> StraightMove:
        """Return the straight way of the object from ``start`` to ``end``, the shorter way round.

        Args:
            start: coordinates.
            end: likewise.
            rests: whether it must be divided for regrasps.
        """
        problem = self.model.problem
        end = unwrapped(problem, end, start)
        stays = same(problem, start, end)
        points = [start] if stays else waypoints(problem, start, end, rests=rests)
        return StraightMove(self.straight, self._arc, points)


@final
class StraightMove(PointsOfWay):
    """A straight way of the object, divided at points: a passage.

    Args:
        model: judges regrasps.
        displace: judges an arc.
        points: where arcs begin and end.
    """

    def __init__(
        self, model: CoordinateModel, displace: Displace, points: Sequence[Coordinates]
    ) -> None:
        super().__init__(model, points)
        self._displace = displace

    def carried(self, arc: int, placements: Placements) -> Moves | None:
        """Return the moves along an arc, or None where they fail."""
        return self._displace(self._points[arc], self._points[arc + 1], placements)


def held(passage: Passage, placements: Placements) -> Moves | None:
    """Return the moves along a whole passage without a regrasp, or None where they fail."""
    found: dict[int, Moves] = {}
    for k in _cheap_first(passage.arcs):
        arc = passage.carried(k, placements)
        if arc is None:
            return None
        found[k] = arc
    return tuple(move for k in range(passage.arcs) for move in found[k])


def waypoints(
    problem: Problem, start: Coordinates, end: Coordinates, *, rests: bool = False
) -> list[Coordinates]:
    """Return the ends of the arcs that the straight motion from ``start`` to ``end`` consists of.

    With one degree of freedom it is divided at the lattice's nodes: what is known of an arc then
    serves every motion that passes through it. Otherwise it is one arc, unless it ``rests``: then
    it is divided into strides of at most a lattice step.
    """
    if len(start) == 1 and problem.lattice.periods[0] is None:
        u, v = start[0], end[0]
        margin = NEAR_NODE * problem.motion.extents[0]
        axis = problem.lattice.axes[0].tolist()
        nodes = [(node,) for node in axis if min(u, v) + margin < node < max(u, v) - margin]
        return [start, *(nodes if u < v else reversed(nodes)), end]
    strides = strides_needed(problem, start, end) if rests else 1
    return [between(start, end, k / strides) for k in range(strides + 1)]


def _cheap_first(arcs: int) -> list[int]:
    """Return the order in which arcs are judged.

    Those from node to node come first: their geometry is known from other motions.
    """
    if arcs < 2:
        return list(range(arcs))
    return [*(k + 1 for k in coarse_to_fine(arcs - 2)), arcs - 1, 0]
