"""z_strong along whole plans: values, words, JSON and the figure."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.main import app
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.scenario import Scenario
from tests.check.conftest import SCENARIO, Author


@pytest.fixture(scope="module")
def plan() -> Plan:
    """One arc of a box that is pushed from behind, the second finger on top."""
    author = Author(Scenario.from_resolved(SCENARIO))
    rows = (author.row("+z", 2, 2), author.row("-x", 2, 2))
    return author.plan([author.slide(0.0, 0.25, rows)])


def test_both_margins_of_a_plan(plan: Plan) -> None:
    """z is the plan's own, z_strong at most that; what gives way is told where it is less."""
    found = gm_ompl.strong(plan)
    segments = [
        segment for step in plan.steps if step.kind == "displacement" for segment in step.segments
    ]
    assert len(found.sites) == len(segments)
    for site, segment in zip(found.sites, segments, strict=True):
        assert site.z == pytest.approx(segment.z, rel=1e-6)
        assert 0.0 <= site.z_strong <= site.z
        assert bool(site.gives_way) == bool(site.wrench.any()) == (site.z_strong < site.z)
    assert found.least.z_strong == min(site.z_strong for site in found.sites)
    assert found.table().count("\n") == len(plan.steps)


def test_a_plan_without_steps_is_refused(plan: Plan) -> None:
    """There is nothing to hold."""
    with pytest.raises(gm_ompl.InputError, match="no steps"):
        gm_ompl.strong(plan.model_copy(update={"steps": (), "status": "infeasible"}))


def test_from_the_command_line(plan: Plan, tmp_path: Path) -> None:
    """``gm-ompl strong`` prints a table or one object; ``plot --show strong`` draws it."""
    run, path = CliRunner(), tmp_path / "plan.json"
    plan.save(path)
    shown = run.invoke(app, ["strong", str(path)])
    assert shown.exit_code == 0 and "z_strong" in shown.stdout
    told = run.invoke(app, ["strong", str(path), "--json"])
    assert json.loads(told.stdout) == gm_ompl.strong(plan).to_dict()
    picture = tmp_path / "strong.svg"
    drawn = run.invoke(app, ["plot", str(path), "--show", "strong", "-o", str(picture)])
    assert drawn.exit_code == 0 and b"z_strong" in picture.read_bytes()
    missing = run.invoke(app, ["strong", str(tmp_path / "none.json")])
    assert missing.exit_code == 2
