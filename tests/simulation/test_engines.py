"""The two simulators, against Coulomb's law and each other. Without them skipped, in CI not."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from gm_ompl import api
from gm_ompl.app.main import app
from gm_ompl.arrays import Array
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.engine import STEP, EngineName
from gm_ompl.simulation.engines import start
from gm_ompl.simulation.execute import execute, prepare
from gm_ompl.simulation.world import Bodies

pytestmark = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("mujoco", "dartpy"))
    and not os.environ.get("CI"),
    reason="MuJoCo or DART is not installed",
)

Tampered = Callable[[Plan, Callable[[dict[str, Any]], None]], Plan]
UPRIGHT, FAR = np.array([1.0, 0.0, 0.0, 0.0]), np.full((2, 3), 5.0)


def _pushed(engine: EngineName, world: Bodies, force: float) -> tuple[float, float]:
    """Return how far a box on the floor goes in the first and second 0.2 s of a push [N]."""
    physics = start(engine, replace(world, obstacles=()), np.array([0.0, 0.0, 0.05]), UPRIGHT, FAR)
    places = []
    for pause, push in ((0.2, 0.0), (0.2, force), (0.2, force)):
        for _ in range(round(pause / STEP)):
            physics.step(np.zeros((2, 3)), UPRIGHT, np.zeros(3), np.array([push, 0, 0, 0, 0, 0]))
        places.append(float(physics.position[0]))
    return places[1] - places[0], places[2] - places[1]


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
@pytest.mark.parametrize("mu", [0.15, 0.4])
def test_friction_is_the_scenario_s(cork_plan: Plan, mu: float, engine: EngineName) -> None:
    """A box stays under a push of 0.95 mu M g; under 1.1 mu M g it goes as Coulomb says."""
    world = replace(prepare(cork_plan).world, environment_friction=mu)
    limit = mu * world.mass * world.gravity
    assert abs(_pushed(engine, world, 0.95 * limit)[1]) <= 2e-5
    way = 0.5 * 0.1 * mu * world.gravity * 0.4**2
    assert sum(_pushed(engine, world, 1.1 * limit)) == pytest.approx(way, rel=0.15)


def _prism() -> Array:
    """Return a bar of six sides, (12, 3), that lies on one of them 0.0433 below its middle."""
    angles = np.pi / 6.0 + np.pi / 3.0 * np.arange(6)
    return np.array(
        [[0.05 * np.sin(a), y, 0.05 * np.cos(a)] for a in angles for y in (-0.05, 0.05)]
    )


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_what_is_no_box_rests_on_its_face(cork_plan: Plan, engine: EngineName) -> None:
    """A bar that is put down stays, and a fingertip that presses feels its own force."""
    height = 0.05 * np.cos(np.pi / 6.0)
    world = replace(prepare(cork_plan).world, pieces=(_prism(),), obstacles=())
    above = np.array([[0.0, 0.0, 2.0 * height + world.radius[0]], [5.0, 5.0, 5.0]])
    bar = start(engine, world, np.array([0.0, 0.0, height]), UPRIGHT, above)
    for _ in range(400):
        bar.step(np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.0]]), UPRIGHT, np.zeros(3))
    assert bar.position == pytest.approx([0.0, 0.0, height], abs=2e-4)
    assert abs(bar.quaternion[0]) == pytest.approx(1.0, abs=1e-5)
    assert bar.normal_forces() == pytest.approx([0.5, 0.0], abs=0.02)


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_fingertips_touch_the_object_alone(cork_plan: Plan, engine: EngineName) -> None:
    """Fingertips in the floor, in a wall and in each other stay where they are."""
    wall = np.array([[x, y, z] for x in (0.9, 1.1) for y in (-1.0, 1.0) for z in (0.0, 1.0)])
    world = replace(prepare(cork_plan).world, obstacles=(wall,))
    inside = np.array([[0.9, 0.0, 0.0], [0.9, 0.0, 1.5 * world.radius[0]]])
    physics = start(engine, world, np.array([0.0, 0.0, 0.05]), UPRIGHT, inside)
    for _ in range(200):
        physics.step(np.zeros((2, 3)), UPRIGHT, np.zeros(3))
    assert physics.centres == pytest.approx(inside, abs=1e-9)
    assert physics.normal_forces() == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_a_wall_holds_what_is_turned_by_a_hair(cork_plan: Plan, engine: EngineName) -> None:
    """One side of a box is in a wall by a thousandth of a millimetre: it gets no farther.

    With another of DART's detectors this very pose met nothing.
    """
    d, h = 0.04096399370774052, 0.030722995280805392
    box = np.array([[x, y, z] for x in (-d, d) for y in (-d, d) for z in (-h, h)])
    wall = np.array(
        [[x, y, z] for x in (-d, 0.6144599) for y in (d, 0.40963994) for z in (0.0, 0.20481997)]
    )
    world = replace(prepare(cork_plan).world, pieces=(box,), obstacles=(wall,))
    half = 0.5 * 2.0795545e-4
    physics = start(
        engine, world, np.array([0.04099754531, 7.709222351673839e-6, h]),
        np.array([np.cos(half), 0.0, 0.0, np.sin(half)]), FAR,
    )  # fmt: skip
    push = np.array([0.0, 2.0 * world.mass * world.gravity, 0.0, 0.0, 0.0, 0.0])
    for _ in range(400):
        physics.step(np.zeros((2, 3)), UPRIGHT, np.zeros(3), push)
    assert abs(physics.position[1]) < 2e-4


def test_dart_goes_on_where_it_was(slide_plan: Plan) -> None:
    """A state taken up again leads to the same future, up to the order of contacts."""
    player = prepare(slide_plan, engine="dart").player()
    player.play(until=3000)
    snapshot = player.snapshot()
    once = player.play(until=3200)
    player.resume(snapshot)
    again = player.play(until=3200)
    assert again.position == pytest.approx(once.position, abs=1e-6)
    assert again.normal_force == pytest.approx(once.normal_force, abs=0.01)


def test_a_plan_and_a_wrong_one_are_judged_alike_in_dart(
    slide_plan: Plan, tampered: Tampered
) -> None:
    """The slide holds; pushed with a quarter of its friction's force it does not."""
    report = execute(prepare(slide_plan, engine="dart"))
    assert report.holds, report.findings
    assert not [segment for segment in report.segments if segment.beyond]

    def slippery(draft: dict[str, Any]) -> None:
        draft["scenario"]["fingers"]["max_normal_force"] = [1e-3, 1e-3]
        for step in draft["steps"]:
            for segment in step["segments"]:
                segment["f_com"] = [None if f is None else 1e-4 for f in segment["f_com"]]

    weak = execute(prepare(tampered(slide_plan, slippery), engine="dart"))
    assert not weak.holds
    assert "first in step" in weak.table()


