"""Why there is no plan: what is said must be what the judge and the planner find."""

from __future__ import annotations

import dataclasses
import importlib
import itertools
import json
import re
import shlex
from collections.abc import Callable

import numpy as np
import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.explaining import lines, read_coordinates, read_placements
from gm_ompl.app.main import app
from gm_ompl.contact.environment import contact_state, environment_contacts
from gm_ompl.diagnosis import remedies
from gm_ompl.diagnosis.instants import Blame, Explainer, contact_lines
from gm_ompl.diagnosis.knobs import TrialOutcome, knobs, least
from gm_ompl.diagnosis.regions import whole_lane, whole_region
from gm_ompl.diagnosis.remedies import PLAN
from gm_ompl.diagnosis.values import Explanation, Remedy
from gm_ompl.errors import InputError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.verdict import Finding
from gm_ompl.limits import Limits
from gm_ompl.planners.planner import SearchResult, Status
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario
from tests.planners.test_equilibrium_alone import card


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
        reasons = blame.configuration(problem.motion.pose(q), rows)
        assert bool(reasons) != judge.placements_valid(problem.motion.pose(q), rows)
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


INFEASIBLE = [
    "fingers.max_normal_force=3",
    "fingers.placements={grid: [2, 2], faces: [-x, +z]}",
    "lattice.segments=2",
    "mechanics.z_min=2",
]
"""Of paper/slide: two weak fingers and much to resist."""


@pytest.fixture(scope="module")
def infeasible() -> Explanation:
    return gm_ompl.explain(gm_ompl.load("paper/slide", INFEASIBLE), samples=10)


def test_an_infeasible_scenario_is_explained(infeasible: Explanation) -> None:
    """The search's answer, counts that add up, and no more proven than the lattice allows."""
    assert gm_ompl.plan(gm_ompl.load("paper/slide", INFEASIBLE)).status == "infeasible"
    assert infeasible.verdict == infeasible.search
    assert infeasible.verdict == "it is proven that no plan exists on the scenario's lattice"
    for survey in infeasible.surveys:
        assert 1 <= survey.judged <= 10
        assert survey.holding + sum(survey.findings.values()) == survey.judged
        assert sum(row.sets for row in survey.faces) == survey.judged
    assert [attempt.kind for attempt in infeasible.attempts] == ["sampler", "finer lattice"]
    json.dumps(infeasible.to_dict(), allow_nan=False)
    assert infeasible.surveys[0].sampled
    assert any("a random" in line for line in lines(infeasible))


def test_what_helps_is_planned_with_the_named_value(infeasible: Explanation) -> None:
    """Each change named as helping has a plan, by the planner; f_max and z_min are among them."""
    helping = {r.change.split("=")[0]: r.change for r in infeasible.remedies if r.helps}
    assert {"fingers.max_normal_force", "mechanics.z_min"} <= set(helping)
    for change in helping.values():
        again = gm_ompl.plan(gm_ompl.load("paper/slide", [*INFEASIBLE, change]))
        assert again.status == "solved", change


def test_what_is_said_not_to_help_is_proven_infeasible(infeasible: Explanation) -> None:
    """The value next to the one that helps, named as proven in vain, has no plan."""
    proven = 0
    for remedy in infeasible.remedies:
        found = re.search(r"none on the lattice with (.*?)[,)]", remedy.evidence)
        if remedy.helps and found:
            change = f"{remedy.change.split('=')[0]}={found[1]}"
            again = gm_ompl.plan(gm_ompl.load("paper/slide", [*INFEASIBLE, change]))
            assert again.status == "infeasible", change
            proven += 1
    assert proven >= 2


