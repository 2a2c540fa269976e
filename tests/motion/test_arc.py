"""Arcs: what all kinds owe, against finite differences, motions and themselves read back."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import INSIDE, Arc
from gm_ompl.motion.planar import Straight
from gm_ompl.motion.screw import Screw, Slide, Tumble
from gm_ompl.planfile.arcs import arc_of, arc_record
from gm_ompl.planfile.assemble import pose_record
from gm_ompl.planfile.model import DisplacementStep
from gm_ompl.scenario.load import load

START = Pose.from_yaw([1.0, -2.0, 3.0], 0.4)
ARCS: dict[str, Arc] = {
    "slide": Screw(START, Slide(np.array([1.0, 2.0, -0.5]))),
    "part of a slide": Screw(START, Slide(np.array([1.0, 2.0, -0.5])), 0.75, 0.25),
    "tumble": Screw(START, Tumble(np.array([2.0, 0, 0]), np.array([0.6, 0.8, 0]), 1.2)),
    "part of a tumble": Screw(
        START, Tumble(np.array([2.0, 0, 0]), np.array([0.6, 0, 0.8]), -2.0), 0.2, 0.9
    ),
    "straight": Straight((1.0, 2.0, 0.3), (2.0, 1.5, -1.4), 2.5),
}


@pytest.mark.parametrize("name", ARCS)
def test_the_twist_is_the_derivative_of_the_pose(name: str) -> None:
    """Central differences of points fixed on the object give the twist's velocities."""
    arc, h = ARCS[name], 1e-6
    points = np.random.default_rng(0).normal(size=(5, 3))
    for t in (0.1, 0.5, 0.93):
        slope = (arc.pose(t + h).apply(points) - arc.pose(t - h).apply(points)) / (2 * h)
        arms = points @ arc.pose(t).rotation.T
        np.testing.assert_allclose(arc.twist(t).at(arms), slope, atol=1e-8)


@pytest.mark.parametrize("name", ARCS)
def test_sweeps_pass_the_arcs_poses(name: str) -> None:
    """The form that swept tests use goes where the arc goes."""
    arc = ARCS[name]
    (sweep,) = arc.sweeps
    for t in np.linspace(0.0, 1.0, 7):
        np.testing.assert_allclose(sweep.pose(t).rotation, arc.pose(t).rotation, atol=1e-12)
        np.testing.assert_allclose(sweep.pose(t).position, arc.pose(t).position, atol=1e-12)


@pytest.mark.parametrize("name", ARCS)
def test_segments_are_equal_parts(name: str) -> None:
    """They follow each other from end to end; each is judged in its middle; chords are its own."""
    arc, points = ARCS[name], np.random.default_rng(1).normal(size=(4, 3))
    segments = arc.segments(3)
    assert [segment.first for segment in segments] == [0.0, 1 / 3, 2 / 3]
    for j, (segment, moment) in enumerate(zip(segments, arc.middles(3), strict=True)):
        np.testing.assert_allclose(segment.middle.pose.position, moment.pose.position, atol=1e-12)
        way = segment.end.apply(points) - segment.start.apply(points)
        np.testing.assert_allclose(arc.chords(points, 3)[j], np.linalg.norm(way, axis=1))
    np.testing.assert_array_equal(segments[-1].end.position, arc.end.position)


@pytest.mark.parametrize("name", ARCS)
def test_judged_from_end_to_end(name: str) -> None:
    """Evenly, just inside the ends; between two places the segments meet; chords are their own."""
    arc, points = dataclasses.replace(ARCS[name], ends=True), np.eye(3)  # type: ignore[type-var]
    segments = arc.segments(3)
    assert arc.bounds(3) == [0.0, 0.25, 0.75, 1.0]
    assert [segment.at for segment in segments] == [INSIDE, 0.5, 1.0 - INSIDE]
    for j, (segment, moment) in enumerate(zip(segments, arc.middles(3), strict=True)):
        assert moment.key == segment.middle.key == arc.moment(segment.at).key
        way = segment.end.apply(points) - segment.start.apply(points)
        np.testing.assert_allclose(arc.chords(points, 3)[j], np.linalg.norm(way, axis=1))


