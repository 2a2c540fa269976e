"""Plans for all worlds within ranges."""

from __future__ import annotations

import pytest

import gm_ompl

RANGES = {
    "uncertainty.environment_friction": "10 %",
    "uncertainty.finger_friction": "10 %",
    "uncertainty.mass": "5 %",
    "uncertainty.centre_of_mass": "5 %",
}


SMALL = ["lattice.segments=4", "fingers.placements={grid: [3, 3], faces: [+y, -y]}"]


@pytest.fixture(scope="module")
def plans() -> tuple[gm_ompl.Plan, gm_ompl.Plan]:
    """The best plan of a tumble, and the best for all worlds; a finger is force-controlled."""
    nominal = gm_ompl.load("paper/tumble", SMALL)
    return gm_ompl.plan(nominal), gm_ompl.plan(nominal.with_(RANGES))


def test_a_robust_plan_is_proven_and_holds(plans: tuple[gm_ompl.Plan, gm_ompl.Plan]) -> None:
    """Optimal among plans for all worlds, dearer than the nominal one, and the reference agrees."""
    nominal, robust = plans
    assert nominal.cost is not None and robust.cost is not None
    assert nominal.least_z is not None and robust.least_z is not None
    assert robust.optimal and robust.cost >= nominal.cost
    assert robust.least_z < nominal.least_z
    # Commands are chosen anew along the way, each by its worst case.
    forces = {f for part in robust.segments for f in part.f_com if f is not None}
    assert len(forces) > 1
    assert gm_ompl.check(robust).holds


def test_the_check_knows_the_worst_case(plans: tuple[gm_ompl.Plan, gm_ompl.Plan]) -> None:
    """A nominal plan that claims to be one for all worlds states a z that the worst has not."""
    nominal, robust = plans
    first = nominal.steps[:1]
    claimed = nominal.model_copy(update={"scenario": robust.scenario, "steps": first})
    report = gm_ompl.check(claimed)
    assert {violation.topic for violation in report.violations} >= {"z"}


def test_samplers_plan_for_all_worlds() -> None:
    """What a randomised planner finds holds in the worst case."""
    scenario = gm_ompl.load("paper/slide").with_({**RANGES, "uncertainty.command": "5 %"})
    plan = gm_ompl.plan(scenario, planner="HybridRRTConnect", seed=1, time_limit=60.0)
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds
