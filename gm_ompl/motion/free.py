"""Free motion: a start and a goal pose in SE(3), and what the object may do between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, fix, read_only
from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Arc, Motion

AXES = ("x", "y", "z")
"""Names of the world's axes."""

SHORTEST: Final = 1e-4
"""An arc on which no corner moves farther than this, relative to D, is none."""

SLACK: Final = 1e-6
"""How far the centre of mass may leave the region, relative to D."""


@dataclass(frozen=True, eq=False)
class PoseGoal:
    """Where the object must end.

    Attributes:
        low: (3,), least coordinates of the centre of mass.
        high: (3,), greatest; equal to ``low`` where one place is meant.
        rotation: (3, 3), how it must be turned, object to world; None where that is left open.
        up: (3,), unit, object frame: what must point up, the heading left open; None likewise.
        distance: how far from there the centre of mass may be.
        angle: by how much it may be turned from there [rad].
    """

    low: Array
    high: Array
    rotation: Array | None
    up: Array | None
    distance: float
    angle: float

    def __post_init__(self) -> None:
        fix(self, low=(3,), high=(3,))
        if self.rotation is not None:
            fix(self, rotation=(3, 3))
        if self.up is not None:
            fix(self, up=(3,))

    def position_error(self, pose: Pose) -> float:
        """Return the centre of mass's distance from where it must be."""
        nearest = np.minimum(np.maximum(pose.position, self.low), self.high)
        return float(np.linalg.norm(pose.position - nearest))

    def rotation_error(self, pose: Pose) -> float:
        """Return the least angle [rad] by which the object must still turn."""
        if self.rotation is not None:
            return angle_between(self.rotation, pose.rotation)
        if self.up is None:
            return 0.0
        x, y, z = (pose.rotation @ self.up).tolist()
        return math.atan2(math.hypot(x, y), z)

    def contains(self, pose: Pose) -> bool:
        """Whether the object has arrived."""
        near = self.position_error(pose) <= self.distance
        return near and self.rotation_error(pose) <= self.angle


def angle_between(a: Array, b: Array) -> float:
    """Return the angle [rad] of the rotation from ``a`` to ``b``, both (3, 3)."""
    turn = a.T @ b
    sine = math.hypot(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    return math.atan2(sine, float(np.trace(turn)) - 1.0)


@dataclass(frozen=True, eq=False)
class ContactSteps:
    """How the contact lattice divides free motion.

    Attributes:
        translation: the step of translations.
        rotation: the step of rotations [rad].
        translate: the listed world axes, 0 to 2.
        rotate: (k, 3), unit directions about which the object may turn, world frame; None: any.
        depth: at most so many arcs from the start, counted on geometry alone; None: no limit.
    """

    translation: float
    rotation: float
    translate: tuple[int, ...]
    rotate: Array | None
    depth: int | None

    def __post_init__(self) -> None:
        if self.rotate is not None:
            fix(self, rotate=(None, 3))


@final
class FreeMotion(Motion):
    """The object moves as its contacts and the fingers allow; a pose has no coordinates.

    Args:
        start: where it begins, contacts made exact.
        goal: where it must end.
        region: (2, 3), least and greatest coordinates of the centre of mass on the way.
        steps: of the contact lattice.
    """

    def __init__(self, start: Pose, goal: PoseGoal, region: Array, steps: ContactSteps) -> None:
        self.names = ()
        self.low = self.high = ()
        self.periods = ()
        self.breakpoints = ()
        self.start, self.goal, self.steps = start, goal, steps
        self.region = read_only(region, (2, 3), "region")

    def pose(self, q: Sequence[float] | Array) -> Pose:
        """Return the start: what no coordinates at all stand for.

        Raises:
            InputError: ``q`` has any.
        """
        if len(q):
            raise InputError("with free motion the object has no coordinates; give a pose")
        return self.start

    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:  # noqa: ARG002
        """Refuse: there are no coordinates to follow."""
        raise InputError("with free motion the object has no coordinates; give a pose and a twist")

    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Arc:  # noqa: ARG002
        """Refuse: no coordinates lie at an arc's ends."""
        raise InputError("with free motion arcs come from the contact lattice alone")
