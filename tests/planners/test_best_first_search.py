"""The search core on random graphs, against Bellman and Ford."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.planners.astar import BestFirstSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, Status


class RandomGraph:
    """A dense random graph with lazy costs, late arcs, and estimates that grow when asked."""

    def __init__(self, rng: np.random.Generator, n: int = 25, *, zero_costs: bool = False) -> None:
        self.costs = rng.uniform(0.1, 1.0, (n, n))
        if zero_costs:
            self.costs[rng.random((n, n)) < 0.3] = 0.0
        self.costs[rng.random((n, n)) < rng.choice([0.8, 0.9, 0.97])] = math.inf
        self.starts = (0, 1, 2)
        self.goals = {n - 1, n - 2}
        self.truth = self._to_goal()
        self._trust = rng.uniform(0.0, 1.0, n)  # admissible, in general not consistent
        self._lazy = rng.uniform(0.0, 1.0, (n, n))
        self._exact = rng.random((n, n)) < 0.3
        self._asked = np.zeros(n)
        self.judged: list[tuple[int, int]] = []

    def _to_goal(self) -> Array:
        """Bellman and Ford: relax every arc until nothing changes."""
        distances = np.full(len(self.costs), math.inf)
        distances[sorted(self.goals)] = 0.0
        for _ in self.costs:
            distances = np.minimum(distances, (self.costs + distances).min(axis=1))
        return distances

    @property
    def optimum(self) -> float:
        return float(min(self.truth[s] for s in self.starts))

    def sources(self) -> Iterator[tuple[float, int]]:
        for node in self.starts:
            yield 0.0, node

    def starts_at(self, node: int) -> bool:  # noqa: ARG002 (the protocol's signature)
        """All sources are."""
        return True

    def estimate(self, node: int) -> float:
        self._asked[node] = min(self._asked[node] + 1, 4)
        share = self._trust[node] ** (1.0 / self._asked[node])
        truth = float(self.truth[node])
        return truth if truth == math.inf else 0.999 * share * truth

    def is_goal(self, node: int) -> bool:
        return node in self.goals

    def _arcs(self, node: int, parity: int) -> Iterator[tuple[int, float, bool]]:
        for head in range(parity, len(self.costs), 2):
            exact = bool(self._exact[node, head]) and self.costs[node, head] < math.inf
            cost = float(self.costs[node, head])
            yield head, cost if exact else 0.0, exact

    def arcs(self, node: int) -> Iterable[tuple[int, float, bool]]:
        return self._arcs(node, 0)

    def late_arcs(self, node: int) -> Iterable[tuple[int, float, bool]]:
        return self._arcs(node, 1)

    def late_bound(self, node: int) -> float:
        return 0.5 * float(min(self.truth[node], 1e9))

    def optimistic(self, tail: int, head: int) -> float:
        cost = float(self.costs[tail, head])
        return 0.0 if cost == math.inf else float(self._lazy[tail, head]) * cost

    def judge(self, tail: int, head: int) -> float:
        self.judged.append((tail, head))
        return float(self.costs[tail, head])


def search(
    graph: RandomGraph, budget: Budget | None = None
) -> tuple[Status, BestFirstSearch, tuple[int, ...]]:
    made = BestFirstSearch(graph, Log((budget or Budget()).start()))
    return made.run(), made, made.path()


@pytest.mark.parametrize("zero_costs", [False, True])
@pytest.mark.parametrize("seed", range(60))
def test_cost_is_the_shortest_paths(seed: int, zero_costs: bool) -> None:
    """With lazy arcs, late arcs and growing inconsistent estimates the optimum is found."""
    graph = RandomGraph(np.random.default_rng(seed), zero_costs=zero_costs)
    status, found, path = search(graph)
    if graph.optimum == math.inf:
        assert status is Status.INFEASIBLE
        assert found.bound == math.inf
        assert path == ()
        return
    assert status is Status.SOLVED
    assert found.cost == pytest.approx(graph.optimum, rel=1e-9, abs=1e-12)
    assert found.bound == pytest.approx(graph.optimum, rel=1e-9, abs=1e-12)
    assert path[0] in graph.starts
    assert path[-1] in graph.goals
    steps = itertools.pairwise(path)
    assert sum(graph.costs[a, b] for a, b in steps) == pytest.approx(found.cost, abs=1e-12)


def test_both_outcomes_occur() -> None:
    """Among the random graphs some have a path and some have none."""
    optima = [RandomGraph(np.random.default_rng(seed)).optimum for seed in range(60)]
    assert 0 < sum(o == math.inf for o in optima) < 60


@pytest.mark.parametrize("seed", range(20))
def test_the_bound_holds_whenever_the_budget_ends(seed: int) -> None:
    """After any number of expansions the bound is at most the optimum, and never falls."""
    bounds = []
    for limit in range(12):
        graph = RandomGraph(np.random.default_rng(seed))
        status, found, _ = search(graph, Budget(max_iterations=limit))
        assert found.bound <= graph.optimum * (1 + 1e-12)
        assert found.expanded <= limit
        if status is Status.SOLVED:
            assert found.cost >= graph.optimum * (1 - 1e-12)
        bounds.append(found.bound)
    assert bounds == sorted(bounds)


@pytest.mark.parametrize("seed", range(5))
def test_same_graph_same_search(seed: int) -> None:
    """Ties are broken the same way every time: two runs judge the same arcs in the same order."""
    first = RandomGraph(np.random.default_rng(seed))
    second = RandomGraph(np.random.default_rng(seed))
    assert search(first)[2] == search(second)[2]
    assert first.judged == second.judged


def test_an_interrupt_keeps_what_is_known() -> None:
    """Ctrl-C in the middle of a judgement ends the search with its bound and history."""
    graph = RandomGraph(np.random.default_rng(3))
    judged = graph.judge

    def interrupt(tail: int, head: int) -> float:
        if len(graph.judged) == 4:
            raise KeyboardInterrupt
        return judged(tail, head)

    graph.judge = interrupt  # type: ignore[method-assign]
    log = Log(Budget().start())
    found = BestFirstSearch(graph, log)
    status = found.run()
    assert status is Status.INTERRUPTED
    assert 0.0 <= found.bound <= graph.optimum
    assert found.generated > 0
    assert log.history[-1][2] == found.bound
