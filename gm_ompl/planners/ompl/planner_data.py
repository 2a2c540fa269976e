"""OMPL's PlannerData with our costs as weights, and with states of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ompl import base as ob

from gm_ompl.planners.ompl.convert import Codec
from gm_ompl.planners.ompl.motions import Motions
from gm_ompl.sampling.motions import HybridState

START_TAG, GOAL_TAG = 1, 2
"""What OMPL's planners of two trees tag vertices with."""


@dataclass(frozen=True)
class Explored:
    """What a planner explored; with two trees, both and what joins them.

    Attributes:
        states: the vertices.
        edges: (from, to), numbers of vertices, in the direction of execution.
        starts: vertices that are starts.
        goals: vertices that are goals.
        backward: vertices that grew from the goal; OMPL tags them so.
    """

    states: tuple[HybridState, ...]
    edges: tuple[tuple[int, int], ...]
    starts: frozenset[int]
    goals: frozenset[int]
    backward: frozenset[int] = frozenset()


def tree_of(data: Any, codec: Codec) -> Explored:
    """Return what OMPL's ``data`` holds; its planner must not have been cleared."""
    count = data.numVertices()
    return Explored(
        states=tuple(codec.read(data.getVertex(k).getState()) for k in range(count)),
        edges=tuple((k, int(other)) for k in range(count) for other in data.getEdges(k)),
        starts=frozenset(k for k in range(count) if data.isStartVertex(k)),
        goals=frozenset(k for k in range(count) if data.isGoalVertex(k)),
        backward=frozenset(k for k in range(count) if data.getVertex(k).getTag() == GOAL_TAG),
    )


def planner_data(si: Any, codec: Codec, motions: Motions, tree: Explored) -> Any:
    """Return ``tree`` as OMPL's ``PlannerData``, each edge weighted by Eqs. (9) and (10)."""
    data = ob.PlannerData(si)
    kept = []  # vertices are known by their states' addresses until they are decoupled
    for number, meaning in enumerate(tree.states):
        state = si.allocState()
        codec.write(state, meaning)
        tag = GOAL_TAG if number in tree.backward else START_TAG
        vertex = ob.PlannerDataVertex(state, tag)
        kept.append((state, vertex))
        if number in tree.starts:
            data.addStartVertex(vertex)
        elif number in tree.goals:
            data.addGoalVertex(vertex)
        else:
            data.addVertex(vertex)
    for a, b in tree.edges:
        cost = motions.cost(tree.states[a], tree.states[b])
        data.addEdge(a, b, ob.PlannerDataEdge(), ob.Cost(cost))
    data.decoupleFromPlanner()
    return data
