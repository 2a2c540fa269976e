"""The heuristic (11) against exact costs to the goal on small lattices."""

from __future__ import annotations

import dataclasses
import heapq
import math
from collections.abc import Callable

import pytest

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.reference_backend import ReferenceBackend
from gm_ompl.graph.heuristic import TravelHeuristic
from gm_ompl.holds.goals import valid_goals
from gm_ompl.holds.sets import LIFTED, PlacementSets
from gm_ompl.plain.judge import Decide, ReferenceJudge
from gm_ompl.plain.search import Graph, Node
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load

Arcs = dict[Node, list[tuple[Node, float]]]


def all_arcs(problem: Problem, decide: Decide) -> tuple[Graph, Arcs]:
    """Return the paper's graph, every arc that can be reached from the start or the goal's sets."""
    graph = Graph(problem, ReferenceJudge(problem, decide))
    arcs: Arcs = {}
    waiting = list(graph.starts())
    while waiting:
        node = waiting.pop()
        if node in arcs:
            continue
        arcs[node] = list(graph.arcs_from(node))
        waiting.extend(head for head, _ in arcs[node])
    return graph, arcs


def costs_to_goal(graph: Graph, arcs: Arcs) -> dict[Node, float]:
    """Return every node's exact cost to the goal, +inf where there is no way."""
    backwards: dict[Node, list[tuple[Node, float]]] = {node: [] for node in arcs}
    for tail, leaving in arcs.items():
        for head, cost in leaving:
            backwards[head].append((tail, cost))
    known: dict[Node, float] = {}
    queue = [(0.0, node) for node in arcs if graph.is_goal(node)]
    while queue:
        cost, node = heapq.heappop(queue)
        if node not in known:
            known[node] = cost
            for tail, step in backwards[node]:
                heapq.heappush(queue, (cost + step, tail))
    return {node: known.get(node, math.inf) for node in arcs}


@pytest.mark.parametrize("X_regr", [None, 0.0, 0.3])
@pytest.mark.parametrize("seed", [0, 5, 10, 70, 73, 76, 88])
def test_admissible_and_consistent(
    seed: int, X_regr: float | None, remembered: Callable[[Problem], Decide]
) -> None:
    """(11) never exceeds the exact cost to the goal, nor an arc's cost plus the head's (11)."""
    problem = load(f"random/small/{seed}").problem
    if X_regr is not None:
        share = X_regr * problem.body.diagonal
        problem = dataclasses.replace(
            problem, cost=dataclasses.replace(problem.cost, regrasp=share)
        )
    decide = remembered(problem)
    judge = Judge(problem, ReferenceBackend(problem, lambda instant: decide(instant, None)))
    h = TravelHeuristic(judge, valid_goals(judge) or ())
    graph, arcs = all_arcs(problem, decide)
    slack = 1e-9 * problem.body.diagonal
    for node, cost in costs_to_goal(graph, arcs).items():
        assert h.estimate(*node) <= cost + slack
        per_finger = h.finger_estimates(node[0])
        assert all(per_finger[i][p] <= h.estimate(*node) + slack for i, p in enumerate(node[1]))
        for head, step in arcs[node]:
            assert h.estimate(*node) <= step + h.estimate(*head) + slack


@pytest.mark.parametrize("seed", [0, 5, 88])
def test_consistent_through_hubs(seed: int) -> None:
    """Lifting a finger costs X_regr, touching down nothing: (11) respects both arcs."""
    problem = load(f"random/small/{seed}").problem
    judge = Judge(problem, ReferenceBackend(problem))
    h = TravelHeuristic(judge, valid_goals(judge) or ())
    sets = PlacementSets(problem.fingers.groups())
    for placements in _some_sets(problem):
        for slot in range(problem.fingers.count):
            hub = sets.replaced(sets.canonical(placements), slot, LIFTED)
            for config in range(problem.lattice.size):
                state = h.estimate(config, sets.canonical(placements))
                lifted = h.estimate(config, hub)
                assert lifted <= state + 1e-12
                assert state <= problem.cost.regrasp + lifted + 1e-12


def _some_sets(problem: Problem) -> list[tuple[int, ...]]:
    P, n = len(problem.fingers.placements), problem.fingers.count
    return [tuple((k + i * (1 + k // P)) % P for i in range(n)) for k in range(2 * P)]
