"""Executions in MuJoCo. Without it these tests are skipped; in CI they fail."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from gm_ompl import api
from gm_ompl.app.main import app
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.disturb import disturb, probe, resisted
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.execute import Setup, errant_world, execute, prepare
from gm_ompl.simulation.pulses import Disturber, shape
from gm_ompl.simulation.timeline import PHASES, Pace

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("mujoco") is None and not os.environ.get("CI"),
    reason="MuJoCo is not installed",
)

Tampered = Callable[[Plan, Callable[[dict[str, Any]], None]], Plan]


@pytest.fixture(scope="module")
def slide(slide_plan: Plan) -> Setup:
    return prepare(slide_plan)


def test_the_paper_s_experiment_executes(cork_plan: Plan) -> None:
    """Sec. 5.3: the box ends within 2 mm and 1 degree, the commanded force is followed, no slip."""
    report = execute(prepare(cork_plan))
    assert report.holds, report.findings
    assert report.end_position <= 0.002
    assert report.end_angle <= 1.0
    forced = [finger for finger in report.fingers if finger.force_error is not None]
    assert len(forced) == 1
    assert forced[0].force_error is not None
    assert forced[0].force_error <= 0.1
    assert max(finger.slip for finger in report.fingers) <= 0.0005
    assert [finger.in_range for finger in report.fingers if finger.in_range is not None] == [1.0]


def _halve(draft: dict[str, Any]) -> None:
    for step in draft["steps"]:
        for segment in step["segments"]:
            segment["f_com"] = [None if f is None else f / 2 for f in segment["f_com"]]


def test_half_the_force_does_not_hold_the_box(
    cork_plan: Plan, tampered: Tampered, tmp_path: Path
) -> None:
    """The cork box slips from fingers that press half as hard: exit code 5, and JSON says why."""
    path = tmp_path / "halved.json"
    tampered(cork_plan, _halve).save(path)
    result = CliRunner().invoke(app, ["execute", str(path), "--json"])
    assert result.exit_code == 5
    answer = json.loads(result.stdout)
    assert not answer["holds"]
    assert any("slips" in finding for finding in answer["findings"])
    first = next(segment for segment in answer["segments"] if segment["beyond"])
    assert all(part["came"] <= 1.2 * part["asked"] for part in first["fingers"])


def _without(i: int) -> Callable[[dict[str, Any]], None]:
    """Return the change that takes finger ``i`` away, from the scenario as well."""

    def tamper(draft: dict[str, Any]) -> None:
        scenario = draft["scenario"]
        scenario["fingers"]["count"] -= 1
        for section, key in [
            ("fingers", "radius"), ("fingers", "max_normal_force"), ("fingers", "soft"),
            ("fingers", "clearance"),
            ("fingers", "start"), ("fingers", "goal"), ("friction", "finger"),
        ]:  # fmt: skip
            del scenario[section][key][i]
        for step in draft["steps"]:
            del step["placements"][i]
            for segment in step["segments"]:
                del segment["modes"][i], segment["f_com"][i]

    return tamper


@pytest.mark.parametrize("tamper", [_halve, _without(1)], ids=["halved", "removed"])
def test_a_finger_for_disturbances_alone_is_missed_by_them(
    slide_plan: Plan, tampered: Tampered, tamper: Callable[[dict[str, Any]], None]
) -> None:
    """Without the pressing finger, or its force, the box is pushed home, but resists less than z.

    The plan as it is resists the same pulses better, and at its usual pace withstands them.
    """
    pace = Pace(speed=0.3)  # a box that hardly moves meanwhile is hardly shifted by a pulse
    setup = prepare(tampered(slide_plan, tamper), pace)
    assert execute(setup).holds
    lost, kept = probe(setup, 2), probe(prepare(slide_plan, pace), 2)
    assert lost.lost
    shifts = [max(trial.offset for trial in report.trials) for report in (lost, kept)]
    assert shifts[0] >= 1.5 * shifts[1]
    assert not probe(prepare(slide_plan), 2).lost


def test_a_plan_owes_its_z_min(slide_plan: Plan, tampered: Tampered) -> None:
    """A plan that honestly states a z below z_min is put to the test at z_min, and fails it."""

    def ask_for_more(draft: dict[str, Any]) -> None:
        draft["scenario"]["mechanics"]["z_min"] = 20.0  # three times its z

    assert probe(prepare(tampered(slide_plan, ask_for_more)), 1).share == 0.0


def test_the_weakest_direction_is_z_s(slide_plan: Plan) -> None:
    """The least of the 76 resistances at an instant is the z that the plan states there."""
    setup = prepare(slide_plan)
    moving = np.flatnonzero(setup.timeline.phase == PHASES.index("move"))
    instant = int(moving[len(moving) // 2])
    found = resisted(setup, instant).min() * setup.problem.mass * setup.problem.mechanics.gravity
    assert found == pytest.approx(setup.timeline.z[instant], rel=1e-6)


def _without_margin(draft: dict[str, Any]) -> None:
    draft["steps"][1]["segments"][0]["z"] = 0.4  # z_min is 0.5


@pytest.mark.parametrize(("tamper", "finding"), [(_without(0), "ends"), (_without_margin, "z_min")])
def test_wrong_plans_are_seen_to_fail(
    slide_plan: Plan, tampered: Tampered, tamper: Callable[[dict[str, Any]], None], finding: str
) -> None:
    """Nobody pushes, or the plan states less than its z_min: the execution does not hold."""
    report = execute(prepare(tampered(slide_plan, tamper)))
    assert any(finding in text for text in report.findings)


def test_executions_are_deterministic(slide: Setup) -> None:
    """The same plan, world and seed give the same numbers, to the last bit."""
    assert execute(slide).to_dict() == execute(slide).to_dict()
    first, second = (errant_world(slide, 0.05, 3) for _ in range(2))
    assert first.mass == second.mass and np.array_equal(first.offset, second.offset)
    assert errant_world(slide, 0.05, 4).mass != first.mass


def test_pulses_are_withstood_up_to_a_point_and_leave_no_trace(slide: Setup) -> None:
    """0.8 z is withstood, forty times z is not, and no pulse at all changes nothing at all."""
    small = disturb(slide, 0.8, 3, 1)
    assert small.share == 1.0
    assert small.to_dict() == disturb(slide, 0.8, 3, 1).to_dict()
    assert disturb(slide, 40.0, 2, 1).share < 1.0
    still = Disturber(slide, [4000]).trial(4000, np.eye(6)[0], -1, 0.0)
    assert still.offset == 0.0


def test_a_pulse_lasts() -> None:
    """It rises from 0, stays at its peak for a third of its 0.3 s, falls to 0 and is over."""
    strengths = np.array([shape(k) for k in range(round(0.5 / STEP))])
    assert strengths[0] == 0.0
    assert (strengths == 1.0).sum() * STEP == pytest.approx(0.1, abs=0.002)
    assert (strengths[round(0.3 / STEP) :] == 0.0).all()
    assert np.abs(np.diff(strengths)).max() <= np.pi / 2.0 / 0.1 * STEP * 1.01


def test_what_is_off_is_what_was_asked_for(slide: Setup) -> None:
    """One kind of error alone leaves the others as modelled, and is the same as among all."""
    every, alone = errant_world(slide, 0.05, 3), errant_world(slide, 0.05, 3, ("place",))
    assert np.array_equal(every.offset, alone.offset)
    assert alone.mass == slide.world.mass != every.mass
    assert np.array_equal(alone.friction, slide.world.friction)
    assert np.array_equal(alone.pieces[0], slide.world.pieces[0])


def test_results_do_not_depend_on_the_unit(cork_plan: Plan, tampered: Tampered) -> None:
    """A plan in millimetres and grams is executed like the same plan in metres and kilograms."""

    def to_millimetres(draft: dict[str, Any]) -> None:
        scenario = draft["scenario"]
        scenario["object"]["shape"]["box"] = [1e3 * v for v in scenario["object"]["shape"]["box"]]
        scenario["fingers"]["radius"] = [1e3 * v for v in scenario["fingers"]["radius"]]
        scenario["motion"]["start"]["position"] = [0, 0, 50]
        wall = scenario["environment"]["obstacles"]["wall_behind"]["box"]
        wall.update({key: [1e3 * v for v in wall[key]] for key in ("min", "max")})
        draft["steps"] = draft["steps"][:2]
        for step in draft["steps"]:
            turn = step["arc"]["rotation"]
            turn["point"] = [1e3 * v for v in turn["point"]]
            for pose in (step["pose_from"], step["pose_to"]):
                pose["position"] = [1e3 * v for v in pose["position"]]
            for place in step["placements"]:
                place["point"] = [1e3 * v for v in place["point"]]

    short = tampered(cork_plan, lambda draft: draft.update(steps=draft["steps"][:2]))
    metres = execute(prepare(short))
    millimetres = execute(prepare(tampered(cork_plan, to_millimetres)))
    assert millimetres.end_position == pytest.approx(1e3 * metres.end_position, rel=1e-3)
    assert millimetres.fingers[0].greatest_force == pytest.approx(
        metres.fingers[0].greatest_force, rel=1e-3
    )


def test_a_film_is_made_without_a_display(slide_plan: Plan, tmp_path: Path) -> None:
    """``--video`` writes a film whose pictures differ; ``--plot`` writes a picture."""
    path, film, plot = tmp_path / "plan.json", tmp_path / "film.gif", tmp_path / "forces.png"
    slide_plan.save(path)
    command = [
        "execute",
        str(path),
        "--speed",
        "2",
        "--probe",
        "0",
        "--video",
        str(film),
        "--plot",
        str(plot),
    ]
    environment = {key: v for key, v in os.environ.items() if key not in ("DISPLAY", "MUJOCO_GL")}
    done = subprocess.run(
        [sys.executable, "-m", "gm_ompl", *command],
        capture_output=True, text=True, env=environment, check=False,
    )  # fmt: skip
    if "cannot render" in done.stderr and not os.environ.get("CI"):
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stdout + done.stderr
    assert plot.stat().st_size > 1000
    import imageio.v2 as imageio

    pictures = imageio.mimread(film, memtest=False)
    assert len(pictures) > 30
    assert np.abs(np.asarray(pictures[0], float) - np.asarray(pictures[-1], float)).mean() > 1.0


def test_without_mujoco_the_command_says_what_to_install(
    slide_plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exit code 2, and the message is a command."""
    path = tmp_path / "plan.json"
    slide_plan.save(path)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    result = CliRunner().invoke(app, ["execute", str(path)])
    assert result.exit_code == 2
    assert 'pip install "gm-ompl[sim]"' in result.output


