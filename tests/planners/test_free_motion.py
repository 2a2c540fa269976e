"""Free motion: start and goal in SE(3), planned exactly on the contact lattice."""

from __future__ import annotations

import math
from typing import Any, Never

import pytest

import gm_ompl
from gm_ompl.errors import ScenarioWarning
from gm_ompl.plain.search import plain_search
from gm_ompl.planners import lane_parts
from gm_ompl.planners.planner import Planner, PlannerSpecs, SearchResult, Status
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.freed import free_path, free_plane, one_piece, small_plane
from tests.verify.count_searches import AGREE, cost_of, gap, solve

ENDS = ("cost.samples_per_arc=2", "cost.samples_at=ends")
AGREED = (
    ("random/free/2", ("lattice.depth=3", "fingers.placements.grid=[1, 2]")),
    ("random/free-clutter/2", ("lattice.depth=2",)),
    ("random/free/2", ("lattice.depth=3", "fingers.placements.grid=[1, 2]", *ENDS)),
)
"""Made so small that the plain search may walk their lattices."""


@pytest.mark.parametrize(("name", "changes"), AGREED)
def test_the_plain_search_finds_the_same_optimum(name: str, changes: tuple[str, ...]) -> None:
    """Three searches, two lattices built by different code, one cost."""
    problem = load(name, changes).problem
    optimum = plain_search(problem).cost
    assert max(gap(solve(problem, planner), optimum) for planner in ("astar", "dijkstra")) <= AGREE


def found(problem: Problem) -> SearchResult:
    """What astar finds."""
    return solve(problem, "astar")


def test_infeasible_is_proven() -> None:
    """Where all of the lattice was seen, and no way of holding the object leads to the goal."""
    for seed in (0, 1):
        assert found(load(f"random/free/{seed}").problem).status is Status.INFEASIBLE


@pytest.mark.parametrize("planner", ["astar", "HybridRRT", "HybridRRTConnect"])
@pytest.mark.parametrize("name", ["tasks/bookshelf", "tasks/placedown"])
def test_where_nothing_fits_nothing_is_searched(name: str, planner: str) -> None:
    """All fingertips are to be on a face that lies on the floor, at the start or at the goal."""
    result = solve(load(name, ["fingers.placements.faces=[-z]"]).problem, planner)
    assert result.status is Status.INFEASIBLE
    assert result.statistics["expanded"] == 0


def test_plans_hold() -> None:
    """What is planned on the planner's lattice holds on the reference's, arc by arc."""
    for name in ("random/free/2", "random/free-clutter/3"):
        plan = gm_ompl.plan(name)
        assert plan.optimal
        report = gm_ompl.check(plan)
        assert report.holds, report.table()


def optimum(tree: dict[str, Any]) -> float:
    """The optimal cost, +inf where there is no plan."""
    return cost_of(found(Scenario.from_resolved(tree).problem))


def test_a_start_in_the_goal_costs_nothing() -> None:
    """The plan is empty, its cost 0, also where no arc was looked at."""
    tree: dict[str, Any] = load("random/free/3").resolved()
    here = tree["motion"]["start"]
    tree["motion"]["goal"] = {"position": here["position"], "yaw": "0 deg"}
    plan = gm_ompl.plan(Scenario.from_resolved(tree))
    assert plan.optimal and plan.cost == 0.0
    assert gm_ompl.check(plan).holds


PATHS = (0, 5, 10, 11, 12, 13)
"""Seeds of ``random/small`` with one slide or one tumble; one of them has no plan."""


@pytest.mark.parametrize("seed", PATHS)
def test_a_lattice_of_one_way_is_that_path(seed: int) -> None:
    """A region and axes that leave one path give the path scenario's optimum."""
    path = one_piece(seed)
    assert path is not None
    assert optimum(free_path(path)) == pytest.approx(optimum(path), rel=1e-6)


@pytest.mark.parametrize("seed", [0, 2, 5, 8])
def test_a_lattice_of_the_plane_is_planar_motion(seed: int) -> None:
    """On a bare floor, axes and a region that leave the plane give the planar optimum."""
    plane = small_plane(seed)
    assert plane is not None and not plane["environment"]["obstacles"]
    assert optimum(free_plane(plane)) == pytest.approx(optimum(plane), rel=1e-6)


def test_a_planner_that_needs_coordinates_is_refused() -> None:
    """One of your own, unless its specs say otherwise, is told so before anything is searched."""

    class Own(Planner):
        """Plans along paths."""

        name = "Own"
        specs = PlannerSpecs(optimal=False, randomised=False)

        def solve(self, *_: object) -> Never:
            """Is not reached."""
            raise AssertionError

    with pytest.raises(gm_ompl.InputError, match=r"Own plans along paths.*specs\.free.*astar"):
        gm_ompl.plan("free/around", Own())


def test_walls_only_add_to_planar_motion() -> None:
    """With walls the contact lattice has all arcs of the planar one, and costs at most as much."""
    plane = small_plane(1)
    assert plane is not None and plane["environment"]["obstacles"]
    cost, free = optimum(plane), free_plane(plane)
    free["lattice"]["depth"] = 4  # arcs of the planar plan
    assert optimum(free) <= cost * (1.0 + 1e-6) < math.inf


FREE_TURNS = (
    ("{position: [2.5, 0, 1], rotation: {axis: [0, 1, 0], angle: 30 deg}}", 0.0),
    ("{position: [2.75, 0, 1], rotation: {axis: [0, 1, 0], angle: 30 deg}}", 0.2509090532906096),
)


@pytest.mark.parametrize(("goal", "cost"), FREE_TURNS)
@pytest.mark.parametrize("most", [lane_parts.FEW_SETS, 0])
def test_what_costs_nothing_is_still_done(
    goal: str, cost: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A card that is turned about its pinch: fingertips stay where they are, and it is turned.

    So it is by lanes of placements and of cells.
    """
    monkeypatch.setattr(lane_parts, "FEW_SETS", most)
    start = "motion.start={position: [2.5, 0, 1]}"
    changes = (start, f"motion.goal={goal}", "fingers.placements.grid=[3, 3]")
    scenario = load("tasks/pick-card-soft", changes)
    with pytest.warns(ScenarioWarning, match="touches nothing"):
        plan = gm_ompl.plan(scenario)
    assert plan.optimal and plan.cost == pytest.approx(cost, abs=1e-9)
    report = gm_ompl.check(plan)
    assert report.holds, report.table()
