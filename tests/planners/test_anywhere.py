"""Continuous placements: the bound holds against any grid, the plan passes its check."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import gm_ompl
from gm_ompl.errors import InputError, ScenarioError
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario

MARGIN = 0.5


def loosened(name: str, gap: str = "1%", more: dict[str, Any] | None = None) -> Scenario:
    """Return a scenario with continuous placements."""
    said = {"margin": MARGIN, "gap": gap}
    return load(name, {"fingers.placements.continuous": said, **(more or {})})


@pytest.mark.parametrize(
    ("name", "gap"), [("paper/slide", 0.001), ("paper/push", 0.005), ("paper/tumble", 0.03)]
)
def test_the_paper_s_problems(name: str, gap: float) -> None:
    """The gap is reached; no grid's optimum beats the bound, and none is cheaper by more."""
    scenario = loosened(name, f"{100 * gap:g}%")
    plan = gm_ompl.plan(scenario)
    assert plan.status == "solved"
    assert plan.cost is not None
    assert plan.lower_bound is not None
    assert plan.lower_bound <= plan.cost <= plan.lower_bound * (1.0 + gap + 1e-9)
    assert not plan.optimal
    report = gm_ompl.check(plan)
    assert report.holds, report.violations
    for grid in (7, 15):
        changes = {"fingers.placements.grid": [grid, grid], "fingers.placements.margin": MARGIN}
        other = gm_ompl.plan(load(name, changes))
        assert other.optimal
        assert other.cost is not None
        assert other.cost >= plan.lower_bound


def test_given_placements_and_regrasps() -> None:
    """Fingers start where the scenario says; what is gained is gained between the grid's points."""
    fewer = {"lattice.segments": 15}
    grid = gm_ompl.plan(load("paper/regrasp", fewer))
    assert grid.cost is not None
    start = [{"face": p.face, "cell": list(p.cell or ())} for p in grid.steps[0].placements]
    said = {"fingers.placements.continuous": {"margin": 0.3, "gap": "5%"}, "fingers.start": start}
    plan = gm_ompl.plan(load("paper/regrasp", {**fewer, **said}), max_iterations=200)
    assert plan.cost is not None
    assert plan.cost < grid.cost
    assert plan.regrasps
    first = plan.steps[0].placements
    assert [record.spot for record in first] == [p.spot for p in grid.steps[0].placements]
    assert gm_ompl.check(plan).holds


def test_hands_that_are_given_whole() -> None:
    """Where every finger starts at a given placement and no regrasp pays, nothing is halved."""
    start = [{"face": "-x", "cell": [3, 3]}, {"face": "+z", "cell": [3, 3]}]
    plan = gm_ompl.plan(loosened("paper/slide", "0.1%", {"fingers.start": start}))
    grid = gm_ompl.plan(load("paper/slide", {"fingers.start": start}))
    assert plan.cost == pytest.approx(grid.cost, rel=1e-9)
    assert plan.lower_bound is not None
    assert grid.cost is not None
    assert plan.lower_bound <= grid.cost * (1.0 + 1e-9)


def test_a_spent_budget_leaves_plan_and_bound() -> None:
    """After few products the best plan and a bound are known, and more products prove more."""
    before = 0.0
    scenario = loosened("paper/tumble", "0.1%", {"lattice.segments": 9})
    for most in (1, 60, 200):
        plan = gm_ompl.plan(scenario, max_iterations=most)
        assert plan.cost is not None
        assert plan.lower_bound is not None
        assert before <= plan.lower_bound <= plan.cost
        before = plan.lower_bound
        assert gm_ompl.check(plan).holds
    assert before > 0.0


def test_no_plan_anywhere() -> None:
    """Fingers too weak to move the object at all: it is proven for every placement."""
    more = {"fingers.max_normal_force": 0.5, "lattice.segments": 3}
    plan = gm_ompl.plan(loosened("paper/tumble", more=more), max_iterations=2000)
    assert plan.cost is None
    assert plan.lower_bound is None or plan.lower_bound > 100.0