@pytest.mark.parametrize(
    "wrong", [["--disturb", "-1"], ["--vary", "0"], ["--speed", "0"], ["--video", "film.txt"]]
)
def test_wrong_options_are_bad_input(slide_plan: Plan, tmp_path: Path, wrong: list[str]) -> None:
    """Each is refused with its name and what would be right, exit code 2."""
    path = tmp_path / "plan.json"
    slide_plan.save(path)
    result = CliRunner().invoke(app, ["execute", str(path), *wrong])
    assert result.exit_code == 2
    assert wrong[0].strip("-") in result.output


@pytest.fixture(scope="module")
def driven() -> Setup:
    """Two fingers under force control push a box with just what friction takes."""
    return prepare(api.plan("random/push/5"))


def test_force_alone_drives_what_nothing_else_does(driven: Setup) -> None:
    """The box keeps pace with the plan."""
    report = execute(driven)
    assert report.holds, report.findings


def test_forces_that_drive_are_as_asked_when_the_object_sets_off(driven: Setup) -> None:
    """Wherever a fingertip has stuck, its spring has let go sideways before the first motion."""
    player, line = driven.player(), driven.timeline
    player.play(until=int(np.flatnonzero(line.phase == PHASES.index("move"))[0]))
    k, here = player.instant - 1, player.physics
    given = player.servo.forces(k, here.centres, here.velocities)
    n = line.normal[k]
    wanted = line.lean[k] * driven.units.force
    beside = (given - wanted) - ((given - wanted) * n).sum(axis=1)[:, None] * n
    assert np.abs(beside).max() <= 0.01 * driven.world.mass * driven.world.gravity
