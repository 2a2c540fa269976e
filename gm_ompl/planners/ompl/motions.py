"""Motions between hybrid states, remembered: one expansion for validity, cost and plan."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import pairwise
from typing import TypeAlias, final

from gm_ompl.motion.lattice import Coordinates
from gm_ompl.moves import Move
from gm_ompl.problem import Placements, Problem
from gm_ompl.sampling.lines import coarse_to_fine, extents
from gm_ompl.sampling.motions import UNPLACED, ContinuousModel, HybridState

REMEMBERED = 200_000
"""Motions kept, the latest asked for; others are expanded again on demand."""

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
        self._arc = lru_cache(REMEMBERED)(model.displacement)
        self._known = lru_cache(REMEMBERED)(self._judged)

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
    margin = NEAR_NODE * extents(problem)[0]
    axis = problem.lattice.axes[0].tolist()
    between = [(node,) for node in axis if min(u, v) + margin < node < max(u, v) - margin]
    return [start, *(between if u < v else reversed(between)), end]


def _cheap_first(arcs: int) -> list[int]:
    """Return the order in which arcs are judged.

    Those from node to node come first: their geometry is known from other motions.
    """
    return [*(k + 1 for k in coarse_to_fine(arcs - 2)), arcs - 1, 0]
