"""The plain search of the reference against the planners, on random small problems."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.plain.search import plain_search
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.verify.counting import Result, count

AGREE = 1e-6


@count(instances=300)
def search_agreement(instance: int) -> Result:
    """The plain search with HiGHS, astar and dijkstra with the kernel: same optimum (1e-6)."""
    name = f"random/small/{instance}"
    problem = load(name).problem
    optimum = plain_search(problem).cost
    gaps = [gap(solve(problem, planner), optimum) for planner in ("astar", "dijkstra")]
    return Result(holds=max(gaps) <= AGREE, worst=max(gaps), note=f"{name}: gaps {gaps}")


def solve(problem: Problem, planner: str) -> SearchResult:
    """Solve with the kernel."""
    judge = Judge(problem, make_backend(problem))
    return make_planner(planner).solve(problem, judge, Budget(), np.random.default_rng(0))


def cost_of(result: SearchResult) -> float:
    """Return the optimal cost, +inf where there is no plan."""
    if result.status is Status.INFEASIBLE:
        return math.inf
    assert result.optimal and result.cost is not None
    return result.cost


def gap(result: SearchResult, optimum: float) -> float:
    """Return the relative difference of a result from the optimum; +inf where statuses differ."""
    if np.isinf(optimum):
        return 0.0 if result.status is Status.INFEASIBLE else np.inf
    if result.status is not Status.SOLVED or not result.optimal or result.cost is None:
        return np.inf
    return abs(result.cost - optimum) / max(optimum, 1e-12)
