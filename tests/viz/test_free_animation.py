from __future__ import annotations

import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.figures import axis_of

from tests.free_plans import solved


def test_a_free_plan_is_shown_step_by_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """The regrasp is shown where the last arc ended; a plot counts displacement steps."""
    problem, plan = solved("lean")
    monkeypatch.setattr("gm_ompl.viz.animation.problem_of", lambda _: problem)
    animation = animate(plan)
    (regrasp,) = (segment for segment in animation.segments if segment.segment is None)
    assert regrasp.poses[0, :3] == pytest.approx([1.0, 0.0, 0.5])
    axis = axis_of(animation)
    assert axis.label == "displacement steps"
    assert axis.end.tolist() == pytest.approx([1 / 3, 2 / 3, 1, 4 / 3, 5 / 3, 2, 2.5, 3])
    assert axis.regrasps == ((2.0, 0),)
    assert animation.rest_pose()[:3] == pytest.approx([0.0, 0.0, 0.5])
