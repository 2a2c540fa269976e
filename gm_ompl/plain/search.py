"""The paper's search stated plainly: Dijkstra over the manipulation-feasibility graph of Sec. 4.2.

Every arc is judged when its tail is expanded, regrasping arcs one by one between nodes: no
heuristic, no lazy arcs, no hubs. For small lattices.
"""

from __future__ import annotations

import enum
import heapq
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from gm_ompl.geometry.pose import Pose
from gm_ompl.plain.air import Freedom
from gm_ompl.plain.air_judge import AirJudge
from gm_ompl.plain.contact_lattice import object_graph
from gm_ompl.plain.judge import Decide, ReferenceJudge, Ruling
from gm_ompl.problem import Move, Placements, Problem
from gm_ompl.reference.strongest import decision_for

Node: TypeAlias = tuple[int, Placements]
"""Lattice node of the object, and per finger its placement; increasing among fingers that are
interchangeable, so that a node holds an unordered set of them."""


class SearchStatus(enum.Enum):
    """How a search ended; the value is a sentence for the user."""

    SOLVED = "a plan was found that is optimal on this lattice"
    INFEASIBLE = "no path joins start and goal on this lattice"


@dataclass(frozen=True)
class PlainResult:
    """What the search found.

    Attributes:
        status: how it ended.
        cost: the optimum; +inf where infeasible.
        moves: the optimal plan, per physical finger.
        expanded: number of nodes expanded.
        arcs: number of arcs judged.
        decisions: number of mode decisions made.
    """

    status: SearchStatus
    cost: float
    moves: tuple[Move, ...]
    expanded: int
    arcs: int
    decisions: int


def plain_search(problem: Problem, decide: Decide | None = None) -> PlainResult:
    """Return the minimum-cost path from the virtual start node to the virtual goal node.

    Args:
        problem: what to solve.
        decide: Sec. 3.4; by default the reference's own, by the margin that counts.

    Raises:
        InputError: the start is not a lattice node.
        SolverError: a mode decision could not be made.
    """
    decide = decide or decision_for(problem.mechanics.strong)
    graph = Graph(problem, ReferenceJudge(problem, decide))
    cost: dict[Node, float] = dict.fromkeys(graph.starts(), 0.0)
    parent: dict[Node, Node] = {}
    done: set[Node] = set()
    counter = itertools.count()
    queue = [(0.0, next(counter), node) for node in cost]
    while queue:
        reached, _, node = heapq.heappop(queue)
        if node in done:
            continue
        if graph.is_goal(node):
            moves = graph.moves(_path(parent, node))
            return graph.result(SearchStatus.SOLVED, reached, moves, len(done))
        done.add(node)
        for head, length in graph.arcs_from(node):
            if reached + length < cost.get(head, math.inf):
                cost[head], parent[head] = reached + length, node
                heapq.heappush(queue, (cost[head], next(counter), head))
    return graph.result(SearchStatus.INFEASIBLE, math.inf, (), len(done))


