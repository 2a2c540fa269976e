"""The object's motion, start and goal, made from the checked values; rotations as matrices."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.projection import UPRIGHT_WAYS
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.arc import Motion
from gm_ompl.motion.lattice import Coordinates, Goal
from gm_ompl.motion.path import PathMotion, tumble_towards
from gm_ompl.motion.planar import FULL_TURN, UPRIGHT, PlanarMotion, heading
from gm_ompl.motion.screw import Piece, Slide
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import REST, Located, PoseModel, RotationModel
from gm_ompl.scenario.goals import ANY, GoalModel, RegionModel, turn_of
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import MotionModel, ScenarioModel
from gm_ompl.scenario.standing import Ground

ROUNDING = 1e-12
"""What multiplying rotations may leave of one that should be none."""

TILTED = 1e-6
"""Start and goal that are tilted against each other by less than this [rad] have one tilt."""

UP = np.array([0.0, 0.0, 1.0])


def rotation_matrix(rotation: RotationModel) -> Array:
    """Return the rotation as a matrix (3, 3); quarter turns about the axes are exact."""
    if rotation.quaternion is not None:
        quaternion = np.array(rotation.quaternion) / np.abs(rotation.quaternion).max()
    else:
        axis, angle = (
            np.array(rotation.axis or (0.0, 0.0, 1.0)),
            rotation.yaw or rotation.angle or 0.0,
        )
        axis = axis / np.abs(axis).max()
        vector = np.sin(angle / 2) * axis / np.linalg.norm(axis)
        quaternion = np.array([np.cos(angle / 2), *vector])
    matrix = Pose.from_quaternion(np.zeros(3), quaternion).rotation
    whole = np.round(matrix)
    exact: Array = np.where(np.abs(matrix - whole) < 1e-15, whole, matrix) + 0.0
    return exact


def start_rotation(start: PoseModel) -> Array:
    """Return how the object is turned at the start, (3, 3), object to world."""
    return turned(start.rotation, start.yaw)


def turned(rotation: RotationModel | None, yaw: float) -> Array:
    """Return ``rotation`` as a matrix (3, 3); without one, the turn by ``yaw`` [rad]."""
    return rotation_about(UP, yaw) if rotation is None else rotation_matrix(rotation)


def start_yaw(motion: MotionModel) -> float:
    """Return the yaw that a planar motion starts with [rad].

    That of a rotation is its twist about the vertical: any rotation is a tilt about a level axis,
    and a yaw after it.
    """
    start = motion.start
    if start.rotation is None:
        return start.yaw
    if start.rotation.yaw is not None:
        return start.rotation.yaw
    w, _, _, z = Pose(rotation_matrix(start.rotation), np.zeros(3)).quaternion().tolist()
    return _in_range(2.0 * math.atan2(z, w), motion)


def start_attitude(motion: MotionModel) -> Array:
    """Return how the object of a planar motion is turned at yaw 0, (3, 3)."""
    if motion.start.rotation is None:
        return UPRIGHT
    return attitude_of(start_rotation(motion.start), start_yaw(motion))


def attitude_of(rotation: Array, yaw: float) -> Array:
    """Return what is left of ``rotation`` (3, 3) without the yaw [rad] that comes after it."""
    attitude: Array = rotation_about(UP, -yaw) @ rotation
    return UPRIGHT if np.abs(attitude - UPRIGHT).max() <= ROUNDING else attitude


def goal_yaw(motion: MotionModel, goal: GoalModel) -> float:
    """Return the yaw that a planar motion ends with [rad]."""
    rotation = turn_of(goal)
    if rotation is None:
        return goal.yaw or 0.0
    turn = _turn(motion, rotation)
    return _in_range(start_yaw(motion) + math.atan2(turn[1, 0], turn[0, 0]), motion)


def goal_tilt(motion: MotionModel, goal: GoalModel) -> float:
    """Return by what angle the goal is tilted against the start [rad]; 0: yaw alone differs."""
    rotation = turn_of(goal)
    if rotation is None:
        return 0.0
    up = _turn(motion, rotation)[:, 2]
    tilt = math.atan2(math.hypot(up[0], up[1]), up[2])
    return tilt if tilt > TILTED else 0.0


def _turn(motion: MotionModel, goal: RotationModel) -> Array:
    """Return the rotation from start to goal, world frame."""
    turn: Array = rotation_matrix(goal) @ start_rotation(motion.start).T
    return turn


def _in_range(yaw: float, motion: MotionModel) -> float:
    """Return ``yaw``, whole turns added so that it is not below the motion's range."""
    low = motion.planar.yaw[0] if motion.planar is not None else -math.pi
    return low + (yaw - low + ROUNDING) % FULL_TURN - ROUNDING


TOWARDS = {
    "+x": np.array([1.0, 0.0, 0.0]),
    "-x": np.array([-1.0, 0.0, 0.0]),
    "+y": np.array([0.0, 1.0, 0.0]),
    "-y": np.array([0.0, -1.0, 0.0]),
}
"""The directions a tumble may take, world frame."""

END = Goal((1.0,), (1.0,), (None,))
"""Where a path ends."""

HEIGHT: Path = ("position", 2)

AnyLocated = TypeVar("AnyLocated", bound=Located)


