"""Plans of the plain search hold: tumbles, regrasps, obstacles, two coordinates."""

from __future__ import annotations

from typing import Any

import pytest

from gm_ompl.checking import check
from gm_ompl.plain.search import plain_search
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.scenario import Scenario
from tests.airborne import airborne


def _scenario(**changes: Any) -> dict[str, Any]:
    base: dict[str, Any] = {
        "format": "gm-ompl-scenario/1",
        "name": "test/search",
        "object": {"shape": {"box": [5, 5, 10]}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "gravity": 9.8,
        "fingers": {
            "count": 2,
            "radius": 1,
            "max_normal_force": 10,
            "placements": {"grid": [1, 2], "faces": ["+x", "-x", "+y", "-y", "+z"]},
        },
        "motion": {
            "start": {"position": [0, 0, 5]},
            "path": [{"tumble": {"towards": "+x", "angle": "90 deg"}}],
        },
        "lattice": {"segments": 3},
        "mechanics": {"cone_edges": 4, "z_min": 0.05},
        "cost": {"samples_per_arc": 1},
    }
    return {**base, **changes}


SCENARIOS = {
    "tumble": _scenario(),
    "tumble past walls": _scenario(
        environment={
            "obstacles": {
                "behind": {"box": {"min": [-50, -50, 0], "max": [-3, 50, 50]}},
                "beside": {"box": {"min": [-50, 3, 0], "max": [50, 50, 50]}},
            }
        },
        fingers={
            "count": 2,
            "radius": 1,
            "max_normal_force": 20,
            "placements": {"grid": [2, 2], "faces": ["+x", "-x", "-y", "+z"]},
        },
    ),
    "slide, then tumble, unequal fingers": _scenario(
        motion={
            "start": {"position": [0, 0, 5]},
            "path": [
                {"slide": {"by": [2, 0, 0]}},
                {"tumble": {"towards": "+x", "angle": "90 deg"}},
            ],
        },
        lattice={"segments": [1, 2]},
        fingers={
            "count": 2,
            "radius": [1, 0.5],
            "max_normal_force": [10, 15],
            "placements": {"grid": [1, 2], "faces": ["+x", "-x", "+y", "-y"]},
        },
    ),
    "planar": _scenario(
        motion={
            "planar": {"x": [0, 2], "y": [0, 1], "yaw": ["0 deg", "10 deg"]},
            "start": {"position": [0, 0, 5]},
            "goal": {"position": [2, 1, 5], "yaw": "0 deg"},
        },
        lattice={"steps": {"x": 1, "y": 1, "yaw": "10 deg"}},
    ),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_plans_of_the_plain_search_hold(name: str) -> None:
    """A plan found by the plain search, by other code than the check's, has no violation."""
    scenario = Scenario.from_resolved(SCENARIOS[name])
    found = plain_search(scenario.problem)
    plan = _assembled(scenario, found)
    report = check(plan)
    assert report.holds, report.table()
    assert plan.steps, "the scenario is meant to be solvable"


def _assembled(scenario: Scenario, found: Any) -> Plan:
    return assemble(
        scenario.problem,
        scenario.resolved(),
        airborne(scenario.problem, found.moves),
        status="solved",
        planner="plain search",
        statistics={"time_s": 0.0, "expanded": 0, "mode_decisions": 0, "history": []},
        optimal=True,
        lower_bound=found.cost,
    )