def pushed_tee() -> Scenario:
    """Return a T that one finger pushes in the plane; its lattice is too coarse for that."""
    bar = {"box": {"min": [-2, 0, 0], "max": [2, 1, 1]}}
    stem = {"box": {"min": [-0.5, -3, 0], "max": [0.5, 0, 1]}}
    tree = {
        "format": "gm-ompl-scenario/1",
        "name": "test/tee",
        "object": {"shape": {"pieces": [bar, stem]}, "mass": 0.1},
        "friction": {"environment": 0.5, "finger": 0.5},
        "fingers": {
            "count": 1, "radius": 0.2, "max_normal_force": 5, "placements": {"grid": [5, 1]},
        },
        "motion": {
            "planar": {"x": [-4, 4], "y": [-4, 4], "yaw": ["-180 deg", "180 deg"]},
            "start": {"position": [0, 0, 0.5]},
            "goal": {"position": [2, 1, 0.5], "yaw": "90 deg"},
        },
        "lattice": {"steps": {"x": 1, "y": 1, "yaw": "30 deg"}},
        "mechanics": {"z_min": 0.01, "patch_points": 2},
        "cost": {"samples_per_arc": 1},
    }  # fmt: skip
    return Scenario.from_resolved(tree)


def test_a_sampler_is_not_bound_to_the_lattice(monkeypatch: pytest.MonkeyPatch) -> None:
    """A T in the plane whose lattice has no plan: a sampler's plan is found and said."""
    monkeypatch.setattr(remedies, "for_scenario", lambda *_, **__: ())
    explaining = importlib.import_module(
        "gm_ompl.diagnosis.explain"
    )  # gm_ompl.explain is a function
    monkeypatch.setattr(explaining, "finer", lambda *_: None)
    scenario = pushed_tee()
    assert gm_ompl.plan(scenario).status == "infeasible"
    found = gm_ompl.plan(scenario, "HybridRRTConnect", max_iterations=2000)
    assert found.status == "solved" and gm_ompl.check(found).holds
    explanation = gm_ompl.explain(scenario, samples=1)
    assert explanation.verdict.endswith("on the scenario's lattice, but there is one elsewhere")
    kinds = {attempt.kind: attempt for attempt in explanation.attempts}
    assert "not on the lattice: plan with --planner HybridRRTConnect" in kinds["sampler"].sentence


def test_a_finer_lattice_is_twice_as_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the attempt names as a change loads, and has twice the nodes along each axis."""
    monkeypatch.setattr(remedies, "search", lambda *_: Status.SOLVED)
    for name, factor in (("paper/slide", 2), ("planar/turn", 8)):
        before = load(name)
        attempt = remedies.finer(before, 1.0)
        assert attempt is not None and attempt.change is not None
        typed = shlex.quote(attempt.change)
        assert attempt.sentence == f"a lattice twice as fine has a plan: --set {typed}"
        after = load(name, [attempt.change]).problem.lattice
        old = before.problem.lattice
        for few, many, period in zip(old.axes, after.axes, old.periods, strict=True):
            assert len(many) == 2 * len(few) - (period is None)
        assert after.size > 0.8 * factor * old.size


def test_without_a_possible_set_nothing_more_is_tried() -> None:
    """All tips under the object penetrate the floor: no lattice, force or friction helps."""
    scenario = gm_ompl.load("paper/slide", ["fingers.placements.faces=[-z]"])
    explanation = gm_ompl.explain(scenario)
    assert explanation.verdict.endswith(
        "no set of placements is geometrically possible at the start"
    )
    (attempt,) = explanation.attempts
    assert attempt.status == "infeasible" and "no lattice" in attempt.sentence
    assert explanation.remedies == ()


def test_an_empty_hand_is_not_said_to_have_no_set() -> None:
    """Without fingers there is one set, the empty one: nothing holds, and no sampler is asked."""
    scenario = gm_ompl.load("paper/slide", ["fingers.count=0", "lattice.segments=2"])
    explanation = gm_ompl.explain(scenario)
    assert explanation.verdict == "it is proven that no plan exists on the scenario's lattice"
    assert explanation.attempts == ()
    assert [survey.possible for survey in explanation.surveys] == [1, 1]
    assert any(line.startswith("  no fingers") for line in lines(explanation))


def test_without_time_nothing_is_searched() -> None:
    """A limit of 0: surveys alone; a negative one is bad input."""
    explanation = gm_ompl.explain("paper/slide", samples=5, time_limit=0)
    assert explanation.search is None and not explanation.remedies and not explanation.attempts
    assert [survey.judged for survey in explanation.surveys] == [5, 5]
    for limit in (-1.0, float("nan")):
        with pytest.raises(InputError, match="time limit"):
            gm_ompl.explain("paper/slide", time_limit=limit)


def test_an_interrupt_ends_the_explanation(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that was interrupted is no finding: the command ends as interrupted."""

    class Interrupted:
        def solve(self, *_: object) -> SearchResult:
            return SearchResult(Status.INTERRUPTED)

    monkeypatch.setattr(remedies, "make_planner", lambda _: Interrupted())
    assert CliRunner().invoke(app, ["explain", "paper/slide"]).exit_code == 130


