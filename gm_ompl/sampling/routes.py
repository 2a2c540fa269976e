"""A route: one motion of the object from start to goal, shared by all sets of placements."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cached_property
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge, NodeGeometry
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Placements
from gm_ompl.sampling.lines import (
    coarse_to_fine,
    split,
    strides_needed,
)


@final
class Route:
    """A polyline in the object's coordinates, divided into strides of at most a lattice step.

    Each stride has P segments. What depends on the object alone is computed once for all sets:
    geometry at once, contact states when they are asked for.

    Args:
        judge: answers about the problem.
        points: the polyline's corners, unwrapped, no two in a row equal.
        finer: strides per lattice step.

    Attributes:
        points: likewise.
        finer: likewise.
        vertices: the strides' ends (K + 1).
        arcs: the strides (K).
        object_free: whether the object penetrates nothing on the way.
        states: (K, P), contact states, -1 where not yet asked for.
        tried: (K, P), mode decisions asked for per segment, and
        failed: (K, P), how many of them had z < z_min.
    """

    def __init__(self, judge: Judge, points: Sequence[Coordinates], finer: int = 1) -> None:
        self._judge, self.finer = judge, finer
        self.points = tuple(points)
        problem = judge.problem
        P = problem.cost.samples_per_arc
        self.vertices: list[Coordinates] = [self.points[0]]
        self.arcs: list[Arc] = []
        for a, b in itertools.pairwise(self.points):
            corners = split(problem, a, b)
            for start, end in itertools.pairwise(corners):
                self._append(start, end, finer * strides_needed(problem, start, end))
        self.strides = len(self.arcs)
        self._middles: list[tuple[Moment, ...] | None] = [None] * self.strides
        self.states: IntArray = np.full((self.strides, P), -1, dtype=np.int64)
        self.tried, self.failed = np.zeros((2, self.strides, P))
        rank = np.empty(self.strides * P)
        rank[coarse_to_fine(self.strides * P)] = np.arange(self.strides * P)
        self._rank: Array = rank.reshape(self.strides, P)
        self._rests: dict[int, int] = {}
        self._geometry()

    def _append(self, start: Coordinates, end: Coordinates, strides: int) -> None:
        corners = [between(start, end, k / strides) for k in range(strides + 1)]
        self.vertices.extend(corners[1:])
        arc = self._judge.problem.motion.arc
        self.arcs.extend(arc(a, b) for a, b in itertools.pairwise(corners))

    def _geometry(self) -> None:
        judge, pose = self._judge, self._judge.problem.motion.pose
        nodes = [judge.node(pose(q)) for q in self.vertices]
        along = [judge.along(arc) for arc in self.arcs]
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
                middles = self._middles[k] = self.arcs[k].middles(self.states.shape[1])
            known = self.states[k, p] = self._judge.environment(middles[p])
        return known

    def rest_state(self, vertex: int) -> int:
        """Return the contact state of the object at rest at ``vertex``."""
        known = self._rests.get(vertex)
        if known is None:
            pose = self._judge.problem.motion.pose(self.vertices[vertex])
            known = self._rests[vertex] = self._judge.environment(Moment(pose))
        return known

    @cached_property
    def lengths(self) -> Array:
        """|dq_finger i,j| of Eq. (9) for all placements, (n, placements, K, P)."""
        judge, P = self._judge, self.states.shape[1]
        radii = judge.problem.fingers.radius.tolist()
        known: dict[float, Array] = {}
        for i, radius in enumerate(radii):
            if radius not in known:
                each = [arc.chords(judge.centres(i), P).T for arc in self.arcs]
                known[radius] = np.stack(each, axis=1)
        return np.ascontiguousarray(np.stack([known[radius] for radius in radii]))

    def stride_lengths(self, k: int, placements: Placements) -> list[list[float]]:
        """Return |dq_finger i,j| along stride ``k``, per finger and segment."""
        judge, P = self._judge, self.states.shape[1]
        rows = [judge.centres(i)[row] for i, row in enumerate(placements)]
        lengths: list[list[float]] = (
            self.arcs[k].chords(np.array(rows).reshape(-1, 3), P).T.tolist()
        )
        return lengths

    def suspicion(self) -> Array:
        """Return (K, P): how likely a segment fails, as far as decisions tell; no two equal."""
        share = (self.failed + 0.5) / (self.tried + 1.0)
        # Untried segments count as even odds; among equals those spread over the route go first.
        spread: Array = share - 1e-6 * self._rank / max(self._rank.size, 1)
        return spread
