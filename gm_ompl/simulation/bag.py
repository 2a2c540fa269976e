"""A plan over time as an MCAP rosbag2: the door to rosbags.

No standard message carries a pose and a wrench together, so each finger has two streams of equal
stamps, and ``/modes`` says which of them counts. Everything is in SI units, frames are named.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.geometry.pose import Pose
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.simulation.export import instant_mode
from gm_ompl.simulation.play import DAMPING, STIFFNESS
from gm_ompl.simulation.schedule import schedule
from gm_ompl.simulation.timeline import PHASES, Pace, Timeline

WORLD: Final = "world"
OBJECT: Final = "object"
SECOND: Final = 1_000_000_000  # [ns]
VERSION: Final = 9  # of rosbag2's metadata: Jazzy's

GUARDS: Final = {"contact_made": 0.02, "contact_lost": 0.25, "abort": 1.5}
"""Force that says that a finger has touched, over the object's weight; below which share of f_com
it has lost contact; beyond which share of f_max to stop."""


def write_bag(plan: Plan, folder: Path, pace: Pace | None = None, rate: float = 100.0) -> None:
    """Write a plan with joint paths as a rosbag2 in ``folder``, which must not exist.

    Args:
        plan: with a hand.
        folder: of the bag.
        pace: how fast; the usual one where None.
        rate: messages per second.

    Raises:
        InputError: there is no hand, nothing moves, or the folder exists.
        MissingExtraError: rosbags is not installed.
    """
    if plan.hand is None:
        raise InputError(
            "--to ros2: the plan has no joint paths; add hand: to its scenario and plan again, or "
            "write fingertips alone with --to csv"
        )
    if not (np.isfinite(rate) and 1.0 <= rate <= 10000.0):
        raise InputError(f"--rate {rate}: must be from 1 to 10000 rows per second")
    if folder.exists():
        raise InputError(f"-o {folder}: exists already; name a new folder")
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ModuleNotFoundError as error:
        raise MissingExtraError("rosbags", "ros2") from error
    problem = problem_of(plan)
    line = schedule(plan, problem, pace or Pace(), 1.0 / rate)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(folder, version=VERSION, storage_plugin=StoragePlugin.MCAP) as bag:
        topics: dict[str, Any] = {}
        for stamp, topic, message in _Messages(store, problem, line).all():
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = bag.add_connection(topic, kind, typestore=store)
            bag.write(topics[topic], stamp, store.serialize_cdr(message, kind))


class _Messages:
    """Makes the messages of a timeline."""

    def __init__(self, store: Any, problem: Problem, line: Timeline) -> None:
        assert problem.hand is not None
        self._types, self._problem, self._line, self._hand = (
            store.types,
            problem,
            line,
            problem.hand,
        )
        self._tips = [f"fingertip{i}" for i in range(line.fingers)]
        self._turns = [Pose(R, p).quaternion() for R, p in zip(line.rotation, line.position)]  # noqa: B905

    def all(self) -> Iterator[tuple[int, str, Any]]:
        """Yield stamps [ns], topics and messages in order of time."""
        yield 0, "/joint_trajectory", self._joints()
        yield 0, "/multi_dof_trajectory", self._bodies()
        yield 0, "/guards", self._make("std_msgs/msg/String", data=json.dumps(self._guards()))
        last = ""
        for k in range(len(self._line)):
            stamp = round(self._line.time[k] * SECOND)
            for i in range(self._line.fingers):
                yield stamp, f"/finger{i}/pose", self._pose(k, i)
                yield stamp, f"/finger{i}/wrench", self._wrench(k, i)
            yield stamp, "/tf", self._frames(k)
            modes = json.dumps(self._modes(k))
            if modes != last:
                yield stamp, "/modes", self._make("std_msgs/msg/String", data=modes)
                yield stamp, "/markers", self._markers(k)
            last = modes

    def _make(self, kind: str, **values: Any) -> Any:
        return self._types[kind](**values)

    def _time(self, k: int) -> dict[str, int]:
        seconds, rest = divmod(round(self._line.time[k] * SECOND), SECOND)
        return {"sec": seconds, "nanosec": rest}

    def _header(self, k: int, frame: str = WORLD) -> Any:
        stamp = self._make("builtin_interfaces/msg/Time", **self._time(k))
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def _after(self, k: int) -> Any:
        return self._make("builtin_interfaces/msg/Duration", **self._time(k))

    def _joints(self) -> Any:
        line, nothing = self._line, np.zeros(0)
        points = [
            self._make(
                "trajectory_msgs/msg/JointTrajectoryPoint", positions=line.joints[k],
                velocities=line.joint_speed[k], accelerations=nothing, effort=nothing,
                time_from_start=self._after(k),
            )
            for k in range(len(line))
        ]  # fmt: skip
        return self._make(
            "trajectory_msgs/msg/JointTrajectory", header=self._header(0),
            joint_names=list(self._hand.joints), points=points,
        )  # fmt: skip

    def _bodies(self) -> Any:
        points = []
        for k in range(len(self._line)):
            places = [self._line.position[k], *self._line.centre[k]]
            points.append(
                self._make(
                    "trajectory_msgs/msg/MultiDOFJointTrajectoryPoint",
                    transforms=[self._transform(k, place) for place in places],
                    velocities=[],
                    accelerations=[],
                    time_from_start=self._after(k),
                )
            )
        return self._make(
            "trajectory_msgs/msg/MultiDOFJointTrajectory", header=self._header(0),
            joint_names=[OBJECT, *self._tips], points=points,
        )  # fmt: skip

    def _vector(self, xyz: Array, kind: str = "Vector3") -> Any:
        x, y, z = (float(value) for value in xyz)
        return self._make(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)

    def _turn(self, k: int) -> Any:
        w, x, y, z = self._turns[k].tolist()
        return self._make("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def _transform(self, k: int, place: Array) -> Any:
        return self._make(
            "geometry_msgs/msg/Transform", translation=self._vector(place), rotation=self._turn(k)
        )

    def _at(self, k: int, place: Array) -> Any:
        return self._make(
            "geometry_msgs/msg/Pose",
            position=self._vector(place, "Point"), orientation=self._turn(k),
        )  # fmt: skip

    def _pose(self, k: int, i: int) -> Any:
        """Return where a fingertip's centre is to be."""
        return self._make(
            "geometry_msgs/msg/PoseStamped",
            header=self._header(k), pose=self._at(k, self._line.centre[k, i]),
        )  # fmt: skip

    def _wrench(self, k: int, i: int) -> Any:
        """Return the force of a fingertip on the object: commanded, or what it leans with."""
        line = self._line
        share = line.force_share[k, i]
        force = (1.0 - share) * line.lean[k, i] + share * line.f_com[k, i] * line.normal[k, i]
        wrench = self._make(
            "geometry_msgs/msg/Wrench",
            force=self._vector(force), torque=self._vector(np.zeros(3)),
        )  # fmt: skip
        return self._make("geometry_msgs/msg/WrenchStamped", header=self._header(k), wrench=wrench)

    def _frames(self, k: int) -> Any:
        line = self._line
        children = zip([OBJECT, *self._tips], [line.position[k], *line.centre[k]], strict=True)
        transforms = [
            self._make(
                "geometry_msgs/msg/TransformStamped", header=self._header(k),
                child_frame_id=name, transform=self._transform(k, place),
            )
            for name, place in children
        ]  # fmt: skip
        return self._make("tf2_msgs/msg/TFMessage", transforms=transforms)

    def _modes(self, k: int) -> dict[str, Any]:
        line = self._line
        fingers = [instant_mode(line, k, i) for i in range(line.fingers)]
        return {"phase": PHASES[line.phase[k]], "step": int(line.step[k]), "fingers": fingers}

    def _guards(self) -> dict[str, Any]:
        """Return stiffness, damping and thresholds for a controller, SI units."""
        weight, most = self._problem.force_scale, self._problem.fingers.max_normal_force
        return {
            "stiffness": STIFFNESS, "damping": DAMPING,
            "contact_made": GUARDS["contact_made"] * weight,
            "contact_lost_share_of_f_com": GUARDS["contact_lost"],
            "abort_above": (GUARDS["abort"] * most).tolist(),
            "torque_limits": dict(zip(self._hand.joints, self._hand.torque.tolist(), strict=True)),
        }  # fmt: skip

    def _markers(self, k: int) -> Any:
        """Return a sphere per fingertip: red under force control, blue under position control."""
        made = [self._marker(k, i) for i in range(self._line.fingers)]
        return self._make("visualization_msgs/msg/MarkerArray", markers=made)

    def _marker(self, k: int, i: int) -> Any:
        share, width = float(self._line.force_share[k, i]), 2.0 * self._problem.fingers.radius[i]
        nothing = self._make("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
        kind = self._types["visualization_msgs/msg/Marker"]
        picture = self._make(
            "sensor_msgs/msg/CompressedImage", header=self._header(k), format="",
            data=np.zeros(0, dtype=np.uint8),
        )  # fmt: skip
        return kind(
            header=self._header(k), ns="fingertips", id=i, type=kind.SPHERE, action=kind.ADD,
            pose=self._at(k, self._line.centre[k, i]), scale=self._vector(np.full(3, width)),
            color=self._make("std_msgs/msg/ColorRGBA", r=share, g=0.2, b=1.0 - share, a=1.0),
            lifetime=nothing, frame_locked=False, points=[], colors=[], texture_resource="",
            texture=picture, uv_coordinates=[], text="", mesh_resource="",
            mesh_file=self._make(
                "visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, dtype=np.uint8)
            ),
            mesh_use_embedded_materials=False,
        )  # fmt: skip
