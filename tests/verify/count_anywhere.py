"""Continuous placements: no plan at sampled placements, or on finer grids, beats the bound."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

import gm_ompl
from gm_ompl.checking.check import check
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.patches import loose, patches
from gm_ompl.planners.planner import Budget, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.cylinders import cylinder
from tests.verify.counting import Result, count

EQUAL = 1e-9
PRODUCTS = 600
"""Products per plan; where they do not suffice for the gap, the bound is judged all the same."""
SHAPES = ("paper/slide", "paper/tumble", "paper/regrasp", "shapes/hexagon", "shapes/l-bracket")

OTHERS = (
    ("planar/turn", 0.3), ("planar/corner", 0.5), ("free/stairs", 0.25), ("tasks/flip-cube", 0.1),
    ("tasks/ledge", 0.02), ("paper/regrasp", 0.5), ("shapes/hexagon", 0.2),
)  # fmt: skip
"""Scenarios of all kinds of motion, with margins."""
SAMPLING = ("HybridRRT", "HybridRRTConnect", "HybridRRTstar")
ON_LATTICE = {"smoothing_share": 0.0, "stall_limit": 100_000, "new_route_share": 0.001}
"""The object stays on the lattice of a path, which the bound is for."""


@count(instances=200)
def anywhere_bound(instance: int) -> Result:
    """No plan at sampled placements or on finer grids beats the bound; the plan holds."""
    name = f"random/small/{instance}"
    scenario = load(name)
    tree = scenario.resolved()
    size = min(tree["object"]["shape"]["box"])
    return judged(name, tree, float(f"{0.05 * size:.3g}"), 0.02, instance)


@count(instances=60)
def anywhere_on_shapes(instance: int) -> Result:
    """The same of the paper's problems, a hexagon, an L-bracket and a 96-facet cylinder."""
    rng = np.random.default_rng(instance)
    kind = instance % (len(SHAPES) + 1)
    tree = load(SHAPES[kind]).resolved() if kind < len(SHAPES) else cylinder(96)
    scale = float(rng.uniform(0.8, 1.3))
    friction = tree["friction"]["finger"]
    tree["friction"]["finger"] = float(f"{scale * np.max(friction):.4g}")
    tree["fingers"]["placements"]["grid"] = rng.integers(2, 4, 2).tolist()
    for key in ("start", "goal"):
        tree["fingers"][key] = "any"
    diagonal = load(tree).problem.body.diagonal
    return judged(
        f"shape {kind} {scale:.3f}", tree, float(f"{0.02 * diagonal:.3g}"), 0.05, instance
    )


