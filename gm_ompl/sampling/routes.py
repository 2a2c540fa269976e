"""A route: one motion of the object from start to goal, shared by all sets of placements."""

from __future__ import annotations

from functools import cached_property
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge, NodeGeometry
from gm_ompl.motion.arc import Moment
from gm_ompl.motion.object_graph import Way
from gm_ompl.sampling.lines import coarse_to_fine


@final
class Route:
    """A way of the object whose arcs are called strides, and its places vertices.

    What depends on the object alone is computed once for all sets: geometry at once, contact
    states when they are asked for.

    Args:
        judge: answers about the problem.
        way: from the start to the goal, K strides of P segments.

    Attributes:
        way: likewise.
        strides: K.
        object_free: whether the object penetrates nothing on the way.
        states: (K, P), contact states, -1 where not yet asked for.
        tried: (K, P), mode decisions asked for per segment, and
        failed: (K, P), how many of them had z < z_min.
    """

    def __init__(self, judge: Judge, way: Way) -> None:
        self._judge, self.way = judge, way
        self.strides, P = len(way.arcs), judge.problem.cost.samples_per_arc
        self._middles: list[tuple[Moment, ...] | None] = [None] * self.strides
        self.states: IntArray = np.full((self.strides, P), -1, dtype=np.int64)
        self.tried, self.failed = np.zeros((2, self.strides, P))
        rank = np.empty(self.strides * P)
        rank[coarse_to_fine(self.strides * P)] = np.arange(self.strides * P)
        self._rank: Array = rank.reshape(self.strides, P)
        self._rests: dict[int, int] = {}
        self._geometry()

    def _geometry(self) -> None:
        judge = self._judge
        nodes = [judge.node(pose) for pose in self.way.poses]
        along = [judge.along(arc.arc) for arc in self.way.arcs]
        self.object_free = all(place.object_free for place in nodes + along)
        self.node_free = self._masks(nodes)
        self.free = self._masks(along)

    def _masks(self, nodes: list[NodeGeometry]) -> BoolArray:
        """Return (n, placements, len(nodes)), where each fingertip is free."""
        hand = self._judge.problem.fingers
        if not nodes or not hand.count:
            return np.zeros((hand.count, len(hand.placements), len(nodes)), dtype=bool)
        masks: BoolArray = np.array([node.free for node in nodes])
        return np.ascontiguousarray(masks.transpose(1, 2, 0))

    def state(self, k: int, p: int) -> int:
        """Return the contact state of segment ``p`` of stride ``k``."""
        known = int(self.states[k, p])
        if known < 0:
            middles = self._middles[k]
            if middles is None:
                middles = self._middles[k] = self.way.arcs[k].middles()
            known = self.states[k, p] = self._judge.environment(middles[p])
        return known

    def rest_state(self, vertex: int) -> int:
        """Return the contact state of the object at rest at ``vertex``."""
        known = self._rests.get(vertex)
        if known is None:
            known = self._judge.environment(Moment(self.way.poses[vertex]))
            self._rests[vertex] = known
        return known

    @cached_property
    def lengths(self) -> Array:
        """|dq_finger i,j| of Eq. (9) for all placements, (n, placements, K, P)."""
        judge = self._judge
        radii = judge.problem.fingers.radius.tolist()
        known: dict[float, Array] = {}
        for i, radius in enumerate(radii):
            if radius not in known:
                each = [arc.lengths(judge.centres(i)) for arc in self.way.arcs]
                known[radius] = np.stack(each, axis=1)
        return np.ascontiguousarray(np.stack([known[radius] for radius in radii]))

    def suspicion(self) -> Array:
        """Return (K, P): how likely a segment fails, as far as decisions tell; no two equal."""
        share = (self.failed + 0.5) / (self.tried + 1.0)
        # Untried segments count as even odds; among equals those spread over the route go first.
        spread: Array = share - 1e-6 * self._rank / max(self._rank.size, 1)
        return spread