def test_what_fails_between_the_middles_is_noted() -> None:
    """A plan is judged at its segments' middles; one that cannot balance elsewhere is told of."""
    notes = prepare(api.plan("random/chain/40")).timeline.notes
    assert any("not at all" in note for note in notes)


def test_judged_at_their_ends_arcs_balance_everywhere() -> None:
    """A box out of a corner: at its middles alone it balances just so where a turn ends."""
    told = {}
    for where in ("middles", "ends"):
        plan = api.plan(api.load("free/out-of-the-corner", [f"cost.samples_at={where}"]))
        assert api.check(plan).holds
        told[where] = prepare(plan).timeline.notes
    assert told["middles"]
    assert not told["ends"]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--engine", "bullet"], "mujoco or dart"),
        (["--engine", "dart", "--video", "film.gif"], "not filmed"),
    ],
)
def test_what_an_engine_cannot_do_is_bad_input(
    slide_plan: Plan, tmp_path: Path, options: list[str], told: str
) -> None:
    """Exit code 2; the message says what there is."""
    path = tmp_path / "plan.json"
    slide_plan.save(path)
    options = [str(tmp_path / one) if one.endswith(".gif") else one for one in options]
    result = CliRunner().invoke(app, ["execute", str(path), *options])
    assert result.exit_code == 2
    assert told in result.output


def test_without_dart_the_command_says_what_to_install(
    slide_plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exit code 2, and the message is a command."""
    path = tmp_path / "plan.json"
    slide_plan.save(path)
    monkeypatch.setitem(sys.modules, "dartpy", None)
    result = CliRunner().invoke(app, ["execute", str(path), "--engine", "dart"])
    assert result.exit_code == 2
    assert 'pip install "gm-ompl[sim2]"' in result.output
