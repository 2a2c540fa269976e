"""Rotations as matrices, how the object is turned at either end, and the yaw of that."""

from __future__ import annotations

import math

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.planar import FULL_TURN, UPRIGHT
from gm_ompl.scenario.fields import PoseModel, RotationModel
from gm_ompl.scenario.model import MotionModel

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
    if start.rotation is None:
        return rotation_about(UP, start.yaw)
    return rotation_matrix(start.rotation)


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


def goal_yaw(motion: MotionModel, goal: PoseModel) -> float:
    """Return the yaw that a planar motion ends with [rad]."""
    if goal.rotation is None:
        return goal.yaw
    turn = _turn(motion, goal)
    return _in_range(start_yaw(motion) + math.atan2(turn[1, 0], turn[0, 0]), motion)


def goal_tilt(motion: MotionModel, goal: PoseModel) -> float:
    """Return by what angle the goal is tilted against the start [rad]; 0: yaw alone differs."""
    if goal.rotation is None:
        return 0.0
    up = _turn(motion, goal)[:, 2]
    tilt = math.atan2(math.hypot(up[0], up[1]), up[2])
    return tilt if tilt > TILTED else 0.0


def _turn(motion: MotionModel, goal: PoseModel) -> Array:
    """Return the rotation from start to goal, world frame."""
    assert goal.rotation is not None
    turn: Array = rotation_matrix(goal.rotation) @ start_rotation(motion.start).T
    return turn


def _in_range(yaw: float, motion: MotionModel) -> float:
    """Return ``yaw``, whole turns added so that it is not below the motion's range."""
    low = motion.planar.yaw[0] if motion.planar is not None else -math.pi
    return low + (yaw - low + ROUNDING) % FULL_TURN - ROUNDING