class Moving(NamedTuple):
    """How the object moves.

    Attributes:
        motion: its degrees of freedom.
        start: coordinates of the start.
        goal: where it must end.
        model: the scenario's values, heights that were to be found filled in.
    """

    motion: Motion
    start: Coordinates
    goal: Goal
    model: MotionModel


def make_motion(scenario: ScenarioModel, ground: Ground, notes: Notes) -> Moving | None:
    """Return the motion, or None after noting what is wrong with it."""
    model = scenario.motion
    start = with_height(model.start, start_rotation(model.start), "start", ground, notes)
    if start.height is None:
        return None
    model = model.model_copy(update={"start": start})
    if model.planar is not None:
        return _planar(model, ground, notes)
    return _path(model, ground, notes)


def with_height(
    part: AnyLocated, rotation: Array, key: str, ground: Ground, notes: Notes
) -> AnyLocated:
    """Return a start or goal with its height, where that was to be found.

    Args:
        part: the start or goal.
        rotation: (3, 3), how the object is turned there, object to world.
        key: which of the two it is.
        ground: what the object can stand on.
        notes: grows where there is nothing below.
    """
    if part.height is not None:
        return part
    path = ("motion", key, *HEIGHT)
    z = notes.attempt(path, lambda: ground.height(rotation, part.xy))
    return part if z is None else part.model_copy(update={"position": (*part.xy, z)})


def _path(model: MotionModel, ground: Ground, notes: Notes) -> Moving | None:
    start = model.start
    position = np.array([*start.xy, start.height])
    first = ground.exact(Pose(start_rotation(start), position))
    pieces: list[Piece] = []
    pose, touching = first, ground.environment.contact_tolerance
    for i, piece in enumerate(model.path or ()):
        if piece.slide is not None:
            made: Piece | None = Slide(np.array(piece.slide.by))
        else:
            path = ("motion", "path", i, "tumble", "towards")
            tumble = piece.tumble
            assert tumble is not None
            made = notes.attempt(
                path,
                lambda tumble=tumble, pose=pose: tumble_towards(  # type: ignore[misc]
                    ground.body, pose, TOWARDS[tumble.towards], tumble.angle, touching
                ),
            )
        if made is None:
            return None
        pieces.append(made)
        pose = made.pose(pose, 1.0)
    ground.look("start", ("motion", "start"), first)
    if not ground.warnings:  # else the goal is as wrong as the start, and for its reason
        ground.look("goal", ("motion", "path"), pose)
    return Moving(PathMotion(first, pieces), (0.0,), END, model)


def _planar(model: MotionModel, ground: Ground, notes: Notes) -> Moving | None:
    planar = model.planar
    assert planar is not None
    (x, y), yaw, attitude = model.start.xy, start_yaw(model), start_attitude(model)
    given = heading([x, y, float(model.start.height or 0.0)], yaw, attitude)
    first = ground.exact(given, UPRIGHT_WAYS)
    if first is not given:
        attitude = attitude_of(first.rotation, yaw)
    ranges = (planar.x, planar.y, planar.yaw)
    low, high = [least for least, _ in ranges], [most for _, most in ranges]
    motion = PlanarMotion(low, high, float(first.position[2]), attitude)
    ground.look("start", ("motion", "start"), first)
    start = motion.wrap((x, y, yaw))
    last = model.goal
    if isinstance(last, RegionModel):
        filled = last.model_copy(update={"yaw": ANY if last.yaw is None else last.yaw})
        model = model.model_copy(update={"goal": filled})
        return Moving(motion, start, _region(filled, motion), model)
    assert last is not None
    yaw = goal_yaw(model, last)
    rotation = rotation_about(UP, yaw - start_yaw(model)) @ start_rotation(model.start)
    found = with_height(last, rotation, "goal", ground, notes)
    _level(found, last, motion.height, ground, notes)
    point = motion.wrap((*last.xy, yaw))
    if not ground.warnings:
        ground.look("goal", ("motion", "goal"), motion.pose(point))
    found = found.model_copy(update={"yaw": last.yaw or 0.0})
    model = model.model_copy(update={"goal": found})
    return Moving(motion, start, Goal(point, point, motion.periods), model)


def _level(goal: GoalModel, given: GoalModel, height: float, ground: Ground, notes: Notes) -> None:
    """Note a goal that is not as high as the start."""
    z = goal.height
    if z is None or abs(z - height) <= ground.environment.contact_tolerance * ground.body.diagonal:
        return
    path = ("motion", "goal", *HEIGHT)
    if given.height is None:
        wanted = f"finds {z!r}, but the start's height is {height!r}: the motion is planar"
        notes.wrong(path, REST, wanted)
    else:
        wanted = f"must equal the start's height {height!r}: the motion is planar"
        notes.wrong(path, z, wanted)


def _region(last: RegionModel, motion: PlanarMotion) -> Goal:
    assert last.x is not None
    assert last.y is not None
    low: list[float | None] = [last.x[0], last.y[0], None]
    high: list[float | None] = [last.x[1], last.y[1], None]
    if isinstance(last.yaw, tuple) and last.yaw[1] - last.yaw[0] < FULL_TURN * (1 - 1e-9):
        low[2], high[2] = last.yaw
    return Goal(tuple(low), tuple(high), motion.periods)
