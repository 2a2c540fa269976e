"""The film of a plan shows the plan: poses and lifted fingertips are where they should be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.film import RATE, moments
from PIL import Image
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.planfile.model import Plan


def test_it_begins_at_the_start_and_ends_at_the_goal(regrasp: Plan) -> None:
    """First and last picture have the plan's first and last pose; quaternions stay unit."""
    animation = animate(regrasp)
    shown = list(moments(animation))
    assert len(shown) == round(animation.duration * RATE) + 1
    np.testing.assert_allclose(shown[0].pose, animation.segments[0].poses[0], atol=1e-12)
    np.testing.assert_allclose(shown[-1].pose, animation.segments[-1].poses[-1], atol=1e-12)
    np.testing.assert_allclose([np.linalg.norm(one.pose[3:]) for one in shown], 1.0)
    poses = np.array([one.pose for one in shown])
    assert np.abs(np.diff(poses, axis=0)).max() < 0.3  # nothing jumps


def test_a_lifted_fingertip_goes_from_placement_to_placement(regrasp: Plan) -> None:
    """It is on its way in the regrasp's pictures alone, nearer to the end in each."""
    (step,) = (step for step in regrasp.steps if step.kind == "regrasp")
    animation = animate(regrasp)
    end = animation.centre(step.finger, step.to)
    lifted = [one.lifted for one in moments(animation) if one.lifted is not None]
    left = [float(np.linalg.norm(place - end)) for place in lifted]
    assert len(lifted) == pytest.approx(2.0 * RATE, abs=1)
    assert left[0] > left[-1] and left[-1] < 0.2 * left[0]


def test_the_command_writes_a_small_gif_that_moves(regrasp: Plan, tmp_path: Path) -> None:
    """Under 1 MB; frames differ, and the last is held."""
    plan, film = tmp_path / "plan.json", tmp_path / "plan.gif"
    regrasp.save(plan)
    result = CliRunner().invoke(app, ["plot", str(plan), "--show", "film", "-o", str(film)])
    assert result.exit_code == 0, result.output
    assert film.stat().st_size < 1_000_000
    with Image.open(film) as image:
        first = np.asarray(image.convert("RGB"))
        image.seek(image.n_frames - 1)  # type: ignore[attr-defined]
        assert (np.asarray(image.convert("RGB")) != first).any()
        assert image.info["duration"] == 1500
    refused = CliRunner().invoke(app, ["plot", str(plan), "--show", "film", "-o", "plan.png"])
    assert refused.exit_code == 2
    assert ".gif" in refused.stderr


def test_without_a_plan_there_is_no_film(infeasible: Plan, tmp_path: Path) -> None:
    """Exit code 2, and no file."""
    plan, film = tmp_path / "plan.json", tmp_path / "plan.gif"
    infeasible.save(plan)
    refused = CliRunner().invoke(app, ["plot", str(plan), "--show", "film", "-o", str(film)])
    assert refused.exit_code == 2
    assert not film.exists()