def test_plans_keep_their_points(tmp_path: Path) -> None:
    """A plan file holds points on no grid; who shows the plan finds them in the hand's table."""
    plan = gm_ompl.plan(loosened("paper/slide"))
    plan.save(tmp_path / "plan.json")
    again = Plan.load(tmp_path / "plan.json")
    assert again == plan
    places = [place for place in again.steps[0].placements if place.cell is None]
    assert places
    table = problem_of(again).fingers.placements
    for place in places:
        row = place.row(table)
        assert row is not None
        assert table.points[row].tolist() == list(place.point)
        assert place.words.startswith(f"{place.face} (")
    assert table.find(places[0].face, (-1, -1)) is None


@pytest.mark.parametrize("what", ["rim", "off the face", "no continuous placements"])
def test_points_that_are_not_offered(what: str) -> None:
    """The check refuses a point near the rim or off its face, or that nothing asks for."""
    plan = gm_ompl.plan(loosened("paper/slide", more={"lattice.segments": 3}))
    document = plan.to_dict()
    if what == "no continuous placements":
        document["scenario"]["fingers"]["placements"].pop("continuous")
    for step in document["steps"]:
        for place in step["placements"]:
            place["cell"] = None
            if what == "rim" and place["face"] == "+z":
                place["point"][1] = 4.9
            if what == "off the face" and place["face"] == "+z":
                place["point"][2] += 1e-3
    report = gm_ompl.check(Plan.model_validate(document, strict=False))
    assert not report.holds
    assert any("no such point" in str(violation) for violation in report.violations)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"fingers.placements.margin": 0.1}, "fingers.placements.margin"),
        ({"mechanics.z_min": 0}, "mechanics.z_min"),
        ({"fingers.placements.continuous.gap": "nearly"}, "continuous.gap"),
        ({"fingers.placements.continuous.gap": 0}, "continuous.gap"),
        ({"fingers.placements.continuous.margin": 3}, "continuous.margin"),
        ({"fingers.placements.continuous.gasp": 3}, "continuous.gasp"),
        ({"uncertainty.finger_friction": "10%"}, "placements.continuous"),
        ({"mechanics.backend": "highs"}, "placements.continuous"),
    ],
)
def test_mistakes_are_named(changes: dict[str, Any], key: str) -> None:
    """Each mistake is refused with its key."""
    with pytest.raises(ScenarioError, match=key):
        loosened("paper/slide", more=changes)


def test_planners_that_know_the_grid_alone() -> None:
    """They say so, name those that can, and astar that it can on paths alone."""
    for name in ("planar/turn", "free/stairs"):
        scenario = load(name, {"fingers.placements.continuous": {"margin": 0.001}})
        with pytest.raises(InputError, match=r"anywhere along paths alone.* HybridRRTConnect"):
            gm_ompl.plan(scenario)
    scenario = loosened("paper/slide")
    for planner in ("dijkstra", "RRT"):
        with pytest.raises(InputError, match=r"on the grid alone.* plan with astar, HybridRRT, "):
            gm_ompl.plan(scenario, planner)
    with pytest.raises(InputError, match="heuristic lanes"):
        gm_ompl.plan(scenario, parameters={"heuristic": "none"})


def test_a_gap_is_a_share() -> None:
    """0.1% and 0.001 are the same, and a resolved scenario loads again."""
    said = {"margin": MARGIN, "gap": 0.001}
    plain = load("paper/slide", {"fingers.placements.continuous": said}).problem.fingers
    assert loosened("paper/slide", "0.1%").problem.fingers.anywhere == plain.anywhere
    again = Scenario.from_resolved(loosened("paper/slide").resolved())
    assert again.problem.fingers.anywhere == loosened("paper/slide").problem.fingers.anywhere
    where = again.problem.fingers.anywhere
    assert where is not None
    assert math.isclose(where.gap, 0.01)
