"""Screws: translations, and turns about a line."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, cross, fix, unit
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.motion.arc import Arc


@dataclass(frozen=True, eq=False)
class Slide:
    """A translation at uniform speed.

    Attributes:
        by: (3,), the whole translation, world frame.
    """

    by: Array

    def __post_init__(self) -> None:
        fix(self, by=(3,))

    def pose(self, start: Pose, fraction: float) -> Pose:
        """Return the pose after ``fraction`` of the motion that began at ``start``."""
        return Pose(start.rotation, start.position + fraction * self.by)

    def velocity(self, pose: Pose, rate: float) -> Twist:  # noqa: ARG002 (both answer alike)
        """Return ``rate`` times the derivative with respect to the fraction, at ``pose``."""
        return Twist(rate * self.by, np.zeros(3))

    def sweep(self, start: Pose, share: float) -> Sweep:
        """Return the motion by ``share`` of the whole from ``start``."""
        return Sweep(start, start.position, UP, 0.0, share * self.by)


@dataclass(frozen=True, eq=False)
class Tumble:
    """A rotation at uniform speed about a line fixed in the world.

    Attributes:
        pivot: (3,), a point of the line, world frame.
        axis: (3,), unit, the line's direction.
        angle: the whole rotation about ``axis`` [rad].
    """

    pivot: Array
    axis: Array
    angle: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", unit(self.axis))
        fix(self, pivot=(3,), axis=(3,))

    def pose(self, start: Pose, fraction: float) -> Pose:
        """Return the pose after ``fraction`` of the motion that began at ``start``."""
        return start.turned(self.pivot, self.axis, fraction * self.angle)

    def velocity(self, pose: Pose, rate: float) -> Twist:
        """Return ``rate`` times the derivative with respect to the fraction, at ``pose``."""
        angular = rate * self.angle * self.axis
        return Twist(cross(angular, pose.position - self.pivot), angular)

    def sweep(self, start: Pose, share: float) -> Sweep:
        """Return the motion by ``share`` of the whole from ``start``."""
        return Sweep(start, self.pivot, self.axis, share * self.angle, np.zeros(3))


Piece: TypeAlias = Slide | Tumble

UP = np.array([0.0, 0.0, 1.0])


def remembered(known: dict[float, Pose], origin: Pose, whole: Piece, fraction: float) -> Pose:
    """Return the pose after a fraction of a motion; the latest are in ``known``."""
    if fraction == 0.0:
        return origin
    pose = known.get(fraction)
    if pose is None:
        pose = known[fraction] = whole.pose(origin, fraction)
    return pose


@final
@dataclass(frozen=True, eq=False)
class Screw(Arc):
    """Part of a translation or rotation.

    Attributes:
        origin: where the whole motion begins.
        whole: the whole motion.
        first: the fraction of it at t = 0.
        last: the fraction at t = 1.
        known: poses by their fraction, shared by the parts of one motion.
        pitch: how long a segment is, as ``Arc`` has it.
        ends: whether it is judged from end to end, likewise.
    """

    origin: Pose
    whole: Piece
    first: float = 0.0
    last: float = 1.0
    known: dict[float, Pose] = field(default_factory=dict)
    pitch: float | None = None
    ends: bool = False

    def pose(self, t: float) -> Pose:
        """Return the pose at ``t``."""
        fraction = self.last if t == 1.0 else self.first + t * (self.last - self.first)
        return remembered(self.known, self.origin, self.whole, fraction)

    def twist(self, t: float) -> Twist:
        """Return the derivative of the pose at ``t``."""
        if isinstance(self.whole, Slide):
            return self._drift
        return self.whole.velocity(self.pose(t), self.last - self.first)

    @cached_property
    def _drift(self) -> Twist:
        """The twist of a translation, everywhere."""
        return self.whole.velocity(self.origin, self.last - self.first)

    def chords(self, points: Array, parts: int) -> Array:
        """Return |dq_finger i,j| of Eq. (9) in closed form; see ``Arc.chords``."""
        shares = np.diff(self.bounds(parts)) * (self.last - self.first)
        if isinstance(self.whole, Slide):
            way = float(np.linalg.norm(self.whole.by))
            return np.repeat(np.abs(shares)[:, None] * way, len(points), axis=1)
        arms = self.start.apply(points) - self.whole.pivot
        arms -= np.outer(arms @ self.whole.axis, self.whole.axis)
        radii = np.sqrt(np.einsum("ij,ij->i", arms, arms))
        return np.outer(np.abs(2.0 * np.sin(shares * self.whole.angle / 2.0)), radii)

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        """The screw itself."""
        return (self.whole.sweep(self.start, self.last - self.first),)

    @property
    def key(self) -> Hashable:
        """Equal for screws between the same poses about the same line."""
        ends = frozenset((self.start.key, self.end.key))
        if isinstance(self.whole, Slide):
            return ends
        turn = abs((self.last - self.first) * self.whole.angle)
        return ends, self.whole.pivot.tobytes(), self.whole.axis.tobytes(), turn

    @property
    def piece(self) -> Piece:
        """The motion from t = 0 to 1 by itself."""
        share = self.last - self.first
        if isinstance(self.whole, Slide):
            return Slide(share * self.whole.by)
        return Tumble(self.whole.pivot, self.whole.axis, share * self.whole.angle)
