"""The simulated robot carries plans out; the export to ROS 2 is read back value for value."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.bag import write_bag
from gm_ompl.simulation.execute import execute, prepare
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import Pace

RATE = 20.0


def test_the_robot_does_it(pushed: Plan) -> None:
    """Object within 3 mm and 2 deg, torques within limits, no link but fingertips touches."""
    report = execute(prepare(pushed))
    assert report.holds, report.table()
    assert report.end_position <= 3e-3 and report.end_angle <= 2.0
    assert len(report.torque) == 9 and max(report.torque.values()) <= 1.0
    assert report.touching == ()


def read_back(folder: Path) -> dict[str, list[Any]]:
    """Messages by topic, in order."""
    reader = pytest.importorskip("mcap_ros2.reader")
    found: dict[str, list[Any]] = {}
    (file,) = folder.glob("*.mcap")
    for message in reader.read_ros2_messages(str(file)):
        found.setdefault(message.channel.topic, []).append(message.ros_msg)
    return found


def test_the_bag_holds_the_timeline(pushed: Plan, tmp_path: Path) -> None:
    """Joints, poses and wrenches are those of the timeline; names those of the URDF."""
    pytest.importorskip("rosbags")
    from gm_ompl.planfile.fit import problem_of

    problem = problem_of(pushed)
    assert problem.hand is not None and problem.hand.text is not None
    write_bag(pushed, tmp_path / "bag", rate=RATE)
    found = read_back(tmp_path / "bag")
    line = schedule(pushed, problem, Pace(), 1.0 / RATE)
    (joints,) = found["/joint_trajectory"]
    assert all(f'name="{name}"' in problem.hand.text for name in joints.joint_names)
    assert [list(point.positions) for point in joints.points] == line.joints.tolist()
    assert [list(point.velocities) for point in joints.points] == line.joint_speed.tolist()
    times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in joints.points]
    assert times == pytest.approx(line.time, abs=1e-9)
    assert (np.abs(line.joint_speed) <= problem.hand.speed).all()
    for i in range(3):
        poses, wrenches = found[f"/finger{i}/pose"], found[f"/finger{i}/wrench"]
        assert poses[0].header.frame_id == "world"
        points = [[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in poses]
        assert points == line.centre[:, i].tolist()
        share = line.force_share[:, i, None]
        force = share * line.f_com[:, i, None] * line.normal[:, i] + (1 - share) * line.lean[:, i]
        given = [[w.wrench.force.x, w.wrench.force.y, w.wrench.force.z] for w in wrenches]
        assert np.array(given) == pytest.approx(force, abs=1e-12)
    assert json.loads(found["/guards"][0].data)["torque_limits"][joints.joint_names[0]] == 0.36
    assert len(found["/tf"]) == len(line) and found["/modes"] and found["/markers"]
    (bodies,) = found["/multi_dof_trajectory"]
    assert bodies.joint_names == ["object", "fingertip0", "fingertip1", "fingertip2"]


def test_a_bag_needs_joint_paths_and_a_new_folder(pushed: Plan, tmp_path: Path) -> None:
    """Without a hand, and into a folder that exists, nothing is written."""
    with pytest.raises(InputError, match="no joint paths"):
        write_bag(pushed.model_copy(update={"hand": None}), tmp_path / "bag")
    with pytest.raises(InputError, match="exists already"):
        write_bag(pushed, tmp_path)
