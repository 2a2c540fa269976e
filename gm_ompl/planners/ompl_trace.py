"""Between vertices as a trace tells them and what OMPL's planners explored, both ways."""

from __future__ import annotations

import itertools
from collections import defaultdict, deque
from collections.abc import Iterator, Sequence
from typing import final

from gm_ompl.moves import Move
from gm_ompl.planners.planner import Progress
from gm_ompl.planners.trace import Expansion, Trace, Vertex
from gm_ompl.sampling.motions import UNPLACED, ContinuousModel, HybridState
from gm_ompl.sampling.stages import states_along
from gm_ompl.space.motions import Motions
from gm_ompl.space.planner_data import Tree


@final
class Grown:
    """Hears of vertices, and makes what a planner of OMPL would call its data of them.

    It is a search's ``report``.
    """

    def __init__(self) -> None:
        self._vertices: dict[int, Vertex] = {}

    def __call__(self, _: Progress) -> None:
        """Pass over progress."""

    def trace(self, event: Expansion | Vertex) -> None:
        """Keep ``event`` if it is a vertex."""
        if isinstance(event, Vertex):
            self._vertices[event.number] = event

    def tree(self, model: ContinuousModel, start: HybridState, moves: Sequence[Move]) -> Tree:
        """Return the trees and the plan as one graph, each state once, edges as executed.

        Args:
            model: tells the goal.
            start: the virtual start, from which the roots are reached for free.
            moves: the plan, if any.
        """
        numbers = {start: 0}
        edges: dict[tuple[int, int], None] = {}

        def number(state: HybridState) -> int:
            return numbers.setdefault(state, len(numbers))

        backward = set()
        for vertex in self._vertices.values():
            here = number(_state(vertex))
            if vertex.tree == "goal":
                backward.add(here)
            if vertex.parent is not None:
                parent = number(_state(self._vertices[vertex.parent]))
                edges[(here, parent) if vertex.tree == "goal" else (parent, here)] = None
            elif vertex.tree == "start":
                edges[0, here] = None
        for before, after in itertools.pairwise([start, *states_along(moves)]):
            edges[number(before), number(after)] = None
        edges.pop((0, 0), None)  # where the start's placements are given, it is a root itself
        return Tree(
            states=tuple(numbers),
            edges=tuple(edges),
            starts=frozenset([0]),
            goals=frozenset(k for state, k in numbers.items() if k and model.in_goal(state)),
            backward=frozenset(backward),
        )


def _state(vertex: Vertex) -> HybridState:
    return HybridState(vertex.q, vertex.placements)


def tell(tree: Tree, motions: Motions, trace: Trace) -> None:
    """Tell ``trace`` of what one of OMPL's planners explored.

    A motion is told as what it consists of: a vertex after each regrasp, one at its end.

    Args:
        tree: what was explored.
        motions: what motions consist of; those of the tree are remembered.
        trace: who hears of it.
    """
    numbers = itertools.count()
    for root in ("start", "goal"):
        told: dict[HybridState, Vertex] = {}
        for tail, head in _outward(tree, root):
            a, b = (head, tail) if root == "goal" else (tail, head)
            parent: Vertex | None = None
            way = _way(tree.states[a], tree.states[b], motions)
            for state in reversed(way) if root == "goal" else way:
                vertex = told.get(state)
                if vertex is None:
                    vertex = told[state] = _vertex(next(numbers), parent, state, root)
                    trace(vertex)
                parent = vertex


def _vertex(number: int, parent: Vertex | None, state: HybridState, root: str) -> Vertex:
    if parent is None:
        return Vertex(number, None, *state, "root", root)
    kind = "displacement" if parent.q != state.q else "regrasp"
    return Vertex(number, parent.number, *state, kind, root)


def _outward(tree: Tree, root: str) -> Iterator[tuple[int, int]]:
    """Yield (known, new vertex) from the roots of one of the trees to its leaves; roots first."""
    backward = root == "goal"
    onward = defaultdict[int, list[int]](list)
    for a, b in tree.edges:
        if (a in tree.backward) == (b in tree.backward) == backward:
            tail, head = (b, a) if backward else (a, b)
            onward[tail].append(head)
    ends = sorted(tree.goals & tree.backward if backward else tree.starts)
    for end in ends:
        if UNPLACED not in tree.states[end].placements:
            yield end, end
    seen, waiting = set(ends), deque(ends)
    while waiting:
        tail = waiting.popleft()
        for head in onward[tail]:
            if head not in seen:
                seen.add(head)
                waiting.append(head)
                yield tail, head


def _way(origin: HybridState, target: HybridState, motions: Motions) -> list[HybridState]:
    """Return the states between which the motion changes one thing at a time."""
    placed = HybridState(
        origin.q,
        tuple(
            b if a == UNPLACED else a
            for a, b in zip(origin.placements, target.placements, strict=True)
        ),
    )
    moves = motions.expand(origin, target) or ()
    regrasped = [state for state in states_along(moves) if state.q == origin.q]
    way = [placed, *regrasped, HybridState(origin.q, target.placements), target]
    return [state for k, state in enumerate(way) if k == 0 or state != way[k - 1]]
