"""Free motion: start and goal in SE(3), planned exactly on the contact lattice."""

from __future__ import annotations

import copy
from typing import Any

import pytest

import gm_ompl
from gm_ompl.planners.planner import SearchResult, Status
from gm_ompl.problem import Problem
from gm_ompl.reference.search import plain_search
from gm_ompl.scenario.load import load
from tests.verify.count_searches import AGREE, gap, solve

AGREED = ("random/free/2", "random/free/3", "random/free-clutter/2")
"""Solved on lattices so small that the plain search may walk them."""


@pytest.mark.parametrize("name", AGREED)
def test_the_plain_search_finds_the_same_optimum(name: str) -> None:
    """Three searches, two lattices built by different code, one cost."""
    problem = load(name).problem
    optimum = plain_search(problem).cost
    assert max(gap(solve(problem, planner), optimum) for planner in ("astar", "dijkstra")) <= AGREE


def found(problem: Problem) -> SearchResult:
    """What astar finds."""
    return solve(problem, "astar")


def test_infeasible_is_proven() -> None:
    """Where all of the lattice was seen, and no way of holding the object leads to the goal."""
    for seed in (0, 1):
        assert found(load(f"random/free/{seed}").problem).status is Status.INFEASIBLE


def test_plans_hold() -> None:
    """What is planned on the planner's lattice holds on the reference's, arc by arc."""
    for name in ("random/free/2", "random/free-clutter/3"):
        plan = gm_ompl.plan(name)
        assert plan.optimal
        report = gm_ompl.check(plan)
        assert report.holds, report.table()


def straight(free: bool) -> Problem:
    """The paper's box, slid by 6 along a line: as a path, or freely, with nothing else to do."""
    scenario: dict[str, Any] = copy.deepcopy(load("paper/slide").resolved())
    scenario["fingers"]["placements"]["grid"] = [3, 3]
    start = scenario["motion"]["start"]
    scenario["motion"] = {"start": start, "path": [{"slide": {"by": [6, 0, 0]}}]}
    scenario["lattice"] = {"segments": 12}
    if free:
        ways = {"region": {"x": [0, 6], "y": [0, 0], "z": [2.5, 2.5]}, "translate": ["x"]}
        goal = {"position": [6, 0, "rest"], "yaw": "0 deg"}
        scenario["motion"] = {"start": start, "goal": goal, "free": {**ways, "rotate": []}}
        scenario["lattice"] = {"steps": {"translation": 0.5, "rotation": "15 deg"}}
    return load({**scenario, "expect": {}}).problem


def test_a_lattice_of_one_way_is_that_path() -> None:
    """A region and axes that leave one path give the path scenario's optimum."""
    one, other = found(straight(free=True)), found(straight(free=False))
    assert one.optimal
    assert one.cost == pytest.approx(other.cost, rel=1e-9)
    assert len(one.moves) == len(other.moves)


@pytest.mark.parametrize("planner", ["HybridRRTConnect", "RRTConnect"])
def test_other_planners_say_what_to_take(planner: str) -> None:
    """They need coordinates, and name the planners that do not."""
    with pytest.raises(gm_ompl.InputError, match="take astar or dijkstra"):
        gm_ompl.plan("random/free/3", planner, max_iterations=1)


def test_explain_says_what_to_ask() -> None:
    """It needs coordinates, too."""
    with pytest.raises(gm_ompl.InputError, match=r"gm_ompl\.judge"):
        gm_ompl.explain("random/free/3")
