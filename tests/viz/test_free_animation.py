from __future__ import annotations

import pytest
from gm_ompl.viz.animation import animate
from gm_ompl.viz.figures import axis_of
from gm_ompl.viz.scene import scene_messages
from gm_ompl.viz.score import score
from gm_ompl.viz.snapshots import pictures

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


def test_what_happens_is_told_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's list has each thing once, with the steps that belong to it; pictures likewise."""
    problem, plan = solved("lean")
    monkeypatch.setattr("gm_ompl.viz.animation.problem_of", lambda _: problem)
    animation = animate(plan)
    told = score(animation, scene_messages(animation))["chain"]
    assert [(one["first"], one["last"]) for one in told] == [(0, 1), (2, 2), (3, 3)]
    words = [one["words"] for one in told]
    assert words[0] == "tumbles 90 deg about +y over its +x edge"
    assert words[1].startswith("finger 0 moves to")
    assert words[2].startswith("tumbles 17.") and "over its +x edge" in words[2]
    captions = [picture.caption for picture in pictures(animation)]
    assert captions == ["start", "before regrasp 1", "after regrasp 1", "goal"]


def test_pictures_show_where_the_object_begins_something_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Between start and goal, the end of each link, at the pose where it ends."""
    problem, plan = solved("lean")
    monkeypatch.setattr("gm_ompl.viz.animation.problem_of", lambda _: problem)
    steps = [step for step in plan.steps if step.kind == "displacement"]
    animation = animate(plan.model_copy(update={"steps": tuple(steps)}))
    start, turned, goal = pictures(animation)
    assert turned.caption.split() == animation.chain[0].words.split()
    assert turned.pose[:3] == pytest.approx(steps[1].pose_to.position)
    assert goal.pose[:3] == pytest.approx(steps[2].pose_to.position)
    assert start.caption == "start"
