"""The project's own randomised planners on free motion: a start and a goal, nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gm_ompl
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planfile.arcs import pose_of
from gm_ompl.planners.planner import Budget, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Displacement, Problem
from gm_ompl.scenario.load import load

FIRST = ["HybridRRT", "HybridRRTConnect"]

SOLVABLE = [
    ("tasks/reorient-one-finger", "HybridRRT"), ("free/around", "HybridRRTConnect"),
    ("free/l-bracket", "HybridRRT"), ("free/out-of-the-corner", "HybridRRTConnect"),
    ("free/stairs", "HybridRRT"),
]  # fmt: skip
"""All shipped ones are counted by ``count_free_sampling``."""


def solved(problem: Problem, planner: str, seed: int, iterations: int) -> SearchResult:
    """What a planner finds."""
    judge, budget = Judge(problem, make_backend(problem)), Budget(max_iterations=iterations)
    return make_planner(planner).solve(problem, judge, budget, np.random.default_rng(seed))


@pytest.mark.parametrize(("scenario", "planner"), SOLVABLE)
def test_plans_hold_and_meet_the_goal(scenario: str, planner: str) -> None:
    """Two seeds of two succeed; the goal is met exactly, not up to what it leaves open."""
    problem = load(scenario).problem
    assert isinstance(problem.motion, FreeMotion)
    assert solved(problem, planner, 1, 100).moves
    plan = gm_ompl.plan(scenario, planner, max_iterations=100, seed=0)
    assert plan.status == "solved"
    report = gm_ompl.check(plan)
    assert report.holds, report.table()
    (*_, last) = (step for step in plan.steps if step.kind == "displacement")
    end = pose_of(last.pose_to)
    assert problem.motion.goal.position_error(end) < 1e-8
    assert problem.motion.goal.rotation_error(end) < 1e-7


@pytest.mark.parametrize("planner", [*FIRST, "HybridRRTstar"])
def test_the_same_seed_gives_the_same_plan(planner: str) -> None:
    """Under an iteration limit a seed decides everything."""
    problem = load("tasks/flip-cube", ["fingers.placements.grid=[3, 3]"]).problem
    iterations = 25 if planner == "HybridRRTstar" else 40
    first, again = (solved(problem, planner, 3, iterations) for _ in range(2))
    assert first.moves
    assert first.cost == again.cost
    assert first.moves == again.moves


def test_what_goes_on_comes_near_the_lattice_s_optimum() -> None:
    """HybridRRTstar is within 2% of the least cost on the lattice (astar's: 2.86367719)."""
    found = solved(load("tasks/reorient").problem, "HybridRRTstar", 0, 60)
    assert found.cost is not None
    assert found.cost <= 1.02 * 2.86367719


@pytest.mark.parametrize("planner", [*FIRST, "HybridRRTstar"])
def test_who_is_there_need_not_move(planner: str) -> None:
    """A start in the goal is a plan without a step."""
    goal = "motion.goal={x: [-1, 1], z: [0.4, 0.6], rotation: any}"
    plan = gm_ompl.plan(load("tasks/reorient", [goal]), planner, max_iterations=20)
    assert (plan.status, plan.cost, len(plan.steps)) == ("solved", 0.0, 0)


@pytest.mark.parametrize("goal", [
    "{x: [1, 2], up: +x}", "{x: [-2, -1], up: -z}", "{x: [1, 2], z: [0.55, 0.9], rotation: any}",
])  # fmt: skip
def test_goals_may_leave_things_open(goal: str) -> None:
    """Ranges, a heading that is free, any rotation: the plan ends inside."""
    problem = load("tasks/reorient", [f"motion.goal={goal}"]).problem
    assert isinstance(problem.motion, FreeMotion)
    moves = solved(problem, "HybridRRTConnect", 0, 100).moves
    ends = [move.arc.end for move in moves if isinstance(move, Displacement)]
    assert problem.motion.goal.contains(ends[-1])


def test_nothing_is_claimed_of_what_was_not_found() -> None:
    """A goal in the air that two point fingers cannot hold ends with the budget, no plan."""
    scenario = load("tasks/reorient", ["motion.goal={position: [1, 0, 1.4]}"])
    plan = gm_ompl.plan(scenario, "HybridRRTConnect", time_limit=0.5)
    assert plan.status == "budget"
    assert plan.cost is None
    assert not math.isfinite(plan.lower_bound or math.inf) or plan.lower_bound == 0.0