class Graph:
    """The manipulation-feasibility graph of a problem.

    Args:
        problem: whose graph.
        judge: decides which nodes and arcs exist.
    """

    def __init__(self, problem: Problem, judge: ReferenceJudge) -> None:
        self._problem, self._judge = problem, judge
        self._air = AirJudge(problem)
        self._objects = object_graph(problem)
        self._groups = problem.fingers.groups()
        self._arcs = 0

    def starts(self) -> Iterator[Node]:
        """Yield the nodes that the virtual start node leads to."""
        at = self._objects.start
        hand = self._problem.fingers
        for placements in self._placement_sets(hand.start):
            node = (at, placements)
            if self._valid(node) and self._free(node, hand.standing):
                yield node

    def is_goal(self, node: Node) -> bool:
        """Whether an arc leads from ``node`` to the virtual goal node."""
        if not self._objects.in_goal(node[0]):
            return False
        hand = self._problem.fingers
        fits = all(g is None or g == p for g, p in zip(hand.goal, node[1], strict=True))
        return fits and (not hand.leave or self._free(node, ()))

    def arcs_from(self, node: Node) -> Iterator[tuple[Node, float]]:
        """Yield (head, cost) of all arcs out of ``node``, each judged here."""
        yield from self._displacements(node)
        for finger in range(len(node[1])):
            yield from self._regrasps(node, finger)

    def moves(self, path: list[Node]) -> tuple[Move, ...]:
        """Turn a path into moves: fingers keep their identity and coordinates are unwrapped."""
        placements = path[0][1]
        nodes = [path[0][0], *(b[0] for a, b in itertools.pairwise(path) if a[0] != b[0])]
        way, k = self._objects.way(nodes), 0
        moves: list[Move] = []
        for tail, head in itertools.pairwise(path):
            move: Move | None
            if tail[0] != head[0]:
                move = self._judge.displacement(way, k, placements)
                k += 1
            else:
                finger, target = self._moved(tail[1], head[1], placements)
                move = self._judge.regrasp(way, k, placements, finger, target)
                placements = _replaced(placements, finger, target)
            assert move is not None, "an arc of the path is infeasible when judged again"
            moves.append(move)
        return tuple(moves)

    def result(
        self, status: SearchStatus, cost: float, moves: tuple[Move, ...], expanded: int
    ) -> PlainResult:
        """Return a result with this graph's counts."""
        return PlainResult(status, cost, moves, expanded, self._arcs, self._judge.decisions)

    def _displacements(self, node: Node) -> Iterator[tuple[Node, float]]:
        for arc in self._objects.arcs_from(node[0]):
            self._arcs += 1
            head = (arc.head, node[1])
            if not self._valid(head):
                continue
            decisions = self._judge.decisions_along(arc, node[1])
            if decisions is not None:
                z = [decision.z for decision in decisions]
                yield head, self._judge.displacement_cost(arc.arc, node[1], z)

    def _regrasps(self, node: Node, finger: int) -> Iterator[tuple[Node, float]]:
        at, placements = node
        pose = self._pose(at)
        for target in range(len(self._problem.fingers.placements)):
            head = (at, self._unordered(_replaced(placements, finger, target)))
            if target == placements[finger] or not self._valid(head):
                continue
            self._arcs += 1
            held = self._judge.rest(pose, placements, finger).finding is Ruling.HOLDS
            if held and self._air.goes(pose, placements, finger, target) is Freedom.FREE:
                yield head, self._problem.cost.regrasp

    def _free(self, node: Node, standing: tuple[int, ...]) -> bool:
        """Whether the fingers that do not stand already can touch one after the other."""
        found, _ = self._air.landing(self._pose(node[0]), node[1], standing)
        return found is Freedom.FREE

    def _valid(self, node: Node) -> bool:
        return self._judge.node_valid(self._pose(node[0]), node[1])

    def _pose(self, at: int) -> Pose:
        return self._objects.pose(at)

    def _placement_sets(self, given: tuple[int | None, ...]) -> Iterator[Placements]:
        """Yield every unordered choice of placements with the given ones in place."""
        table = range(len(self._problem.fingers.placements))
        choices = []
        for group in self._groups:
            fixed = given[group[0]]
            allowed = table if fixed is None else (fixed,)
            choices.append(list(itertools.combinations_with_replacement(allowed, len(group))))
        for choice in itertools.product(*choices):
            placements = [0] * len(given)
            for group, chosen in zip(self._groups, choice, strict=True):
                for finger, p in zip(group, chosen, strict=True):
                    placements[finger] = p
            yield tuple(placements)

    def _unordered(self, placements: Placements) -> Placements:
        ordered = list(placements)
        for group in self._groups:
            for finger, p in zip(group, sorted(placements[i] for i in group), strict=True):
                ordered[finger] = p
        return tuple(ordered)

    def _moved(self, tail: Placements, head: Placements, physical: Placements) -> tuple[int, int]:
        """Return the physical finger that a regrasping arc moves, and where to."""
        for group in self._groups:
            before, after = [tail[i] for i in group], [head[i] for i in group]
            for p in list(before):
                if p in after:
                    before.remove(p)
                    after.remove(p)
            if before:
                return next(i for i in group if physical[i] == before[0]), after[0]
        raise AssertionError("the arc moves no finger")


def _replaced(placements: Placements, finger: int, target: int) -> Placements:
    return (*placements[:finger], target, *placements[finger + 1 :])


def _path(parent: dict[Node, Node], node: Node) -> list[Node]:
    path = [node]
    while path[-1] in parent:
        path.append(parent[path[-1]])
    return path[::-1]