def test_chords_of_a_quarter_turn() -> None:
    """A point at distance r from the axis moves along a chord of 2 r sin(angle / 2)."""
    turn = Tumble(np.zeros(3), np.array([0.0, 0, 1]), math.pi / 2)
    arc = Screw(Pose.from_yaw([0.0, 0.0, 0.0]), turn)
    lengths = arc.chords(np.array([[3.0, 0.0, 5.0], [0.0, 0.0, 1.0]]), 2)
    assert lengths == pytest.approx(np.array([[6 * math.sin(math.pi / 8), 0.0]] * 2))


@pytest.mark.parametrize("name", ["paper/regrasp", "random/chain/3", "planar/corner"])
def test_a_motions_arcs_are_its_poses(name: str) -> None:
    """Between neighbours either way, an arc passes the poses of the straight line between them."""
    problem = load(name).problem
    motion, lattice = problem.motion, problem.lattice
    for node in range(0, lattice.size, max(1, lattice.size // 40)):
        q = lattice.coordinates(node)
        for _, end in lattice.neighbours(node):
            arc, back = motion.arc(q, end), motion.arc(end, q)
            assert arc.key == back.key
            for t in (0.0, 0.3, 1.0):
                there = motion.pose(np.add(q, t * np.subtract(end, q)))
                np.testing.assert_allclose(arc.pose(t).position, there.position, atol=1e-10)
                np.testing.assert_allclose(arc.pose(t).rotation, there.rotation, atol=1e-10)
                np.testing.assert_allclose(
                    arc.twist(t).linear, -back.twist(1.0 - t).linear, atol=1e-10
                )


@pytest.mark.parametrize("name", ARCS)
def test_a_plan_file_keeps_an_arc(name: str) -> None:
    """What a step states gives back the same poses."""
    arc = ARCS[name]
    step = DisplacementStep(
        kind="displacement", from_=(0.0,), to=(1.0,), arc=arc_record(arc),
        pose_from=pose_record(arc.start), pose_to=pose_record(arc.end), placements=(),
        segments=(), cost=0.0,
    )  # fmt: skip
    read = DisplacementStep.model_validate_json(step.model_dump_json(by_alias=True))
    again = arc_of(read, load("paper/slide").problem)
    for t in (0.0, 0.4, 1.0):
        np.testing.assert_allclose(again.pose(t).position, arc.pose(t).position, atol=1e-12)
        np.testing.assert_allclose(again.pose(t).rotation, arc.pose(t).rotation, atol=1e-12)


def test_the_public_judge_takes_a_pose_and_a_twist() -> None:
    """Coordinates and direction, or pose and twist of any speed: one verdict; never both."""
    from gm_ompl import Twist, judge

    scenario = load("paper/slide", ["fingers.placements.grid=[2, 2]"])
    motion, hand = scenario.problem.motion, (("-x", (0, 0)), ("-x", (1, 0)))
    ours = judge(scenario, (0.3,), (1.0,), hand)
    pose, slow = motion.pose((0.3,)), Twist(np.array([0.01, 0, 0]), np.zeros(3))
    assert judge(scenario, placements=hand, pose=pose, twist=slow) == ours
    assert judge(scenario, placements=hand, pose=pose) == judge(scenario, (0.3,), None, hand)
    with pytest.raises(InputError, match="either q"):
        judge(scenario, (0.3,), placements=hand, twist=slow)
    with pytest.raises(InputError, match="either q"):
        judge(scenario, (0.3,), placements=hand, pose=pose)
    with pytest.raises(InputError, match="give twist"):
        judge(scenario, None, (1.0,), hand, pose=pose)
