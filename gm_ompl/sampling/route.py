"""A route: a way of the object that all sets of placements share."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.tables import ArcTable, Frame
from gm_ompl.motion.object_graph import Way
from gm_ompl.sampling.lines import coarse_to_fine


@final
class Route:
    """A way of the object whose arcs are called strides, and its places vertices.

    Args:
        judge: answers about the problem.
        way: from the start to the goal, K strides.

    Attributes:
        way: likewise.
        strides: K.
        table: what all sets share along it: stride k is arc k.
        node_free: (n, placements, K + 1), whether fingertips are free at the vertices.
        tried: (K, P), mode decisions asked for per segment, and
        failed: (K, P), how many of them had z < z_min.
    """

    def __init__(self, judge: Judge, way: Way) -> None:
        self.way, self.strides = way, len(way.arcs)
        every, goal = np.arange(self.strides), np.arange(self.strides + 1) == self.strides
        frame = Frame(way.poses, every, way.arcs, np.ascontiguousarray(every[::-1]), True, goal)
        self.table = ArcTable(judge, frame)
        self.node_free = self.table.tables.node_free
        shape = self.table.tables.states.shape
        self.tried, self.failed = np.zeros((2, *shape))
        rank = np.empty(shape[0] * shape[1])
        rank[coarse_to_fine(rank.size)] = np.arange(rank.size)
        self._rank: Array = rank.reshape(shape)

    def suspicion(self) -> Array:
        """Return (K, P): how likely a segment fails, as far as decisions tell; no two equal."""
        share = (self.failed + 0.5) / (self.tried + 1.0)
        # Untried segments count as even odds; among equals those spread over the route go first.
        spread: Array = share - 1e-6 * self._rank / max(self._rank.size, 1)
        return spread
