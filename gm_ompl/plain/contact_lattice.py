"""The contact lattice of free motion, stated plainly: poses found from the start, arc by arc.

A second opinion on the planner's, with which it shares values and contact points alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import FreeMotion, angle_between
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.object_graph import GraphArc, ObjectGraph, Way
from gm_ompl.plain.contact_arcs import ContactArcs, PlainStand
from gm_ompl.plain.contact_lines import SAME, PlainLine
from gm_ompl.problem import Problem

CELL = 1e-3
"""Size of the cells in which equal poses are looked for, relative to D."""


def object_graph(problem: Problem) -> ObjectGraph:
    """Return what the plain search walks."""
    if isinstance(problem.motion, FreeMotion):
        return PlainContactLattice(problem, problem.motion)
    return problem.object_graph


@final
class PlainContactLattice:
    """Poses that arcs lead to from the start, made when they are asked for.

    Args:
        problem: the object, its environment and P.
        motion: the problem's.

    Attributes:
        start: the node at the start.
        goal_nodes: None; they cannot be listed.
    """

    goal_nodes: tuple[int, ...] | None = None

    def __init__(self, problem: Problem, motion: FreeMotion) -> None:
        self._motion, self._D = motion, problem.body.diagonal
        samples = problem.cost.samples_per_arc
        self._arcs = ContactArcs(problem.body, problem.environment, motion, samples)
        self._stands: list[PlainStand] = []
        self._under_way: list[PlainLine | None] = []
        self._depths: list[int] = []
        self._cells: dict[tuple[int, ...], list[int]] = {}
        self._leaving: dict[int, tuple[GraphArc, ...]] = {}
        self.start = self._node(motion.start, None, 0)

    def arcs_from(self, node: int) -> Sequence[GraphArc]:
        """Return the arcs that leave a node; at most one leads to each head."""
        if self._motion.steps.depth is None:
            return self._expanded(node)
        # A node's depth is known once all before it in the order of their finding are expanded.
        for earlier in range(len(self._leaving), node):
            self._expanded(earlier)
        return self._expanded(node)

    def in_goal(self, node: int) -> bool:
        """Whether the object has arrived at a node."""
        return self._motion.goal.contains(self.pose(node))

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""
        return self._stands[node].pose

    def depth(self, node: int) -> int:
        """Return the number of arcs from the start; the least where ``depth`` is limited."""
        return self._depths[node]

    def arcs_to(self, pose: Pose, most: int) -> int | None:
        """Return the least number of arcs to a pose; None if ``most`` nodes do not tell."""
        node = 0
        while node < min(len(self._stands), most):
            if self._equal(node, pose):
                return self._depths[node]
            self._expanded(node)
            node += 1
        return None

    def coordinates(self, node: int) -> Coordinates:  # noqa: ARG002 (no node has any)
        """Return none: free motion has no coordinates."""
        return ()

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
        arcs = [
            next(arc for arc in self.arcs_from(tail) if arc.head == head).leading_to(k)
            for k, (tail, head) in enumerate(itertools.pairwise(nodes), start=1)
        ]
        return Way(tuple(map(self.pose, nodes)), ((),) * len(nodes), tuple(arcs))

    def _expanded(self, node: int) -> tuple[GraphArc, ...]:
        if node not in self._leaving:
            limits.check()
            arcs: dict[int, GraphArc] = {}
            if self._depths[node] != self._motion.steps.depth:
                for offer in self._arcs.offers(self._stands[node], self._under_way[node]):
                    if not offer.inside:
                        continue
                    head = self._node(offer.arc.end, offer.line, self._depths[node] + 1)
                    if head != node:
                        arcs.setdefault(head, GraphArc(head, offer.arc, offer.parts))
            self._leaving[node] = tuple(arcs.values())
        return self._leaving[node]

    def _node(self, pose: Pose, line: PlainLine | None, depth: int) -> int:
        """Return the node at a pose that an arc about ``line`` led to, new or known."""
        stand = self._arcs.stand(pose)
        under_way = self._arcs.under_way(stand, line)
        cell = np.floor(pose.position / (CELL * self._D)).astype(int)
        for offset in itertools.product((-1, 0, 1), repeat=3):
            for node in self._cells.get(tuple((cell + offset).tolist()), ()):
                if self._same(node, pose, under_way):
                    return node
        node = len(self._stands)
        self._stands.append(stand)
        self._under_way.append(under_way)
        self._depths.append(depth)
        self._cells.setdefault(tuple(cell.tolist()), []).append(node)
        return node

    def _same(self, node: int, pose: Pose, under_way: PlainLine | None) -> bool:
        line = self._under_way[node]
        if line is None or under_way is None:
            return line is under_way and self._equal(node, pose)
        return line.equals(under_way, self._D) and self._equal(node, pose)

    def _equal(self, node: int, pose: Pose) -> bool:
        known = self.pose(node)
        near = np.linalg.norm(known.position - pose.position) <= SAME * self._D
        return bool(near) and angle_between(known.rotation, pose.rotation) <= SAME
