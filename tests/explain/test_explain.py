"""Why there is no plan: what is said must be what the judge and the planner find."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.explain_text import lines
from gm_ompl.app.explaining import read_coordinates, read_placements
from gm_ompl.app.main import app
from gm_ompl.errors import InputError
from gm_ompl.explain.blame import Blame
from gm_ompl.explain.instants import Explainer
from gm_ompl.explain.lanes import whole_lane
from gm_ompl.explain.regions import whole_region
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load


def explainer_of(problem: Problem) -> Explainer:
    return Explainer(problem, Judge(problem, make_backend(problem)))


def given(problem: Problem, rows: tuple[int, ...], key: str) -> str:
    """Return an override that puts the fingers at ``rows`` at the start or the goal."""
    table = problem.fingers.placements
    places = [
        {"face": table.labels[int(table.face[row])], "cell": table.cell[row].tolist()}
        for row in rows
    ]
    return f"fingers.{key}={json.dumps(places)}"


@pytest.mark.parametrize("seed", range(12))
def test_placements_hold_where_a_plan_keeps_them(seed: int) -> None:
    """A set holds along the path exactly where the planner, starting with it, need not regrasp."""
    name = f"random/small/{seed}"
    problem = load(name).problem
    explainer = explainer_of(problem)
    count, size = problem.fingers.count, len(problem.fingers.placements)
    sets = [
        rows for rows in itertools.product(range(size), repeat=count) if len(set(rows)) == count
    ]
    rng = np.random.default_rng(seed)
    start = problem.fingers.start
    for k in rng.permutation(len(sets))[:4]:
        rows = sets[k]
        wanted = zip(start, problem.fingers.goal, rows, strict=True)
        if any(s not in (None, row) or g not in (None, row) for s, g, row in wanted):
            continue
        overrides = [given(problem, rows, "start"), given(problem, rows, "goal")]
        plan = gm_ompl.plan(gm_ompl.load(name, [*overrides, "cost.regrasp=1e6"]))
        line = whole_lane(explainer, rows)
        assert line.holds == (plan.status == "solved" and plan.regrasps == 0), rows
        assert line.holds == (line.forward is None) == (line.backward is None)
        assert line.holds == (not line.stretches)


def test_blame_names_something_exactly_where_geometry_fails() -> None:
    """Names come where the judge says "penetrates", and only there."""
    problem = load("paper/regrasp").problem
    judge, blame = Judge(problem, make_backend(problem)), Blame(problem)
    rng = np.random.default_rng(0)
    blocked = 0
    for _ in range(300):
        q = (float(rng.random()),)
        rows = tuple(int(row) for row in rng.integers(len(problem.fingers.placements), size=2))
        reasons = blame.configuration(q, rows)
        assert bool(reasons) != judge.placements_valid(q, rows)
        blocked += bool(reasons)
    assert 30 < blocked < 300


def test_blame_names_the_wall() -> None:
    """In the paper's regrasping example the wall behind keeps a fingertip off the back."""
    explanation = gm_ompl.explain("paper/regrasp", 0.2, [("+z", (5, 0)), ("-x", (3, 0))])
    assert [line.finding for line in explanation.instants] == [Finding.GEOMETRY] * 2
    assert explanation.instants[0].blocked_by == (
        "the fingertip of finger 1 penetrates wall_behind",
    )


def test_one_instant_shows_every_combination_of_modes() -> None:
    """All four combinations; the best of those that pass (5) is the judge's margin."""
    places = [("-x", (3, 1)), ("+z", (4, 3))]
    line = gm_ompl.explain("paper/slide", 0.5, places).instants[0]
    verdict = gm_ompl.judge("paper/slide", [0.5], [1.0], places)
    assert verdict.decision is not None
    assert line.finding is verdict.finding is Finding.HOLDS
    assert len(line.modes) == 4
    best = max(row.z for row in line.modes if row.z is not None)
    assert best == pytest.approx(verdict.decision.z, rel=1e-9)
    assert line.ratio == pytest.approx(verdict.decision.z / 0.5)


def test_the_limiting_disturbance_has_the_right_sign() -> None:
    """A box that rests on a floor without friction gives way to every horizontal force."""
    overrides = ["friction.environment=0", "fingers.count=1"]
    line = gm_ompl.explain(gm_ompl.load("paper/slide", overrides), 0.5, [("-x", (3, 3))])
    rest = line.instants[1]
    assert rest.z == 0.0
    assert rest.limit is not None
    # The finger on -x pushes along +x alone: what it cannot hold is a pull along +x.
    assert rest.limit in ("a force along the object's +x", "a force and a moment together")


