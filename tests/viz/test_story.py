from __future__ import annotations

import itertools

import numpy as np
import pytest
from gm_ompl.viz.story import tell
from gm_ompl.viz.transit import transit

from gm_ompl import api
from gm_ompl.plan.assemble import placement_record
from gm_ompl.plan.model import Plan


def test_beats_follow_each_other(regrasp: Plan) -> None:
    """One beat per segment and per regrasp, in time without gaps, poses without jumps."""
    story = tell(regrasp)
    wanted = sum(len(s.segments) if s.kind == "displacement" else 1 for s in regrasp.steps)
    assert len(story.beats) == wanted
    assert story.beats[0].start == 0.0
    for before, after in itertools.pairwise(story.beats):
        assert before.end == pytest.approx(after.start)
        np.testing.assert_allclose(before.poses[-1][:3], after.poses[0][:3], atol=1e-9)
        assert abs(before.poses[-1][3:] @ after.poses[0][3:]) == pytest.approx(1.0)
    assert story.duration == story.beats[-1].end


def test_modes_forces_and_z_are_the_plans(regrasp: Plan) -> None:
    """Each beat carries its segment's decision unchanged."""
    for beat in tell(regrasp).beats:
        step = regrasp.steps[beat.step]
        told = step if step.kind == "regrasp" else step.segments[beat.segment or 0]
        assert beat.modes == "".join((mode or "lifted")[0].upper() for mode in told.modes)
        assert (beat.f_com, beat.z) == (told.f_com, told.z)


def test_poses_between_nodes_are_the_motions_own(regrasp: Plan) -> None:
    """What a viewer interpolates stays on the tumble: the lower edge never leaves its place."""
    story = tell(regrasp)
    edge = story.problem.body.vertices[
        np.flatnonzero((story.problem.body.vertices @ [1, 0, -1]) > 7.0)
    ]
    assert len(edge) == 2
    for beat in story.beats:
        for row in beat.poses:
            w, u = row[3], row[4:]
            world = edge + 2 * w * np.cross(u, edge) + 2 * np.cross(u, np.cross(u, edge)) + row[:3]
            np.testing.assert_allclose(world[:, [0, 2]], [[2.5, 0.0]] * 2, atol=1e-9)


@pytest.mark.parametrize("name", ["paper/regrasp", "paper/cork"])
def test_a_lifted_finger_never_touches_the_object(name: str) -> None:
    """Between any two placements, straight lines between stored points keep their distance."""
    scenario = api.load(name)
    problem = scenario.problem
    radius = float(problem.fingers.radius[0])
    half = np.abs(problem.body.vertices).max(axis=0)
    rng = np.random.default_rng(6)
    for _ in range(150):
        rows = rng.integers(len(problem.fingers.placements), size=2)
        old, new = (placement_record(problem, int(row)) for row in rows)
        pose = problem.motion.pose([rng.uniform()])
        path = transit(problem, pose, 0, old, new)
        for place, end in ((old, path[0]), (new, path[-1])):
            np.testing.assert_allclose(end, np.array(place.point) - radius * np.array(place.normal))
        fine = np.concatenate([np.linspace(a, b, 9) for a, b in itertools.pairwise(path)])
        gaps = np.linalg.norm(np.maximum(np.abs(fine) - half, 0.0), axis=1)
        assert gaps.min() >= radius * (1.0 - 1e-9)
        assert gaps[len(gaps) // 2] > 1.01 * radius


def test_a_plan_without_steps_has_no_beats(infeasible: Plan) -> None:
    """There is nothing to tell, and a pose to show."""
    story = tell(infeasible)
    assert (story.beats, story.duration) == ((), 0.0)
    assert story.rest_pose()[:3].tolist() == infeasible.scenario["motion"]["start"]["position"]
