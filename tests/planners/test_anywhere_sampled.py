"""Continuous placements by the hybrid planners: plans hold, and come near the proven least cost."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import gm_ompl
from gm_ompl.asking import judge_of
from gm_ompl.diagnosis.remedies import search
from gm_ompl.geometry.patches import patches
from gm_ompl.holds.extraction import moves_of
from gm_ompl.holds.spots import NamedPoints, Spots
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.sampling.climb import Climb
from gm_ompl.sampling.drawing import drawn
from gm_ompl.sampling.finger_moves import FingerMoves
from gm_ompl.sampling.placing import Placing
from gm_ompl.sampling.plan_way import way_and_legs
from gm_ompl.sampling.route_maker import RouteMaker
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario

SCENARIOS = {
    "paper/slide": 0.5,
    "paper/push": 0.5,
    "paper/tumble": 0.5,
    "paper/regrasp": 0.5,
    "planar/turn": 0.3,
    "planar/corner": 0.5,
    "free/stairs": 0.25,
    "tasks/flip-cube": 0.1,
    "tasks/ledge": 0.02,
}
"""With margins."""

FIRST = ("HybridRRT", "HybridRRTConnect")


def loosened(name: str, more: dict[str, Any] | None = None, gap: str = "1%") -> Scenario:
    """Return a scenario with continuous placements."""
    said = {"margin": SCENARIOS[name], "gap": gap}
    fewer = {"lattice.segments": 10} if name.startswith("paper/") else {}
    return load(name, {"fingers.placements.continuous": said, **fewer, **(more or {})})


def solved(problem: Problem, planner: str, seed: int, most: int) -> SearchResult:
    """Return what a planner finds in so many iterations."""
    rng, budget = np.random.default_rng(seed), Budget(max_iterations=most)
    return make_planner(planner).solve(problem, judge_of(problem), budget, rng)


@pytest.mark.parametrize("name", SCENARIOS)
def test_first_plans_hold(name: str) -> None:
    """Paths, the plane and free motion: a plan at points on no grid that passes the check."""
    plan = gm_ompl.plan(loosened(name), "HybridRRTConnect", max_iterations=500, seed=1)
    assert plan.status == "solved"
    assert plan.lower_bound == 0.0
    assert not plan.optimal
    assert all(place.cell is None for step in plan.steps for place in step.placements)
    report = gm_ompl.check(plan)
    assert report.holds, report.violations


@pytest.mark.parametrize("name", ["paper/tumble", "planar/corner", "free/stairs"])
def test_better_plans_hold(name: str) -> None:
    """HybridRRTstar's plan holds, off the lattice too, and costs no more than its first."""
    scenario = loosened(name)
    plan = gm_ompl.plan(scenario, "HybridRRTstar", max_iterations=25, seed=2)
    report = gm_ompl.check(plan)
    assert report.holds, report.violations
    costs = [cost for _, cost, _ in plan.statistics.history if cost is not None]
    assert costs == sorted(costs, reverse=True)
    assert plan.cost is not None
    assert plan.cost <= costs[0] * (1.0 + 1e-9)


def test_the_first_plans_of_many_seeds() -> None:
    """Every seed finds a plan of the paper's problems soon."""
    for name in ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp"):
        problem = loosened(name).problem
        for seed in range(4):
            planner = FIRST[seed % 2]
            assert solved(problem, planner, seed, 200).status is Status.SOLVED, (name, seed)


def test_the_least_cost_is_approached() -> None:
    """Within 3% of what astar proves to be the least of all, and never below."""
    scenario = loosened("paper/tumble", {"lattice.segments": 9}, "3%")
    proven = gm_ompl.plan(scenario)
    assert proven.lower_bound is not None
    # The object stays on the lattice, which the bound is for.
    settings = {"smoothing_share": 0.0, "stall_limit": 100_000}
    plan = gm_ompl.plan(scenario, "HybridRRTstar", max_iterations=50, parameters=settings)
    assert plan.cost is not None
    assert proven.lower_bound <= plan.cost <= 1.06 * proven.lower_bound


def test_the_same_seed_gives_the_same_plan() -> None:
    """Under a limit on iterations."""
    scenario = loosened("paper/regrasp", {"lattice.segments": 9})
    first, again = (
        gm_ompl.plan(scenario, "HybridRRTstar", max_iterations=24, seed=3) for _ in range(2)
    )
    assert first.cost == again.cost
    assert first.steps == again.steps
    assert first.statistics.mode_decisions == again.statistics.mode_decisions


def test_given_hands_are_kept() -> None:
    """Fingers start and end at the grid's placements that the scenario names."""
    start = [{"face": "-x", "cell": [3, 1]}, "any"]
    more = {"fingers.start": start, "fingers.goal": start}
    plan = gm_ompl.plan(loosened("paper/slide", more), "HybridRRTstar", max_iterations=20)
    assert plan.status == "solved"
    for placements in (plan.steps[0].placements, _last(plan)):
        assert ("-x", (3, 1)) in [(place.face, place.cell) for place in placements]
    assert gm_ompl.check(plan).holds


