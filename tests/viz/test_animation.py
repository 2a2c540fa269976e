from __future__ import annotations

import itertools

import numpy as np
import pytest
from gm_ompl.viz.animation import animate, transit_path

from gm_ompl import api
from gm_ompl.planfile.assemble import placement_record
from gm_ompl.planfile.model import Plan


def test_segments_follow_each_other(regrasp: Plan) -> None:
    """One segment per segment and per regrasp, in time without gaps, poses without jumps."""
    animation = animate(regrasp)
    wanted = sum(len(s.segments) if s.kind == "displacement" else 1 for s in regrasp.steps)
    assert len(animation.segments) == wanted
    assert animation.segments[0].start == 0.0
    for before, after in itertools.pairwise(animation.segments):
        assert before.end == pytest.approx(after.start)
        np.testing.assert_allclose(before.poses[-1][:3], after.poses[0][:3], atol=1e-9)
        assert abs(before.poses[-1][3:] @ after.poses[0][3:]) == pytest.approx(1.0)
    assert animation.duration == animation.segments[-1].end


def test_modes_forces_and_z_are_the_plans(regrasp: Plan) -> None:
    """Each segment carries its segment's decision unchanged."""
    for segment in animate(regrasp).segments:
        step = regrasp.steps[segment.step]
        told = step if step.kind == "regrasp" else step.segments[segment.segment or 0]
        assert segment.modes == "".join((mode or "lifted")[0].upper() for mode in told.modes)
        assert (segment.record.f_com, segment.record.z) == (told.f_com, told.z)


def test_poses_between_nodes_are_the_motions_own(regrasp: Plan) -> None:
    """What a viewer interpolates stays on the tumble: the lower edge never leaves its place."""
    animation = animate(regrasp)
    edge = animation.problem.body.vertices[
        np.flatnonzero((animation.problem.body.vertices @ [1, 0, -1]) > 7.0)
    ]
    assert len(edge) == 2
    for segment in animation.segments:
        for row in segment.poses:
            w, u = row[3], row[4:]
            world = edge + 2 * w * np.cross(u, edge) + 2 * np.cross(u, np.cross(u, edge)) + row[:3]
            np.testing.assert_allclose(world[:, [0, 2]], [[2.5, 0.0]] * 2, atol=1e-9)


@pytest.mark.parametrize("name", ["paper/regrasp", "paper/cork"])
def test_a_lifted_finger_never_touches_the_object(name: str, regrasp: Plan) -> None:
    """Between any two placements, straight lines between stored points keep their distance."""
    problem = api.load(name).problem
    step = next(step for step in regrasp.steps if step.kind == "regrasp")
    radius = float(problem.fingers.radius[0])
    half = np.abs(problem.body.vertices).max(axis=0)
    rng = np.random.default_rng(6)
    for _ in range(12):
        rows = rng.choice(len(problem.fingers.placements), size=2, replace=False)
        old, new = (placement_record(problem, int(row)) for row in rows)
        pose = problem.motion.pose([rng.uniform()])
        change = {"finger": 0, "from_": old, "to": new, "placements": (old,), "way": None}
        path = transit_path(problem, pose, step.model_copy(update=change))
        for place, end in ((old, path[0]), (new, path[-1])):
            touch = np.array(place.point) - radius * np.array(place.normal)
            np.testing.assert_allclose(end, touch, atol=1e-12)
        fine = np.concatenate([np.linspace(a, b, 9) for a, b in itertools.pairwise(path)])
        gaps = np.linalg.norm(np.maximum(np.abs(fine) - half, 0.0), axis=1)
        assert gaps.min() >= radius * (1.0 - 1e-9)
        assert gaps[len(gaps) // 2] > 1.01 * radius


def test_a_plan_without_steps_has_no_segments(infeasible: Plan) -> None:
    """There is nothing to tell, and a pose to show."""
    animation = animate(infeasible)
    assert (animation.segments, animation.duration) == ((), 0.0)
    assert animation.rest_pose()[:3].tolist() == infeasible.scenario["motion"]["start"]["position"]
