"""One set of placements in the plane: the nodes it reaches without regrasping."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import final

import numpy as np

from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.lanes import blocked_at, names
from gm_ompl.explain.values import InstantLine, SetLine
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.problem import Placements

NODES = 1500
"""Nodes visited per set and end."""


@final
class Region:
    """What one set of placements reaches from the start, or what reaches the goal with it.

    Args:
        explainer: of the problem.
        placements: per finger.
        backwards: whether to go against the arcs, from the goal's nodes.

    Attributes:
        nodes: those visited.
        blocked: the failing instant nearest to the other end; None where nothing failed.
        arrived: whether the other end was reached.
        cut_short: whether the visit stopped at ``NODES``, or was stopped.
    """

    def __init__(self, explainer: Explainer, placements: Placements, backwards: bool) -> None:
        problem = explainer.problem
        self._explainer, self._placements, self._backwards = explainer, placements, backwards
        goals, start = problem.object_graph.goal_nodes, problem.object_graph.start
        assert goals, "a lattice's goal lies on it"
        sources, ends = (goals, (start,)) if backwards else ((start,), goals)
        self._ends = np.array([problem.lattice.coordinates(node) for node in ends])
        self._extent = np.array([float(np.ptp(axis)) or 1.0 for axis in problem.lattice.axes])
        self._failure: tuple[float, Coordinates, Coordinates, Verdict] | None = None
        self.nodes = self._valid(sources)
        queue = deque(self.nodes)
        while queue and len(self.nodes) < NODES and not explainer.stop():
            for node in self._next(queue.popleft()):
                if node not in self.nodes:
                    self.nodes.add(node)
                    queue.append(node)
        self.cut_short = bool(queue)
        self.arrived = any(node in self.nodes for node in ends)

    def _valid(self, sources: tuple[int, ...]) -> set[int]:
        lattice, judge = self._explainer.problem.lattice, self._explainer.judge
        valid = set()
        for node in sources:
            q = lattice.coordinates(node)
            if judge.placements_valid(self._explainer.problem.motion.pose(q), self._placements):
                valid.add(node)
            else:
                self._note(q, q, Verdict(Finding.GEOMETRY))
        return valid

    def _next(self, node: int) -> Iterator[int]:
        """Yield the nodes that an arc joins to ``node``; remember failures."""
        lattice = self._explainer.problem.lattice
        here = lattice.coordinates(node)
        for other, there in lattice.neighbours(node):
            tail, head = (there, here) if self._backwards else (here, there)
            if self._holds(tail, head, there):
                yield other

    def _holds(self, tail: Coordinates, head: Coordinates, new: Coordinates) -> bool:
        problem, judge = self._explainer.problem, self._explainer.judge
        direction = tuple(b - a for a, b in zip(tail, head, strict=True))
        P = problem.cost.samples_per_arc
        if not judge.placements_valid(problem.motion.pose(new), self._placements):
            self._note(new, direction, Verdict(Finding.GEOMETRY))
            return False
        hit = blocked_at(self._explainer, tail, head, self._placements)
        if hit is not None:
            self._note(hit, direction, Verdict(Finding.GEOMETRY))
            return False
        for j, moment in enumerate(problem.motion.arc(tail, head).middles(P)):
            q = between(tail, head, (2 * j + 1) / (2 * P))
            verdict = judge.segment(moment, self._placements, problem.mechanics.z_min)
            if not verdict.holds:
                self._note(q, direction, verdict)
                return False
        return True

    def _note(self, q: Coordinates, direction: Coordinates, verdict: Verdict) -> None:
        distance = self.distance(q)
        if self._failure is None or distance < self._failure[0]:
            self._failure = (distance, q, direction, verdict)

    def distance(self, q: Coordinates) -> float:
        """Return how far ``q`` is from the other end, in parts of the axes' extents."""
        steps = np.abs(self._ends - np.array(q)) / self._extent
        for d, period in enumerate(self._explainer.problem.lattice.periods):
            if period is not None:
                turn = period / self._extent[d]
                steps[:, d] = np.minimum(steps[:, d] % turn, turn - steps[:, d] % turn)
        return float(steps.max(axis=1).min())

    @property
    def nearest(self) -> float:
        """How far the nearest node visited is from the other end; +inf where there is none."""
        lattice = self._explainer.problem.lattice
        return min(
            (self.distance(lattice.coordinates(node)) for node in self.nodes), default=np.inf
        )

    def failure(self) -> InstantLine | None:
        """Return the failing instant nearest to the other end; None where it was reached."""
        if self.arrived or self._failure is None:
            return None
        _, q, direction, verdict = self._failure
        if verdict.decision is not None:
            verdict = self._explainer.verdict(q, direction, self._placements)
        return self._explainer.line(q, direction, self._placements, verdict)


def whole_region(explainer: Explainer, placements: Placements) -> SetLine:
    """Return what blocks a set of placements in the plane, from the start and from the goal."""
    ahead = Region(explainer, placements, backwards=False)
    back = Region(explainer, placements, backwards=True)
    forward, backward = ahead.failure(), back.failure()
    ratios = [x.ratio for x in (forward, backward) if x is not None and x.ratio is not None]
    return SetLine(
        placements=names(explainer.problem, placements),
        holds=ahead.arrived,
        forward=forward,
        backward=backward,
        ratio=min(ratios, default=None),
        nodes_from_start=len(ahead.nodes),
        nodes_to_goal=len(back.nodes),
        cut_short=ahead.cut_short and not ahead.arrived,
    )
