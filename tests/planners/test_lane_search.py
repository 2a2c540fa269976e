"""The search over lanes and hubs, against Dijkstra's algorithm on the paper's graph."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.geometry import NodeGeometry
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph import hub_bounds
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.holds.sets import LIFTED
from gm_ompl.planners import lane_search, lane_sources
from gm_ompl.planners.lattice_astar import has_lanes
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Placements, Problem, Regrasp
from gm_ompl.scenario.load import load

FAMILIES = ("slide", "push", "tumble", "regrasp", "chain")
COARSE = ("fingers.placements.grid=[3, 2]", "cost.samples_per_arc=2")


def solve(problem: Problem, planner: str = "astar", budget: Budget | None = None) -> SearchResult:
    """Solve with the kernel."""
    judge = Judge(problem, KernelBackend(problem))
    assert has_lanes(problem, judge)
    rng = np.random.default_rng(0)
    return make_planner(planner).solve(problem, judge, budget or Budget(), rng)


def same(ours: SearchResult, other: SearchResult) -> None:
    """Check two finished searches for the same outcome."""
    assert ours.status is other.status
    if other.cost is None:
        assert ours.cost is None
        assert ours.lower_bound == math.inf
    else:
        assert ours.optimal
        assert ours.cost == pytest.approx(other.cost, rel=1e-6, abs=1e-12)


def coarse(family: str, seed: int) -> Problem:
    """Return a random problem on a lattice small enough for Dijkstra's algorithm."""
    segments = "[3, 4, 3]" if family == "chain" else "7"
    return load(f"random/{family}/{seed}", [*COARSE, f"lattice.segments={segments}"]).problem


@pytest.fixture
def restless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the search renew keys and sweep all lanes at almost every step."""
    monkeypatch.setattr(lane_search, "FIRST_SWEEP", 2.0)
    monkeypatch.setattr(lane_sources, "LARGEST_BLOCK", 3)
    price = LaneGraph.sweep_price
    monkeypatch.setattr(LaneGraph, "sweep_price", lambda graph: 1e-9 * price(graph))


@pytest.mark.parametrize("seed", range(40))
def test_small_problems(seed: int) -> None:
    """On random small problems the optimum, or that there is none, is Dijkstra's."""
    problem = load(f"random/small/{seed}").problem
    same(solve(problem), solve(problem, "dijkstra"))


@pytest.mark.parametrize(("family", "seed"), list(itertools.product(FAMILIES, range(3))))
def test_families(family: str, seed: int) -> None:
    """Likewise for the families that planning is tried on."""
    problem = coarse(family, seed)
    same(solve(problem), solve(problem, "dijkstra"))


@pytest.mark.usefixtures("restless")
@pytest.mark.parametrize("name", [f"random/small/{s}" for s in range(0, 40, 3)])
def test_sweeps_change_nothing(name: str) -> None:
    """Bounds renewed at every step, several regrasps ahead, lead to the same optimum."""
    problem = load(name).problem
    same(solve(problem), solve(problem, "dijkstra"))


@pytest.mark.usefixtures("restless")
@pytest.mark.parametrize(("family", "seed"), [("regrasp", 1), ("regrasp", 3), ("chain", 6)])
def test_sweeps_change_nothing_in_families(family: str, seed: int) -> None:
    """Likewise where several regrasps are needed, or none will do."""
    problem = coarse(family, seed)
    same(solve(problem), solve(problem, "dijkstra"))


@pytest.mark.parametrize("X_regr", [0.0, 0.3, 1e6])
@pytest.mark.parametrize("seed", [4, 10, 34, 43])
def test_any_cost_of_regrasping(X_regr: float, seed: int) -> None:
    """The optimum is found, and the search ends, whatever a regrasp costs."""
    problem = load(f"random/small/{seed}", [f"cost.regrasp={X_regr}"]).problem
    same(solve(problem), solve(problem, "dijkstra"))


