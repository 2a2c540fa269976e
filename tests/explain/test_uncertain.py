"""No plan for all worlds: what is said of the ranges, and how much narrower they must be."""

from __future__ import annotations

import numpy as np
import pytest

import gm_ompl
from gm_ompl.diagnosis import remedies
from gm_ompl.diagnosis.knobs import TrialOutcome, least
from gm_ompl.diagnosis.narrower import narrower
from gm_ompl.limits import Limits
from gm_ompl.planners.planner import Status
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario

RANGES = "{environment_friction: 10 %, finger_friction: 10 %, mass: 5 %, centre_of_mass: 5 %}"


@pytest.fixture(scope="module")
def hopeless() -> Scenario:
    """A push that z of at least 1.75 allows as modelled, but not in all worlds."""
    changes = [
        "fingers.placements={grid: [2, 4], faces: [-x]}", "lattice.segments=1",
        "mechanics.z_min=1.75", f"uncertainty={RANGES}",
    ]  # fmt: skip
    return gm_ompl.load("paper/push", changes)


def test_it_is_said_whether_the_ranges_are_to_blame(hopeless: Scenario) -> None:
    """Proven infeasible with them; without them there is a plan, and explain says so."""
    assert gm_ompl.plan(hopeless).status == "infeasible"
    assert gm_ompl.plan(hopeless.with_("uncertainty={}")).status == "solved"
    told = remedies.certain(hopeless.problem, 60.0)
    assert told.status == "solved" and "the ranges in uncertainty that leave none" in told.sentence


def test_ranges_are_narrowed_until_there_is_a_plan(hopeless: Scenario) -> None:
    """No range alone is to blame; what is named for all together helps, 2 % more does not."""

    def holds(changed: Problem, seconds: float) -> TrialOutcome:
        solved = remedies.search(changed, seconds) is Status.SOLVED
        return TrialOutcome.YES if solved else TrialOutcome.NO

    together, *alone = (
        least(knob, holds, remedies.PLAN, TrialOutcome.NO, Limits(60.0))
        for knob in narrower(hopeless.problem)
    )
    assert together.helps and not any(remedy.helps for remedy in alone)
    assert "none on the lattice with 0." in together.evidence
    assert gm_ompl.plan(hopeless.with_(together.change)).status == "solved"
    wider = hopeless.with_(together.change).problem.uncertainty.scaled(1.03)
    assert wider.mass < hopeless.problem.uncertainty.mass
    (knob, *_) = narrower(hopeless.problem)
    factor = wider.mass / hopeless.problem.uncertainty.mass
    missed = hopeless.with_(f"uncertainty={knob.shown(np.array([factor]))}")
    assert gm_ompl.plan(missed).status == "infeasible"


@pytest.mark.parametrize(
    "ranges",
    [
        RANGES,
        "{environment_friction: {wall_behind: 0.1}, tilt: 2 deg, command: 3 %}",
        "{finger_friction: [0.1, 0], centre_of_mass: [0.1, 0, 0.2], position: 0.001}",
    ],
)
def test_ranges_are_written_as_a_scenario_has_them(ranges: str) -> None:
    """What is named for a factor is, read again, that factor of all ranges."""
    scenario = gm_ompl.load("paper/regrasp", [f"uncertainty={ranges}"])
    (knob, *_) = narrower(scenario.problem)
    again = scenario.with_(f"uncertainty={knob.shown(np.array([0.37]))}").problem.uncertainty
    wanted = scenario.problem.uncertainty.scaled(0.37)
    for name, value in vars(wanted).items():
        assert getattr(again, name) == pytest.approx(value, rel=1e-8), name
    assert knob.shown(np.zeros(1)) == "{}"
