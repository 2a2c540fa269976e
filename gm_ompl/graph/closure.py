"""The part of an object graph that plans up to a cost can use: it grows with that cost."""

from __future__ import annotations

import heapq
import math
from collections.abc import Hashable, Mapping, Sequence
from typing import final

import numpy as np

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.watch import Stop, never
from gm_ompl.motion.object_graph import GraphArc


@final
class Closure:
    """Nodes by the least travel of any fingertips on the way there.

    On each arc every finger goes at least as far as it would from the placement that is best for
    it there, so a plan past a node costs at least what this says of it.

    Args:
        judge: of the problem.
        stop: asked now and then.

    Raises:
        LimitError: ``stop`` said so.
    """

    def __init__(self, judge: Judge, stop: Stop = never) -> None:
        self._graph, self._stop = judge.problem.object_graph, stop
        hand = judge.problem.fingers
        firsts = {radius: i for i, radius in reversed(list(enumerate(hand.radius.tolist())))}
        self._centres = [judge.centres(i) for i in firsts.values()]
        self._travel: dict[Hashable, float] = {}
        self._leaving: dict[int, Sequence[GraphArc]] = {}
        self._least = {self._graph.start: 0.0}
        self._open = [(0.0, self._graph.start)]

    @property
    def next(self) -> float:
        """The least travel to a node that is not in it yet; +inf where it is whole."""
        while self._open and self._open[0][1] in self._leaving:
            heapq.heappop(self._open)
        return self._open[0][0] if self._open else math.inf

    def to_goal(self) -> float:
        """Grow until the goal is in it, or it is whole; return the least travel there, or +inf."""
        while self.next < math.inf:
            travel, node = self._open[0]
            self._take()
            if self._graph.in_goal(node):
                return travel
        return math.inf

    def grow(self, most: float) -> None:
        """Take in all nodes with a least travel of at most this."""
        while self.next <= most and self.next < math.inf:
            self._take()

    def leaving(self) -> Mapping[int, Sequence[GraphArc]]:
        """Return the arcs between the nodes in it, by their tails."""
        inside = self._leaving
        return {node: [arc for arc in arcs if arc.head in inside] for node, arcs in inside.items()}

    def _take(self) -> None:
        """Take in the next node."""
        if len(self._leaving) % 32 == 0 and self._stop():
            raise LimitError
        travel, node = heapq.heappop(self._open)
        self._leaving[node] = arcs = self._graph.arcs_from(node)
        for arc in arcs:
            through = travel + self._shortest(arc)
            if through < self._least.get(arc.head, math.inf):
                self._least[arc.head] = through
                heapq.heappush(self._open, (through, arc.head))

    def _shortest(self, arc: GraphArc) -> float:
        """Return the least travel along an arc for the finger whose best placement is worst."""
        known = None if arc.kind is None else self._travel.get(arc.kind)
        if known is None:
            lengths = (arc.lengths(centres).sum(axis=1) for centres in self._centres)
            known = max((float(np.min(own, initial=math.inf)) for own in lengths), default=0.0)
            if arc.kind is not None:
                self._travel[arc.kind] = known
        return known
