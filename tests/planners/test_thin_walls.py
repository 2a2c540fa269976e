"""Obstacles thinner than the way between two midpoints: no planner goes through, no check lets one.

Each wall stands between two nodes, where neither a node nor a midpoint shows it.
"""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest

from gm_ompl import api
from gm_ompl.errors import PlanError
from gm_ompl.plain.search import SearchStatus, plain_search
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.scenario import Scenario

OPEN = """
format: gm-ompl-scenario/1
name: test/thin
object: {shape: {box: [2, 4, 2]}, mass: 1}
friction: {environment: 0.4, finger: 0.8}
fingers: {count: 2, radius: 0.2, max_normal_force: 12, placements: {grid: [3, 3], faces: all}}
environment: {floor: true}
motion:
  start: {position: [0, 0, 1]}
  path:
    - slide: {by: [10, 0, 0]}
lattice: {segments: 2}
mechanics: {z_min: 0.1}
cost: {samples_per_arc: 1}
"""

WALL = "environment.obstacles={wall: {box: {min: [3.52, -50, 0], max: [3.58, 50, 50]}}}"
"""In the way of the object: between the midpoint at x = 2.5 and the node at x = 5."""

POST = "environment.obstacles={post: {box: {min: [0.7, -50, 2.05], max: [0.75, 50, 50]}}}"
"""Over the object, in the way of fingertips on top of it alone."""

PLANAR = "motion={planar: {x: [0, 10], y: [-8, 8], yaw: [-180 deg, 180 deg]}, \
start: {position: [0, 0, 1]}, goal: {position: [10, 0, 1]}}"


def _scenario(tmp_path: Path, *overrides: str) -> Scenario:
    file = tmp_path / "thin.yaml"
    file.write_text(OPEN, encoding="utf-8")
    return api.load(file, overrides)


def _through(plan: Plan, scenario: Scenario) -> Plan:
    """Return an open scenario's plan as if it were one of ``scenario``."""
    draft = json.loads(json.dumps(plan.to_dict()))
    draft["scenario"] = scenario.resolved()
    return Plan.model_validate_json(json.dumps(draft))


@pytest.mark.parametrize("planner", ["astar", "dijkstra"])
def test_a_thin_wall_stops_the_object(tmp_path: Path, planner: str) -> None:
    """Without the wall there is a plan; with it there is proven to be none; reference agrees."""
    assert api.plan(_scenario(tmp_path), planner).status == "solved"
    walled = _scenario(tmp_path, WALL)
    assert api.plan(walled, planner).status == "infeasible"
    small = _scenario(tmp_path, WALL, "fingers.placements.grid=[1, 1]")
    assert plain_search(small.problem).status is SearchStatus.INFEASIBLE


@pytest.mark.parametrize("planner", ["HybridRRT", "RRTConnect"])
def test_no_sampling_planner_goes_through(tmp_path: Path, planner: str) -> None:
    """Continuous planners find a plan without the wall, and none with it."""
    assert api.plan(_scenario(tmp_path), planner, max_iterations=300).status == "solved"
    assert api.plan(_scenario(tmp_path, WALL), planner, max_iterations=300).status != "solved"


def test_in_the_plane_the_object_goes_round(tmp_path: Path) -> None:
    """A short thin wall across the straight way: the plan leaves the line, and holds."""
    wall = "environment.obstacles={wall: {box: {min: [3.6, -1, 0], max: [3.9, 1, 50]}}}"
    plain = ["lattice={steps: {x: 5, y: 4, yaw: 90 deg}}", PLANAR]
    plan = api.plan(_scenario(tmp_path, *plain))
    assert all(step.kind == "regrasp" or step.to[1] == 0.0 for step in plan.steps)
    walled = _scenario(tmp_path, wall, *plain)
    around = api.plan(walled)
    assert around.cost is not None and plan.cost is not None and around.cost > plan.cost
    assert api.check(around).holds
    assert not api.check(_through(plan, walled)).holds


def test_a_thin_post_stops_a_fingertip(tmp_path: Path) -> None:
    """Over the object's top passes nothing but the object: no finger ends where it would hit."""
    limited = ["fingers.placements.faces=[+z]", "lattice.segments=1"]
    free = api.plan(_scenario(tmp_path, *limited))
    assert free.status == "solved"
    walled = _scenario(tmp_path, POST, *limited)
    assert api.plan(walled).status == "infeasible"
    messages = [v.message for v in api.check(_through(free, walled)).violations]
    assert messages and all("fingertip" in m and "along" in m for m in messages)
    others = api.plan(_scenario(tmp_path, POST))
    assert others.status == "solved" and api.check(others).holds
    assert not {p.face for step in others.steps for p in step.placements} & {"+z"}


def test_check_refuses_a_plan_through_a_wall(tmp_path: Path) -> None:
    """Only the wall is blamed: all else about the plan is right."""
    plan = api.plan(_scenario(tmp_path))
    report = api.check(_through(plan, _scenario(tmp_path, WALL)))
    assert {v.topic for v in report.violations} == {"geometry"}
    assert any("the object penetrates" in v.message for v in report.violations)


def test_an_old_plan_is_refused_with_its_reason(tmp_path: Path) -> None:
    """A file in the format without arcs says so, and what to do."""
    old = copy.deepcopy(api.plan(_scenario(tmp_path)).to_dict())
    old["format"] = "gm-ompl-plan/1"
    for step in old["steps"]:
        step.pop("arc", None)
        step.pop("way", None)
    file = tmp_path / "old.json"
    file.write_text(json.dumps(old), encoding="utf-8")
    with pytest.raises(PlanError, match=r"gm-ompl-plan/1.*plan again"):
        Plan.load(file)