def _last(plan: Plan) -> list[Any]:
    """Return where the fingers are at the end."""
    step = plan.steps[-1]
    placements = list(step.placements)
    if isinstance(step, RegraspStep):
        placements[step.finger] = step.to
    return placements


def test_a_budget_without_a_plan() -> None:
    """Fingers too weak: nothing is found, and nothing is claimed."""
    weak = loosened("paper/tumble", {"fingers.max_normal_force": 0.5, "lattice.segments": 3})
    found = solved(weak.problem, "HybridRRTstar", 0, 150)
    assert found.status is Status.BUDGET
    assert found.lower_bound == 0.0
    assert found.cost is None


def test_an_interrupt_keeps_the_plan() -> None:
    """Ctrl-C ends the search with the best plan so far."""
    problem = loosened("paper/slide", {"lattice.segments": 6}).problem
    asked = 0

    def stop() -> bool:
        nonlocal asked
        asked += 1
        if asked > 40:
            raise KeyboardInterrupt
        return False

    rng = np.random.default_rng(0)
    planner = make_planner("HybridRRTstar")
    found = planner.solve(problem, judge_of(problem), Budget(stop=stop), rng)
    assert found.status is Status.INTERRUPTED
    assert found.cost is not None
    assert found.fingers is not None


def test_explaining_asks_who_can() -> None:
    """Where astar knows the grid alone, the search before an explanation is a sampler's."""
    assert search(loosened("planar/turn").problem, 30.0) is Status.SOLVED
    assert search(loosened("tasks/ledge").problem, 30.0) is Status.SOLVED


def test_drawn_points_are_offered() -> None:
    """Each is on its face, off the rim by the margin; every face has some, the rim has many."""
    for name in ("paper/tumble", "tasks/ledge"):
        problem = loosened(name).problem
        where, spots = problem.fingers.anywhere, Spots(problem)
        assert where is not None
        found = patches(problem.body, where.faces, where.margin)
        points = drawn(spots, 120, np.random.default_rng(0))
        assert {f for f, _ in points} == set(range(len(found)))
        for f, point in points:
            assert found[f].offers(np.array([point]))[0]
            assert abs(found[f].height(np.array([point]))[0]) < 1e-12
        near = spots.around(points[:3], 0.1)
        assert near[::9] == points[:3]
        assert all(spots.offers(spot) for spot in near)


def test_a_plan_s_way_is_the_plan() -> None:
    """Its strides and sets give its moves again, with and without coordinates."""
    for name in ("paper/regrasp", "free/stairs"):
        scenario = load(name)
        judge = judge_of(scenario.problem)
        rng = np.random.default_rng(1)
        found = make_planner("HybridRRTConnect").solve(
            scenario.problem, judge, Budget(max_iterations=300), rng
        )
        way, legs = way_and_legs(scenario.problem, found.moves)
        again = moves_of(judge, way, legs)
        assert len(again) == len(found.moves)
        assert math.fsum(move.cost for move in again) == pytest.approx(found.cost, rel=1e-12)


def test_finger_moves_lower_the_cost() -> None:
    """Each kept move is cheaper and holds; reaches shrink until none is left to try."""
    problem = loosened("paper/tumble", {"lattice.segments": 6}, "10%").problem
    placing, rng = Placing(judge_of(problem)), np.random.default_rng(0)
    plans = (solved(problem, "HybridRRTConnect", seed, 200) for seed in range(9))
    found = next(plan for plan in plans if plan.cost and plan.cost < problem.cost.regrasp)
    assert found.cost is not None
    assert found.fingers is not None
    named = dataclasses.replace(problem, fingers=found.fingers)
    moving, costs = FingerMoves(placing, named, found.moves, rng), [found.cost]
    while not moving.over:
        if moving.step(lambda: False):
            costs.append(moving.plan.cost)
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] < 0.8 * costs[0]
    names = NamedPoints(problem.fingers)
    moves = names.named(moving.plan.moves, moving.plan.table)
    assert names.named(moves, names.table) == moves


def test_climbs_spare_regrasps() -> None:
    """On paper/regrasp a set without regrasp is found where grids of 13 x 13 have none."""
    problem = loosened("paper/regrasp").problem
    judge, rng = judge_of(problem), np.random.default_rng(0)
    placing, route = Placing(judge), RouteMaker(judge, rng).make(lambda: False)
    assert route is not None
    for _ in range(6):
        climb = Climb(placing, route.way, rng)
        while not climb.over:
            climb.step()
        if climb.plan is not None:
            break
    assert climb.plan is not None
    assert climb.plan.cost < problem.cost.regrasp
