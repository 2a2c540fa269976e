"""The simulated robot carries plans out; the export to ROS 2 is read back value for value."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest

from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.spec import HandSpec
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.bag import write_bag
from gm_ompl.simulation.execute import execute, prepare
from gm_ompl.simulation.export import instant_mode
from gm_ompl.simulation.hand_ways import RISE, ROUNDING, SPEED, HandWays
from gm_ompl.simulation.play import DAMPING, STIFFNESS
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline

RATE = 20.0


def test_the_robot_does_it(pushed: Plan) -> None:
    """Object within 3 mm and 2 deg, torques within limits, no link but fingertips touches."""
    report = execute(prepare(pushed))
    assert report.holds, report.table()
    assert report.end_position <= 3e-3 and report.end_angle <= 2.0
    assert len(report.torque) == 9 and max(report.torque.values()) <= 1.0
    assert report.touching == ()


def test_hinges_turn_smoothly_through_the_air(pushed: Plan) -> None:
    """Ways begin and end as planned; where one bends by 10 deg, no hinge's rate jumps."""
    problem = problem_of(pushed)
    assert problem.hand is not None and pushed.hand is not None
    rows = np.repeat([pushed.hand.retreat[-1]], 3, axis=0)
    rows[1:, 0] += 0.3
    rows[2, :2] += 0.3 * np.cos(np.radians(10.0)), 0.3 * np.sin(np.radians(10.0))
    record = pushed.hand.model_copy(update={"retreat": rows.tolist()})
    for dt in (5e-4, 2e-3, 0.2):
        joints = HandWays(record, problem, dt).retreat().joints
        assert np.abs(joints[[0, -1]] - rows[[0, -1]]).max() <= 1e-9
        jumps = np.abs(np.diff(joints, n=2, axis=0)) / dt
        least = SPEED * problem.hand.speed * (dt / ROUNDING + dt / RISE)
        assert (jumps <= 1.01 * least).all() or dt > ROUNDING


def read_back(folder: Path) -> dict[str, list[Any]]:
    """Messages by topic, in order."""
    reader = pytest.importorskip("mcap_ros2.reader")
    found: dict[str, list[Any]] = {}
    (file,) = folder.glob("*.mcap")
    for message in reader.read_ros2_messages(str(file)):
        found.setdefault(message.channel.topic, []).append(message.ros_msg)
    return found


class Bag(NamedTuple):
    """A bag as read back, beside the timeline that it was written from."""

    topics: dict[str, list[Any]]
    line: Timeline
    hand: HandSpec
    weight: float
    f_max: list[float]


@pytest.fixture(scope="module")
def bag(pushed: Plan, tmp_path_factory: pytest.TempPathFactory) -> Bag:
    pytest.importorskip("rosbags")
    problem = problem_of(pushed)
    assert problem.hand is not None
    folder = tmp_path_factory.mktemp("bag") / "bag"
    write_bag(pushed, folder, rate=RATE)
    line = schedule(pushed, problem, Pace(), 1.0 / RATE)
    f_max = problem.fingers.max_normal_force.tolist()
    return Bag(read_back(folder), line, problem.hand, problem.force_scale, f_max)


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def wxyz(turn: Any) -> list[float]:
    return [turn.w, turn.x, turn.y, turn.z]


def seconds(time: Any, line: Timeline) -> int:
    """The instant of the timeline that a stamp or a duration is, to the nanosecond."""
    at = time.sec + 1e-9 * time.nanosec
    k: int = round(at / line.dt) - round(float(line.time[0]) / line.dt)
    assert at == pytest.approx(line.time[k], abs=1e-9)
    return k


def turns(line: Timeline) -> list[list[float]]:
    poses = zip(line.rotation, line.position, strict=True)
    return [Pose(R, p).quaternion().tolist() for R, p in poses]


def test_every_topic_is_there_and_no_other(bag: Bag) -> None:
    """Joints, bodies, poses and wrenches per finger, frames, markers, modes, guards."""
    fingers = [f"/finger{i}/{what}" for i in range(3) for what in ("pose", "wrench")]
    once = ["/joint_trajectory", "/multi_dof_trajectory", "/guards"]
    assert set(bag.topics) == {*fingers, *once, "/tf", "/modes", "/markers"}
    for topic in (*fingers, "/tf"):
        assert len(bag.topics[topic]) == len(bag.line), topic
    assert [len(bag.topics[topic]) for topic in once] == [1, 1, 1]


def test_joints_are_the_urdf_s_within_their_speeds(bag: Bag) -> None:
    """Names as in the URDF, in its order; angles, rates and times of the timeline."""
    assert bag.hand.text is not None
    urdf = ElementTree.fromstring(bag.hand.text)
    names = [j.get("name") for j in urdf.iter("joint") if j.get("type") == "revolute"]
    (joints,) = bag.topics["/joint_trajectory"]
    assert sorted(joints.joint_names) == sorted(map(str, names))
    assert tuple(joints.joint_names) == bag.hand.joints
    assert joints.header.frame_id == "world"
    assert [list(p.positions) for p in joints.points] == bag.line.joints.tolist()
    assert [list(p.velocities) for p in joints.points] == bag.line.joint_speed.tolist()
    whole = list(range(len(bag.line)))
    assert [seconds(p.time_from_start, bag.line) for p in joints.points] == whole
    assert (np.abs(bag.line.joint_speed) <= bag.hand.speed).all()


