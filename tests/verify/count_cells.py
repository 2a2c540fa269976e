"""The search over cells of placements against the one over lanes and the plain search."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.plain.search import plain_search
from gm_ompl.planners import lane_parts
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.verify.count_searches import AGREE, cost_of
from tests.verify.counting import Result, count

SHAPES = ("shapes/hexagon", "shapes/l-bracket", "paper/tumble", "paper/regrasp")


@count(instances=200)
def cells_agreement(instance: int) -> Result:
    """Cells, lanes one by one and the plain search with HiGHS: same optimum (1e-6)."""
    name = f"random/small/{instance}"
    problem = load(name).problem
    return _agreement(name, problem, plain_search(problem).cost)


@count(instances=100)
def cells_on_shapes(instance: int) -> Result:
    """Boxes, a hexagon and an L-bracket, any friction and wall: cells and lanes agree (1e-6)."""
    rng = np.random.default_rng(instance)
    name = SHAPES[instance % len(SHAPES)]
    grid = rng.integers(2, 6, 2).tolist()
    scale = float(rng.uniform(0.8, 1.2))
    changes = [f"fingers.placements.grid={grid}", f"mechanics.cone_edges={rng.integers(4, 9)}"]
    nominal = load(name).problem.fingers.friction[0]
    problem = load(name, [*changes, f"friction.finger={scale * nominal:.6g}"]).problem
    return _agreement(f"{name} {changes} {scale:.3f}", problem, None)


def _agreement(name: str, problem: Problem, optimum: float | None) -> Result:
    """Compare cells, lanes and, where it is given, the optimum."""
    costs = [_cost(problem, few) for few in (-1, 10**30)]
    costs += [] if optimum is None else [optimum]
    if math.inf in costs:
        same, worst = set(costs) == {math.inf}, None
    else:
        worst = (max(costs) - min(costs)) / max(*costs, 1e-12)
        same = worst <= AGREE
    return Result(holds=same, worst=worst, note=f"{name}: costs {costs}")


def _cost(problem: Problem, few: int) -> float:
    """Return the optimal cost with lanes taken one by one up to ``few`` sets."""
    before, lane_parts.FEW_SETS = lane_parts.FEW_SETS, few  # type: ignore[misc]
    try:
        judge = Judge(problem, KernelBackend(problem))
        rng = np.random.default_rng(0)
        return cost_of(make_planner("astar").solve(problem, judge, Budget(), rng))
    finally:
        lane_parts.FEW_SETS = before  # type: ignore[misc]
