"""What whole plans tolerate: steps against the plan, all ranges together, and what is shown."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.main import app
from gm_ompl.geometry.solids import Body, box
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.tolerance.forces import held
from gm_ompl.tolerance.measure import Measure, common_factor, measured, usual
from gm_ompl.tolerance.report import IntervalEnd, Tolerance
from gm_ompl.tolerance.rims import Rims
from gm_ompl.tolerance.sites import sites
from gm_ompl.uncertainty.worlds import NOMINAL, draw
from tests.check.conftest import SCENARIO, Author
from tests.tolerances import holds_in


@pytest.fixture(scope="module")
def plan() -> Plan:
    """One arc of a box that is pushed from behind, the second finger on top."""
    author = Author(Scenario.from_resolved(SCENARIO))
    rows = (author.row("+z", 2, 2), author.row("-x", 2, 2))
    return author.plan([author.slide(0.0, 0.25, rows)])


@pytest.fixture(scope="module")
def found(plan: Plan) -> Tolerance:
    """What it tolerates."""
    return gm_ompl.tolerate(plan)


def test_the_plan_tolerates_what_all_its_steps_do(found: Tolerance) -> None:
    """Each end of the plan's intervals is the nearest of its steps'."""
    assert found.holds and found.together is not None
    for k, interval in enumerate(found.intervals):
        assert interval.low.x == max(step.intervals[k].low.x for step in found.steps) <= 0.0
        assert interval.high.x == min(step.intervals[k].high.x for step in found.steps) >= 0.0
    assert any(interval.low.ending is IntervalEnd.FAILS for interval in found.intervals)


def test_worlds_of_the_widened_ranges_hold(plan: Plan, found: Tolerance) -> None:
    """Drawn worlds of the ranges times the factor hold; the one named just beyond fails."""
    problem, together = problem_of(plan), found.together
    assert together is not None and together.world is not None
    places, rng = list(sites(plan, problem)), np.random.default_rng(0)
    for _ in range(20):
        world = draw(usual(problem), problem.fingers.count, rng, together.x)
        assert all(holds_in(site, world.of(site.fingers)) is not False for site in places[:1])
    ending = [site for site in places if site.step == together.step]
    assert any(holds_in(site, together.world) is False for site in ending)


def test_the_factor_alone_is_the_same(plan: Plan, found: Tolerance) -> None:
    """What tuning asks for is what the report says."""
    assert found.together is not None
    assert common_factor(plan, problem_of(plan)) == pytest.approx(found.together.x, rel=0.02)


def test_wider_ranges_have_a_smaller_factor(plan: Plan, found: Tolerance) -> None:
    """Ranges twice as wide may be widened half as much."""
    problem = problem_of(plan)
    ranges = usual(problem).scaled(2.0)
    assert found.together is not None
    factor = common_factor(plan, replace(problem, uncertainty=ranges))
    assert factor == pytest.approx(found.together.x / 2.0, rel=0.03)


def test_a_plan_that_does_not_hold_tolerates_nothing(plan: Plan) -> None:
    """With z_min above the plan's z every interval is empty, and the report says so."""
    refuted = gm_ompl.tolerate(plan, "mechanics.z_min=1000")
    assert not refuted.holds
    assert all(interval.low.x == interval.high.x == 0.0 for interval in refuted.intervals)
    assert "does NOT hold" in refuted.table()


def test_a_plan_without_steps_is_bad_input(plan: Plan) -> None:
    """There is nothing to hold then."""
    with pytest.raises(gm_ompl.InputError, match="no steps"):
        measured(plan.model_copy(update={"steps": ()}), problem_of(plan))


def test_shifts_end_at_the_rim() -> None:
    """On a 2 x 4 x 6 box a point of the top face has the way to each of its four edges."""
    body = Body((box((-1.0, -2.0, -3.0), (1.0, 2.0, 3.0)),))
    author = Author(Scenario.from_resolved(SCENARIO))
    rows = (author.row("+z", 2, 2), author.row("-x", 2, 2))
    record = author.plan([author.slide(0.0, 0.25, rows)]).steps[0].placements[0]
    top = record.model_copy(update={"point": (0.25, -0.5, 3.0), "normal": (0.0, 0.0, -1.0)})
    room = Rims(body).room(top)
    assert sorted(room.ravel().tolist()) == pytest.approx([0.75, 1.25, 1.5, 2.5])


def test_sites_are_the_plans_segments(plan: Plan) -> None:
    """There is one per segment, at the plan's own margin."""
    places = list(sites(plan, problem_of(plan)))
    stated = [part.z for part in plan.segments]
    z = [(h := held(site, NOMINAL, exactly=True)).slack * h.model.scale + site.z_min
         for site in places]  # fmt: skip
    assert z == pytest.approx(stated, rel=1e-5)


def test_the_command_says_it(plan: Plan, found: Tolerance, tmp_path: Path) -> None:
    """``gm-ompl tolerate --json`` prints one object; for a plan too weak it exits with 5."""
    path = tmp_path / "plan.json"
    plan.save(path)
    run = CliRunner()
    shown = run.invoke(app, ["tolerate", str(path), "--json"])
    assert shown.exit_code == 0
    assert json.loads(shown.stdout) == json.loads(json.dumps(found.to_dict()))
    weak = run.invoke(app, ["tolerate", str(path), "--set", "mechanics.z_min=1000"])
    assert weak.exit_code == 5 and "does NOT hold" in weak.stdout
    wrong = run.invoke(app, ["tolerate", str(path), "--set", "uncertainty.masss=5 %"])
    assert wrong.exit_code == 2 and "mass" in wrong.output


def test_measuring_needs_no_single_intervals(plan: Plan) -> None:
    """Where only the factor is wanted, no quantity is looked at."""
    problem = problem_of(plan)
    steps = Measure(problem, usual(problem), alone=False).steps(plan)
    assert all(step.intervals == () for step in steps)