def test_bodies_and_frames_are_the_timeline_s(bag: Bag) -> None:
    """MultiDOFJointTrajectory and TF: object and fingertips, every number."""
    line, quaternions = bag.line, turns(bag.line)
    names = ["object", "fingertip0", "fingertip1", "fingertip2"]
    (bodies,) = bag.topics["/multi_dof_trajectory"]
    assert bodies.joint_names == names and bodies.header.frame_id == "world"
    for k, (point, frames) in enumerate(zip(bodies.points, bag.topics["/tf"], strict=True)):
        places = [line.position[k].tolist(), *line.centre[k].tolist()]
        assert seconds(point.time_from_start, line) == k
        assert [xyz(t.translation) for t in point.transforms] == places
        assert [wxyz(t.rotation) for t in point.transforms] == [quaternions[k]] * 4
        assert [t.child_frame_id for t in frames.transforms] == names
        assert {t.header.frame_id for t in frames.transforms} == {"world"}
        assert {seconds(t.header.stamp, line) for t in frames.transforms} == {k}
        assert [xyz(t.transform.translation) for t in frames.transforms] == places
        assert [wxyz(t.transform.rotation) for t in frames.transforms] == [quaternions[k]] * 4


@pytest.mark.parametrize("i", range(3))
def test_poses_and_wrenches_are_the_timeline_s(bag: Bag, i: int) -> None:
    """Per finger two streams of equal stamps, every number."""
    line, quaternions = bag.line, turns(bag.line)
    share = line.force_share[:, i, None]
    force = share * line.f_com[:, i, None] * line.normal[:, i] + (1 - share) * line.lean[:, i]
    streams = zip(bag.topics[f"/finger{i}/pose"], bag.topics[f"/finger{i}/wrench"], strict=True)
    for k, (pose, wrench) in enumerate(streams):
        for message in (pose, wrench):
            assert message.header.frame_id == "world" and seconds(message.header.stamp, line) == k
        assert xyz(pose.pose.position) == line.centre[k, i].tolist()
        assert wxyz(pose.pose.orientation) == quaternions[k]
        assert xyz(wrench.wrench.force) == pytest.approx(force[k], abs=1e-12)
        assert xyz(wrench.wrench.torque) == [0.0, 0.0, 0.0]


def test_modes_and_markers_tell_every_change(bag: Bag) -> None:
    """A message where phase, step or a mode changes; spheres where the fingertips are."""
    line, told = bag.line, list[tuple[int, dict[str, Any]]]()
    for k in range(len(line)):
        fingers = [instant_mode(line, k, i) for i in range(3)]
        modes = {"phase": PHASES[line.phase[k]], "step": int(line.step[k]), "fingers": fingers}
        if not told or told[-1][1] != modes:
            told.append((k, modes))
    assert [json.loads(message.data) for message in bag.topics["/modes"]] == [m for _, m in told]
    for (k, _), spheres in zip(told, bag.topics["/markers"], strict=True):
        for i, marker in enumerate(spheres.markers):
            assert seconds(marker.header.stamp, line) == k
            assert (marker.header.frame_id, marker.ns, marker.id) == ("world", "fingertips", i)
            assert (marker.type, marker.action) == (2, 0)  # a sphere, added
            assert xyz(marker.pose.position) == line.centre[k, i].tolist()
            assert xyz(marker.scale) == [0.02, 0.02, 0.02]
            share = float(np.float32(line.force_share[k, i]))
            assert (marker.color.r, marker.color.a) == (share, 1.0)


def test_guards_are_in_si_units(bag: Bag) -> None:
    """Stiffness, damping, thresholds of forces, and the motors' torques by joint."""
    (message,) = bag.topics["/guards"]
    assert json.loads(message.data) == {
        "stiffness": STIFFNESS,
        "damping": DAMPING,
        "contact_made": 0.02 * bag.weight,
        "contact_lost_share_of_f_com": 0.25,
        "abort_above": [1.5 * f for f in bag.f_max],
        "torque_limits": dict.fromkeys(bag.hand.joints, 0.36),
    }


def test_a_bag_needs_joint_paths_and_a_new_folder(pushed: Plan, tmp_path: Path) -> None:
    """Without a hand, and into a folder that exists, nothing is written."""
    with pytest.raises(InputError, match="no joint paths"):
        write_bag(pushed.model_copy(update={"hand": None}), tmp_path / "bag")
    with pytest.raises(InputError, match="exists already"):
        write_bag(pushed, tmp_path)