@pytest.mark.parametrize("seed", range(0, 30, 2))
def test_hands_too_large_to_list(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Start sets made on demand, without sweeps, lead to the same optimum."""
    monkeypatch.setattr(lane_sources, "MOST_SETS", 0)
    monkeypatch.setattr(hub_bounds, "MOST_HELD", 0)
    problem = load(f"random/small/{seed}").problem
    same(solve(problem), solve(problem, "dijkstra"))


def test_bounds_of_hubs_are_below_the_cost_to_go() -> None:
    """After a sweep no hub's bound exceeds the cost of the optimal plan's rest from there."""
    problem = coarse("regrasp", 3)
    judge = Judge(problem, KernelBackend(problem))
    graph = LaneGraph(problem, judge, judge.backend)  # type: ignore[arg-type]
    assert graph.sweep_price() < math.inf
    graph.sweep()
    result = solve(problem)
    assert result.cost is not None
    left = result.cost
    for move in result.moves:
        left -= move.cost
        if isinstance(move, Regrasp):
            lifted = (*move.placements[: move.finger], LIFTED, *move.placements[move.finger + 1 :])
            assert graph.bounds is not None
            hub: Placements = graph.sets.canonical(lifted)
            config = problem.lattice.find(move.at)
            assert config is not None
            assert graph.bounds.row(hub)[config] <= left * (1 + 1e-9)


@pytest.mark.parametrize("limit", [0, 1, 5, 20, 60])
def test_a_spent_budget_leaves_a_valid_bound(limit: int) -> None:
    """Whatever number of lanes is allowed, the bound stays below the optimum."""
    problem = coarse("regrasp", 1)
    optimum = solve(problem).cost
    result = solve(problem, budget=Budget(max_iterations=limit))
    assert optimum is not None
    assert result.lower_bound <= optimum * (1 + 1e-9)
    if result.cost is None:
        assert result.status is Status.BUDGET
    else:
        assert result.cost >= optimum * (1 - 1e-9)


def test_an_interrupt_keeps_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C during a mode decision ends the search as INTERRUPTED, with a valid bound."""
    problem = coarse("tumble", 1)
    optimum = solve(problem).cost
    asked = []
    decide = KernelBackend.decide

    def interrupted(self: KernelBackend, *args: object) -> ModeDecision:
        asked.append(args)
        if len(asked) > 10:
            raise KeyboardInterrupt
        return decide(self, *args)  # type: ignore[arg-type]

    monkeypatch.setattr(KernelBackend, "decide", interrupted)
    result = solve(problem)
    assert result.status is Status.INTERRUPTED
    assert optimum is not None
    assert 0.0 < result.lower_bound <= optimum * (1 + 1e-9)


def test_the_same_problem_gives_the_same_plan() -> None:
    """Two searches return the same moves and do the same work."""
    problem = coarse("tumble", 2)
    first, second = solve(problem), solve(problem)
    assert first.moves == second.moves
    assert first.statistics["expanded"] == second.statistics["expanded"]


def test_given_places_are_kept() -> None:
    """Given start and goal placements hold at the ends of the plan, at Dijkstra's optimum."""
    problem = coarse("slide", 1)
    plan = solve(problem)
    hand = plan.moves[0].placements
    goal = (hand[1], hand[0], *hand[2:])
    fingers = dataclasses.replace(problem.fingers, start=hand, goal=goal)
    swapped = dataclasses.replace(problem, fingers=fingers)
    assert swapped.object_graph.start == 0
    assert swapped.object_graph.goal_nodes == (problem.lattice.size - 1,)
    same(solve(swapped), solve(swapped, "dijkstra"))


@pytest.mark.parametrize(("family", "seed"), [("slide", 0), ("push", 1), ("push", 2)])
def test_every_placement_is_blocked_somewhere(
    family: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plan that must regrasp twice, as each placement is free on a part of the way, is found."""
    problem = load(
        f"random/{family}/{seed}", [*COARSE, "lattice.segments=7", "mechanics.z_min=1e-9"]
    ).problem
    part = np.arange(len(problem.fingers.placements)) % 3
    first, last = np.array([0.0, 0.28, 0.57])[part], np.array([0.5, 0.72, 1.0])[part]
    geometry = Judge.node

    nodes = [problem.lattice.coordinates(k) for k in range(problem.lattice.size)]
    known = {problem.motion.pose(q).key: q[0] for q in nodes}

    def windowed(self: Judge, pose: Pose) -> NodeGeometry:
        node, s = geometry(self, pose), known[pose.key]
        inside = (first <= s) & (s <= last)
        return NodeGeometry(node.object_free, tuple(mask & inside for mask in node.free))

    monkeypatch.setattr(Judge, "node", windowed)
    same(solve(problem), solve(problem, "dijkstra"))


def test_the_budget_is_heard_while_tables_are_made() -> None:
    """A path of 3,000 arcs, told to stop after ten poses: no further pose is looked at."""
    problem = load("paper/slide", ["lattice.segments=3000"]).problem
    judge = Judge(problem, make_backend(problem))
    budget = Budget(stop=lambda: judge.configurations >= 10)
    found = make_planner("astar").solve(problem, judge, budget, np.random.default_rng(0))
    assert found.status is Status.BUDGET
    assert judge.configurations == 10
    assert found.lower_bound == 0.0