@pytest.mark.parametrize(
    ("truth", "words"),
    [
        (lambda f_max: f_max >= 7.3, ("fingers.max_normal_force=", "none on the lattice with")),
        (lambda f_max: f_max > 1e9, ("=500", "none on the lattice up to 100 times")),
    ],
)
def test_bisection_finds_the_least(truth: Callable[[float], bool], words: tuple[str, str]) -> None:
    """Against a known threshold: at most 2% (and rounding) above it; beyond reach, "none"."""
    problem = load("paper/slide", ["fingers.max_normal_force=5"]).problem
    knob = next(iter(knobs(problem)))

    def holds(changed: Problem, _: float) -> TrialOutcome:
        return (
            TrialOutcome.YES
            if truth(float(changed.fingers.max_normal_force[0]))
            else TrialOutcome.NO
        )

    remedy = least(knob, holds, PLAN, TrialOutcome.NO, Limits(60.0))
    assert words[0] in remedy.change and words[1] in remedy.evidence
    assert "today 5" in remedy.evidence
    if remedy.helps:
        assert 7.3 <= float(remedy.change.split("=")[1]) <= 7.3 * 1.03
        assert remedy.evidence.startswith(f"a plan exists with {remedy.change.replace('=', ' = ')}")


def test_what_is_not_known_is_not_called_proven() -> None:
    """A search that ends without an answer settles nothing, above or below."""
    problem = load("paper/slide").problem
    for knob in knobs(problem):
        vain = least(
            knob, lambda *_: TrialOutcome.UNKNOWN, PLAN, TrialOutcome.UNKNOWN, Limits(60.0)
        )
        assert not vain.helps and "on the lattice" not in vain.evidence
        late = least(knob, lambda *_: TrialOutcome.YES, PLAN, TrialOutcome.NO, Limits(0.0))
        assert not late.helps and "not settled in the time" in late.evidence


@pytest.mark.filterwarnings("ignore:.*at the goal the object touches nothing")
@pytest.mark.parametrize("key", ["fingers.soft", "mechanics.z_min"])
def test_a_card_asks_for_soft_fingertips_or_for_equilibrium_alone(key: str) -> None:
    """Two points cannot hold a card against a twist: what is named helps, what is next does not."""
    scenario = gm_ompl.load(card(0.0, 0.1))
    (knob,) = [knob for knob in knobs(scenario.problem) if knob.key == key]

    def holds(changed: Problem, seconds: float) -> TrialOutcome:
        solved = remedies.search(changed, seconds) is Status.SOLVED
        return TrialOutcome.YES if solved else TrialOutcome.NO

    remedy = least(knob, holds, PLAN, TrialOutcome.NO, Limits(60.0))
    assert remedy.helps and (key == "fingers.soft" or remedy.change == "mechanics.z_min=0")
    assert gm_ompl.plan(scenario.with_(remedy.change)).status == "solved"
    missed = re.search(r"none on the lattice with (.*?)\)", remedy.evidence)
    assert missed is not None
    assert gm_ompl.plan(scenario.with_(f"{key}={missed[1]}")).status == "infeasible"


def test_values_are_turned_from_what_they_are() -> None:
    """A factor of 1 changes nothing, of 0 either; no fingertip is softer than it is wide."""
    smooth = ["friction.finger=0", "friction.environment=0", "fingers.soft=[0, 0.1]"]
    for changes in ([], smooth, ["fingers.soft=0.3"]):
        problem = load("paper/slide", [*changes, "fingers.radius=0.3"]).problem
        for knob in knobs(problem):
            np.testing.assert_allclose(knob.at(1.0), knob.values, rtol=5e-3)
            farthest = knob.at(knob.rungs[-1])
            assert knob.key != "fingers.soft" or (farthest <= problem.fingers.radius).all()
        assert ("fingers.soft" in [knob.key for knob in knobs(problem)]) == (
            "fingers.soft=0.3" not in changes
        )