def test_an_infeasible_scenario_is_explained() -> None:
    """The search's answer, counts that add up, and a remedy that a search confirms."""
    overrides = [
        "fingers.max_normal_force=3",
        "fingers.placements.grid=[2, 2]",
        "lattice.segments=6",
        "mechanics.z_min=2",
    ]
    scenario = gm_ompl.load("paper/slide", overrides)
    assert gm_ompl.plan(scenario).status == "infeasible"
    explanation = gm_ompl.explain(scenario, samples=50)
    assert explanation.verdict == explanation.search == "it is proven that no plan exists"
    for survey in explanation.surveys:
        assert survey.sampled and survey.judged == 50
        assert survey.holding + sum(survey.findings.values()) == survey.judged
        assert sum(row.sets for row in survey.faces) == survey.judged
    helping = [remedy.change for remedy in explanation.remedies if remedy.helps]
    assert helping
    for change in helping:
        again = gm_ompl.plan(gm_ompl.load("paper/slide", [*overrides, change]))
        assert again.status == "solved"
    json.dumps(explanation.to_dict(), allow_nan=False)
    assert any("random 50" in line for line in lines(explanation))


def test_what_would_let_placements_hold_is_verified() -> None:
    """Placements that miss z_min get the z_min with which they hold, and hold with it."""
    overrides = ["mechanics.z_min=2.5"]
    places = [("-x", (0, 6)), ("-x", (6, 1))]
    explanation = gm_ompl.explain(gm_ompl.load("paper/push", overrides), placements=places)
    assert explanation.placements is not None
    assert not explanation.placements.holds
    assert explanation.placements.forward is not None
    assert explanation.placements.forward.finding is Finding.UNSTABLE
    (change,) = [r.change for r in explanation.remedies if r.helps and "z_min" in r.change]
    again = gm_ompl.explain(gm_ompl.load("paper/push", [change]), placements=places)
    assert again.placements is not None
    assert again.placements.holds


def test_planar_placements_reach_the_goal_or_say_what_stops_them() -> None:
    """Opposite sides push the object anywhere; a finger alone on the front cannot."""
    problem = load("random/planar/0").problem
    explainer = explainer_of(problem)
    find = problem.fingers.placements.find
    pinch = (find("+x", (3, 6)), find("-x", (3, 4)))
    weak = (find("+x", (0, 2)), find("-y", (2, 3)))
    assert None not in pinch and None not in weak
    good = whole_region(explainer, pinch)  # type: ignore[arg-type]
    assert good.holds and good.forward is None
    assert good.nodes_from_start == good.nodes_to_goal == problem.lattice.size
    bad = whole_region(explainer, weak)  # type: ignore[arg-type]
    assert not bad.holds
    assert bad.forward is not None and bad.forward.finding is not Finding.HOLDS


@pytest.mark.parametrize(
    "text", ["", "-x", "-x:3", "-x:3.2,", "-x:3.2;+z:1.1", "-x:[3.2]", "-x:[3,2]+z:1.1"]
)
def test_bad_placements_are_refused(text: str) -> None:
    """Anything but FACE:CELL, separated by commas, is bad input with an example."""
    with pytest.raises(InputError, match="FACE:CELL"):
        read_placements(text)


def test_placements_and_coordinates_are_read() -> None:
    """Both ways to write a cell; yaw in degrees."""
    assert read_placements("-x:3.2,+z:[0, 1]") == [("-x", (3, 2)), ("+z", (0, 1))]
    assert read_coordinates("0.25") == [0.25]
    assert read_coordinates("1, 2, 90 deg") == [1.0, 2.0, pytest.approx(np.pi / 2)]
    with pytest.raises(InputError, match="--at"):
        read_coordinates("here")


def test_a_point_off_the_path_is_refused() -> None:
    """The message names the range."""
    with pytest.raises(InputError, match="from 0 to 1"):
        gm_ompl.explain("paper/slide", 1.5)


def test_the_command_prints_lines_or_one_object() -> None:
    """Exit code 0; with --json one object whose keys are those of the explanation."""
    arguments = ["explain", "paper/regrasp", "--placements", "+z:5.0,-x:[3,0]"]
    text = CliRunner().invoke(app, arguments)
    assert text.exit_code == 0
    assert "wall_behind" in text.stdout
    tree = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert tree["placements"]["forward"]["finding"] == "geometry"
    assert tree["placements"]["stretches"][0]["blocked_by"]


def test_the_command_refuses_bad_placements() -> None:
    """A face that does not exist and a wrong number of fingers are bad input, exit code 2."""
    for places in ("+w:0.0,+z:1.1", "+z:0.0", "+z:99.0,+z:1.1", "nonsense"):
        result = CliRunner().invoke(app, ["explain", "paper/slide", "--placements", places])
        assert result.exit_code == 2, places