@count(instances=150)
def anywhere_sampled(instance: int) -> Result:
    """Plans of hybrid planners at sampled placements hold; none on the lattice beats the bound."""
    rng = np.random.default_rng(instance)
    if instance % 3:
        tree = load(f"random/small/{instance}").resolved()
        margin = float(f"{0.05 * min(tree['object']['shape']['box']):.3g}")
    else:
        name, margin = OTHERS[instance // 3 % len(OTHERS)]
        tree = load(name).resolved()
        friction = float(rng.uniform(0.9, 1.4)) * float(np.max(tree["friction"]["finger"]))
        tree["friction"]["finger"] = float(f"{friction:.4g}")
    tree["fingers"]["placements"].pop("margin", None)
    scenario = _with(tree, {"continuous": {"margin": margin, "gap": 0.02}})
    planner = SAMPLING[instance // 2 % len(SAMPLING)]
    iterations = 40 if planner == "HybridRRTstar" else 300
    plan = gm_ompl.plan(scenario, planner, max_iterations=iterations, seed=instance)
    on_lattice = gm_ompl.plan(
        scenario, "HybridRRTstar", max_iterations=40, seed=instance, parameters=ON_LATTICE
    )
    bound = 0.0
    if scenario.problem.motion.dimension == 1:
        proven = gm_ompl.plan(scenario, max_iterations=PRODUCTS)
        bound = math.inf if proven.status == "infeasible" else proven.lower_bound or 0.0
    cost = math.inf if on_lattice.cost is None else on_lattice.cost
    holds = all(not found.steps or check(found).holds for found in (plan, on_lattice))
    note = f"{instance}: {planner} {plan.status} {plan.cost}, on the lattice {cost}, bound {bound}"
    return Result(
        holds=holds and cost >= bound * (1.0 - EQUAL),
        worst=cost / bound - 1.0 if bound and math.inf not in (cost, bound) else None,
        note=note,
        outcome=plan.status,
    )


def judged(name: str, tree: dict[str, Any], margin: float, gap: float, seed: int) -> Result:
    """Plan anywhere on the faces; compare the bound with plans at placements on the faces."""
    tree["fingers"]["placements"].pop("margin", None)
    loosened = _with(tree, {"continuous": {"margin": margin, "gap": gap}})
    plan = gm_ompl.plan(loosened, max_iterations=PRODUCTS)
    bound = math.inf if plan.status == "infeasible" else plan.lower_bound or 0.0
    finer = (1, 3, 9) if seed % 4 == 0 else (1, 3)
    others = [_on_grid(tree, margin, times) for times in finer]
    others += [_at_random(loosened.problem, seed + k) for k in range(2)]
    cost = math.inf if plan.cost is None else plan.cost
    least = min(others)
    holds = check(plan).holds and least >= bound * (1.0 - EQUAL) and cost >= bound
    near = cost < math.inf and cost <= bound * (1.0 + gap + EQUAL)
    worst = None if math.inf in (least, bound) or not bound else cost / bound - 1.0
    note = f"{name}: bound {bound}, cost {cost}, others {others}, {plan.status}"
    return Result(
        holds=bool(holds), worst=worst, note=note, outcome="gap reached" if near else plan.status
    )


def _with(tree: dict[str, Any], more: dict[str, Any], times: int = 1) -> Scenario:
    """Return a scenario with more said of its placements, on a finer grid."""
    hand = tree["fingers"]
    grid = [times * k for k in hand["placements"]["grid"]]
    changed = {**hand, "placements": {**hand["placements"], **more, "grid": grid}}
    for key in ("start", "goal"):
        if not isinstance(hand[key], str):
            changed[key] = [_finer(place, times) for place in hand[key]]
    return Scenario.from_resolved({**tree, "fingers": changed})


def _finer(place: Any, times: int) -> Any:
    """Return a placement on a grid that many times finer: the same point."""
    if isinstance(place, str):
        return place
    return {**place, "cell": [times * k + times // 2 for k in place["cell"]]}


def _on_grid(tree: dict[str, Any], margin: float, times: int) -> float:
    """Return the least cost on a grid that many times finer, or what was found of it."""
    problem = _with(tree, {"margin": margin}, times).problem
    judge, rng = Judge(problem, KernelBackend(problem)), np.random.default_rng(0)
    return _cost(make_planner("astar").solve(problem, judge, Budget(max_iterations=1000), rng))


def _cost(result: SearchResult) -> float:
    """Return the cost of the plan found, +inf without one."""
    return math.inf if result.cost is None else result.cost


def _at_random(problem: Problem, seed: int) -> float:
    """Return the least cost over some random placements on the faces."""
    hand, where, rng = problem.fingers, problem.fingers.anywhere, np.random.default_rng(seed)
    assert where is not None
    found = patches(problem.body, where.faces, where.margin)
    which, points = [], []
    for f in rng.integers(0, len(found), 16).tolist():
        half = found[f].rectangle.half
        spot = found[f].points(rng.uniform(-half, half)[None])
        if found[f].offers(spot)[0]:
            which.append(f)
            points.append(spot[0])
    if not points:
        return math.inf
    table = loose(found, which, np.array(points), hand.placements.labels)
    given = [row for row in (*hand.start, *hand.goal) if row is not None]
    table = hand.placements.at(given).joined(table)
    rows = iter(range(len(given)))
    start, goal = (
        tuple(None if row is None else next(rows) for row in each)
        for each in (hand.start, hand.goal)
    )
    placed = dataclasses.replace(hand, placements=table, start=start, goal=goal, anywhere=None)
    sampled = dataclasses.replace(problem, fingers=placed)
    judge = Judge(sampled, KernelBackend(sampled))
    return _cost(make_planner("astar").solve(sampled, judge, Budget(), np.random.default_rng(0)))