def test_nothing_helps_down_to_equilibrium_alone() -> None:
    """Where z_min is turned down in vain, 0 was tried, too."""
    (knob,) = [k for k in knobs(load("paper/slide").problem) if k.key == "mechanics.z_min"]
    vain = least(knob, lambda *_: TrialOutcome.NO, PLAN, TrialOutcome.NO, Limits(60.0))
    assert (vain.change, vain.helps) == ("mechanics.z_min=0", False)
    assert vain.evidence.startswith("none on the lattice down to 0 ")


def test_contacts_stick_slide_or_separate() -> None:
    """Tumbling, the object sticks to its edge and leaves the floor elsewhere; sliding, it slides.

    Counted by hand: four corners of a box on the floor, an edge's two once it is tilted.
    """
    sliding = gm_ompl.explain("paper/slide", 0.5, samples=1, time_limit=0).contacts
    assert [line.motion for line in sliding] == [{"+s": "slides", "rest": "sticks"}] * 4
    assert {line.against for line in sliding} == {"floor"}
    assert {line.normal for line in sliding} == {(0.0, 0.0, 1.0)}
    flat = gm_ompl.explain("paper/tumble", 0.0, samples=1, time_limit=0).contacts
    assert sorted(line.motion["+s"] for line in flat) == ["separates"] * 2 + ["sticks"] * 2
    tilted = gm_ompl.explain("paper/tumble", 0.5, samples=1, time_limit=0).contacts
    assert [line.motion["+s"] for line in tilted] == ["sticks"] * 2
    assert all(line.point[2] == pytest.approx(0.0, abs=1e-6) for line in tilted)


def test_contacts_with_a_wall_are_named() -> None:
    """Against two walls, the floor and the walls are told apart, each with its normal."""
    found = gm_ompl.explain("paper/regrasp", 0.0, samples=1, time_limit=0).contacts
    normals = {line.against: line.normal for line in found}
    assert normals["floor"] == (0.0, 0.0, 1.0)
    for name, normal in normals.items():
        assert np.linalg.norm(normal) == pytest.approx(1.0), name


def test_the_contacts_are_those_that_the_mechanics_sees() -> None:
    """Those that do not separate are as many as the contact state has, wherever the object is."""
    for name in ("paper/tumble", "paper/regrasp", "paper/cork", "shapes/hexagon"):
        problem = load(name).problem
        for s in np.random.default_rng(0).random(5):
            q = (float(s),)
            pose, twist = problem.motion.pose(q), problem.motion.velocity(q, (1.0,))
            touching = environment_contacts(problem.body, problem.environment, pose)
            state = contact_state(touching, pose, twist, problem.body)
            words = [line.motion["+s"] for line in contact_lines(problem, q, [(1.0,)])]
            assert len(words) - words.count("separates") == len(state.points)
            assert words.count("slides") == int(np.count_nonzero(np.abs(state.slip).max(axis=1)))
            assert all(line.against for line in contact_lines(problem, q, [(1.0,)]))


def test_the_text_stays_short() -> None:
    """Under 40 lines however much there is to say; --json keeps it, and the text says so."""
    scenario = gm_ompl.load("paper/slide", ["fingers.count=5", "fingers.placements.grid=[3, 3]"])
    places = [(face, (1, 1)) for face in ("-x", "+x", "+y", "-y", "+z")]
    found = gm_ompl.explain(scenario, 0.5, places)
    assert sum(len(line.modes) for line in found.instants) == 64
    swollen = dataclasses.replace(
        found, instants=found.instants * 20, contacts=found.contacts * 20,
        remedies=(Remedy("a=1", True, "x" * 1000),) * 30,
    )  # fmt: skip
    for explanation in (found, swollen):
        text = lines(explanation)
        assert len(text) < 40
        assert max(len(line) for line in text) <= 240
    assert "--json has all of it" in lines(swollen)[-1]


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
