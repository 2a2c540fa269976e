"""A route: one motion of the object from start to goal, shared by all sets of placements."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cached_property
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge, NodeGeometry
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.cost import chords
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements
from gm_ompl.sampling.lines import (
    between,
    coarse_to_fine,
    direction_of,
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
        midpoints: (K * P), of the segments.
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
        self.midpoints: list[Coordinates] = []
        self._directions: list[Coordinates] = []
        self._cuts: list[Coordinates] = [self.points[0]]
        for a, b in itertools.pairwise(self.points):
            corners = split(problem, a, b)
            for start, end in itertools.pairwise(corners):
                self._append(start, end, finer * strides_needed(problem, start, end), P)
        self.strides = len(self.vertices) - 1
        self.states: IntArray = np.full((self.strides, P), -1, dtype=np.int64)
        self.tried, self.failed = np.zeros((2, self.strides, P))
        rank = np.empty(self.strides * P)
        rank[coarse_to_fine(self.strides * P)] = np.arange(self.strides * P)
        self._rank: Array = rank.reshape(self.strides, P)
        self._rests: dict[int, int] = {}
        self._geometry()

    def _append(self, start: Coordinates, end: Coordinates, strides: int, P: int) -> None:
        parts = strides * P
        direction = direction_of(start, end)
        for j in range(parts):
            self.midpoints.append(between(start, end, (2 * j + 1) / (2 * parts)))
            self._directions.append(direction)
            self._cuts.append(between(start, end, (j + 1) / parts))
        self.vertices.extend(between(start, end, (k + 1) / strides) for k in range(strides))

    def _geometry(self) -> None:
        judge, K, P = self._judge, self.strides, self.states.shape[1]
        nodes = [judge.node(q) for q in self.vertices]
        middles = [judge.node(q) for q in self.midpoints]
        self.object_free = all(node.object_free for node in nodes + middles)
        self.node_free = self._masks(nodes)
        along = self._masks(middles)
        n, rows = along.shape[:2]
        free = along.reshape(n, rows, K, P).all(axis=3)
        free &= self.node_free[:, :, :-1] & self.node_free[:, :, 1:]
        self.free: BoolArray = np.ascontiguousarray(free)

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
            j = k * self.states.shape[1] + p
            known = self._judge.environment(self.midpoints[j], self._directions[j])
            self.states[k, p] = known
        return known

    def rest_state(self, vertex: int) -> int:
        """Return the contact state of the object at rest at ``vertex``."""
        known = self._rests.get(vertex)
        if known is None:
            known = self._rests[vertex] = self._judge.environment(self.vertices[vertex], None)
        return known

    @cached_property
    def poses(self) -> list[Pose]:
        """The object's poses at the segments' ends (K * P + 1)."""
        return [self._judge.problem.motion.pose(q) for q in self._cuts]

    @cached_property
    def lengths(self) -> Array:
        """|dq_finger i,j| of Eq. (9) for all placements, (n, placements, K, P)."""
        judge, shape = self._judge, self.states.shape
        radii = judge.problem.fingers.radius.tolist()
        known: dict[float, Array] = {}
        for i, radius in enumerate(radii):
            if radius not in known:
                known[radius] = chords(self.poses, judge.centres(i)).T.reshape(-1, *shape)
        return np.ascontiguousarray(np.stack([known[radius] for radius in radii]))

    def stride_lengths(self, k: int, placements: Placements) -> list[list[float]]:
        """Return |dq_finger i,j| along stride ``k``, per finger and segment."""
        judge, P = self._judge, self.states.shape[1]
        rows = [judge.centres(i)[row] for i, row in enumerate(placements)]
        poses = self.poses[k * P : (k + 1) * P + 1]
        lengths: list[list[float]] = chords(poses, np.array(rows).reshape(-1, 3)).T.tolist()
        return lengths

    def suspicion(self) -> Array:
        """Return (K, P): how likely a segment fails, as far as decisions tell; no two equal."""
        share = (self.failed + 0.5) / (self.tried + 1.0)
        # Untried segments count as even odds; among equals those spread over the route go first.
        spread: Array = share - 1e-6 * self._rank / max(self._rank.size, 1)
        return spread
