from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.planfile.fit import mistakes
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import PHASES, Pace
from tests.check.tampering import put
from tests.free_plans import solved


@pytest.mark.parametrize("scene", ["lean", "slide", "tilted"])
def test_a_free_plan_is_laid_out_in_time(scene: str) -> None:
    """The timeline begins at the scenario's start, ends where the plan ends, and never jumps."""
    problem, plan = solved(scene)
    line = schedule(plan, problem, Pace(), 0.01)
    last = [step for step in plan.steps if step.kind == "displacement"][-1]
    assert line.position[0] == pytest.approx(problem.motion.pose(()).position)
    assert line.position[-1] == pytest.approx(last.pose_to.position, abs=1e-9)
    assert np.abs(np.diff(line.position, axis=0)).max() < 0.02
    moving = line.phase == PHASES.index("move")
    assert set(line.step[moving].tolist()) == {
        k for k, step in enumerate(plan.steps) if step.kind == "displacement"
    }


def test_a_regrasp_first_rests_at_the_start() -> None:
    """Without coordinates a plan that begins with a regrasp begins at the scenario's start."""
    problem, plan = solved("lean")
    regrasp = plan.steps[2]
    begun = plan.model_copy(update={"steps": (regrasp, *plan.steps[:2])})
    line = schedule(begun, problem, Pace(), 0.05)
    assert line.position[0] == pytest.approx([0.0, 0.0, 0.5])


def test_coordinates_do_not_fit_free_motion() -> None:
    """A plan fits its scenario where its coordinates are null; others are named."""
    problem, plan = solved("lean")
    assert not list(mistakes(plan, problem))
    draft = plan.to_dict()
    put("steps.0.to", [0.25])(draft)
    put("steps.2.at", [0.25])(draft)
    found = dict(mistakes(type(plan).model_validate(draft, strict=False), problem))
    assert found == {
        ("steps", 0, "to"): "[0.25]: must be null with free motion",
        ("steps", 2, "at"): "[0.25]: must be null with free motion",
    }
