"""Regrasps that cost nothing: none is made for nothing, and the optimum stays what it is."""

from __future__ import annotations

import dataclasses
import heapq
import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from gm_ompl import api
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.plain.judge import ReferenceJudge
from gm_ompl.plain.search import Graph
from gm_ompl.planners.hybrid_planners import refine
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.price import LEAST, priced
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Move, Problem, Regrasp
from gm_ompl.scenario.load import load

FREE = "cost.regrasp=0"

SEEDS = (0, 7, 58)
"""Seeds of ``random/small``: no regrasp is needed, there is no plan, one regrasp is needed."""

UNIT = 1e-9
"""Costs are counted in whole multiples of this, so that sums of equal costs are equal."""


def fewest(problem: Problem, decide: object) -> tuple[float, int] | None:
    """Return the least cost and the fewest regrasps that it needs; None without a plan."""
    graph = Graph(problem, ReferenceJudge(problem, decide))  # type: ignore[arg-type]
    known = dict.fromkeys(graph.starts(), (0, 0))
    order = itertools.count()
    queue = [(cost, next(order), node) for node, cost in known.items()]
    done = set()
    while queue:
        reached, _, node = heapq.heappop(queue)
        if node in done:
            continue
        done.add(node)
        if graph.is_goal(node):
            return reached[0] * UNIT, reached[1]
        for head, length in graph.arcs_from(node):
            through = (reached[0] + round(length / UNIT), reached[1] + (head[0] == node[0]))
            if head not in known or through < known[head]:
                known[head] = through
                heapq.heappush(queue, (through, next(order), head))
    return None


@pytest.mark.parametrize("seed", SEEDS)
def test_exact_planners_regrasp_as_rarely_as_the_optimum_allows(
    seed: int, shared_decisions: Callable[[Problem], object]
) -> None:
    """astar and dijkstra find the least cost, and of its plans one with fewest regrasps.

    Second opinion: a plain search by (cost, regrasps) in whole numbers, on HiGHS's decisions.
    """
    scenario = load(f"random/small/{seed}", [FREE])
    expected = fewest(scenario.problem, shared_decisions(scenario.problem))
    for planner in ("astar", "dijkstra"):
        plan = api.plan(scenario, planner)
        assert all(step.cost == 0.0 for step in plan.steps if step.kind == "regrasp")
        if expected is None:
            assert plan.status == "infeasible"
            continue
        assert plan.cost == pytest.approx(expected[0], rel=1e-6)
        assert plan.regrasps == expected[1]
        assert plan.cost is not None and plan.lower_bound is not None
        assert plan.optimal and plan.lower_bound <= plan.cost


def test_a_price_is_next_to_nothing() -> None:
    """A problem with dear regrasps is searched as it is, one with free ones at 1e-9 diagonals."""
    dear, free = load("paper/slide").problem, load("paper/slide", [FREE]).problem
    assert priced(dear) is dear
    assert priced(free).cost.regrasp == LEAST * free.body.diagonal
    assert dataclasses.replace(priced(free).cost, regrasp=0.0) == free.cost


SMALL = [FREE, "lattice.segments=3", "fingers.placements.grid=[2, 1]"]


@pytest.mark.parametrize("name", ["paper/slide", "paper/push"])
def test_a_planner_that_improves_goes_in_no_circles(name: str) -> None:
    """HybridRRTstar comes to the optimum of small problems without a regrasp, as astar does."""
    scenario = load(name, SMALL)
    optimum = api.plan(scenario)
    plan = api.plan(scenario, "HybridRRTstar", max_iterations=100)
    assert (plan.regrasps, optimum.regrasps) == (0, 0)
    assert plan.cost == pytest.approx(optimum.cost, rel=1e-6)


def test_refining_drops_regrasps_that_cost_nothing() -> None:
    """Of a plan that regrasps for nothing, refinement leaves no such regrasp, at the same cost."""
    problem = load("paper/slide", SMALL).problem
    judge, rng = Judge(problem, make_backend(problem)), np.random.default_rng(0)
    moves = make_planner("dijkstra").solve(problem, judge, Budget(), rng).moves  # not priced
    assert _regrasps(moves) > 0
    refined = refine(problem, judge, moves, Budget(max_iterations=1), rng)
    assert _regrasps(refined) == 0
    assert _cost(refined) <= _cost(moves) * (1 + 1e-9)


def _regrasps(moves: Sequence[Move]) -> int:
    return sum(isinstance(move, Regrasp) for move in moves)


def _cost(moves: Sequence[Move]) -> float:
    return math.fsum(move.cost for move in moves)
