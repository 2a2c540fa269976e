"""Arcs: the one thing that moves an object; and motions, which make them from coordinates.

Whatever judges, plays or draws a displacement asks its arc: midpoints, velocities and the ways of
fingertips are computed here and nowhere else.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.sweep import Sweep


@dataclass(frozen=True, eq=False)
class Moment:
    """One instant of the object: what a judge is asked with.

    Attributes:
        pose: where it is.
        twist: how it moves; None at rest.
    """

    pose: Pose
    twist: Twist | None = None

    @property
    def key(self) -> Hashable:
        """Equal where pose and direction of motion are: then the mechanics is the same."""
        return self.pose.key, None if self.twist is None else self.twist.direction


@dataclass(frozen=True, eq=False)
class Segment:
    """One of the parts into which an arc is divided (Sec. 4.2).

    Attributes:
        arc: the whole.
        first: t where the segment begins.
        last: t where it ends.
        at: t where it is judged.
    """

    arc: Arc
    first: float
    last: float
    at: float

    def pose(self, share: float) -> Pose:
        """Return the pose after ``share`` of the segment."""
        return self.arc.pose(self.first + share * (self.last - self.first))

    @property
    def share(self) -> float:
        """How much of it is passed where it is judged."""
        return (self.at - self.first) / (self.last - self.first)

    @cached_property
    def start(self) -> Pose:
        """The pose where it begins."""
        return self.arc.pose(self.first)

    @cached_property
    def end(self) -> Pose:
        """The pose where it ends."""
        return self.arc.pose(self.last)

    @cached_property
    def middle(self) -> Moment:
        """The instant at which it is judged."""
        return self.arc.moment(self.at)


INSIDE: Final = 2.0**-7
"""How far from its ends, in t, an arc is judged that is judged there: at the end itself a face may
have come down."""


class Arc(ABC):
    """The object's motion from one pose to another while t runs from 0 to 1."""

    @abstractmethod
    def pose(self, t: float) -> Pose:
        """Return the pose at ``t``."""

    @abstractmethod
    def twist(self, t: float) -> Twist:
        """Return the derivative of the pose with respect to t, at ``t``."""

    @property
    @abstractmethod
    def sweeps(self) -> tuple[Sweep, ...]:
        """The arc as turns and drifts, one after the other."""

    @property
    @abstractmethod
    def key(self) -> Hashable:
        """Equal for arcs that pass the same poses, whichever way: a memo's key."""

    @cached_property
    def start(self) -> Pose:
        """The pose at t = 0."""
        return self.pose(0.0)

    @cached_property
    def end(self) -> Pose:
        """The pose at t = 1."""
        return self.pose(1.0)

    def moment(self, t: float) -> Moment:
        """Return the instant at ``t``, in motion."""
        return Moment(self.pose(t), self.twist(t))

    @property
    def pitch(self) -> float | None:
        """How long a segment is, in t; the last one may be shorter. None: all are equal."""
        return None

    @property
    def ends(self) -> bool:
        """Whether it is judged from end to end, at even distances, and not in equal segments."""
        return False

    def bounds(self, parts: int) -> list[float]:
        """Return the t at which its segments begin and end, one more than ``parts``."""
        if self.ends:
            return [0.0, *((j + 0.5) / (parts - 1) for j in range(parts - 1)), 1.0]
        if self.pitch is None:
            return [j / parts for j in range(parts + 1)]
        return [*(j * self.pitch for j in range(parts)), 1.0]

    def segments(self, parts: int) -> tuple[Segment, ...]:
        """Return the arc's parts, in order."""
        cuts, looks = self.bounds(parts), self.looks(parts)
        return tuple(Segment(self, cuts[j], cuts[j + 1], looks[j]) for j in range(parts))

    def middles(self, parts: int) -> tuple[Moment, ...]:
        """Return the instants at which the segments are judged."""
        return tuple(self._middles(parts))

    def _middles(self, parts: int) -> Iterator[Moment]:
        for j, t in enumerate(self.looks(parts)):
            if j % 256 == 255:
                limits.check()
            yield self.moment(t)

    def looks(self, parts: int) -> list[float]:
        """Return the t at which the segments are judged."""
        if self.ends:
            return [min(max(j / (parts - 1), INSIDE), 1.0 - INSIDE) for j in range(parts)]
        if self.pitch is None:  # equal on the way back, in every bit
            return [(2 * j + 1) / (2 * parts) for j in range(parts)]
        cuts = self.bounds(parts)
        return [(a + b) / 2.0 for a, b in itertools.pairwise(cuts)]

    def cuts(self, parts: int) -> tuple[Pose, ...]:
        """Return the poses at the segments' ends, one more than ``parts``."""
        return (self.start, *(self.pose(t) for t in self.bounds(parts)[1:-1]), self.end)

    def chords(self, points: Array, parts: int) -> Array:
        """Return |dq_finger i,j| of Eq. (9): straight ways of ``points``, (parts, m).

        Args:
            points: (m, 3), fingertip centres, object frame.
            parts: number of segments.
        """
        world = np.stack([pose.apply(points) for pose in self.cuts(parts)])
        lengths: Array = np.linalg.norm(np.diff(world, axis=0), axis=2)
        return lengths


POSE_BYTES = 2000
"""About what a pose takes; the same few are asked for again and again, and kept."""


class Motion(ABC):
    """The object's degrees of freedom.

    Attributes:
        names: one name per coordinate ("s", or "x", "y", "yaw").
        low: (d,), least value of each coordinate.
        high: (d,), greatest value of each coordinate.
        periods: (d,), the period of a coordinate that wraps, else None.
        breakpoints: per coordinate, the values where pieces meet; no arc spans one.
        ends: whether its arcs are judged from end to end, as ``Arc`` has it.
    """

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    periods: tuple[float | None, ...]
    breakpoints: tuple[tuple[float, ...], ...]
    ends: bool = False

    @property
    def fewest(self) -> int:
        """How many segments an arc has at least."""
        return 2 if self.ends else 1

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.names)

    @property
    def extents(self) -> tuple[float, ...]:
        """Each coordinate's range: its period where it wraps."""
        return tuple(
            period or (high - low) or 1.0
            for low, high, period in zip(self.low, self.high, self.periods, strict=True)
        )

    @abstractmethod
    def pose(self, q: Sequence[float] | Array) -> Pose:
        """Return the object's pose at coordinates ``q`` (d,)."""

    @abstractmethod
    def velocity(self, q: Sequence[float] | Array, dq: Sequence[float] | Array) -> Twist:
        """Return the derivative of the pose at ``q`` in the direction ``dq`` (d,)."""

    @abstractmethod
    def arc(self, tail: Sequence[float] | Array, head: Sequence[float] | Array) -> Arc:
        """Return the arc between two coordinates (d,), unwrapped; it spans no breakpoint."""

    def moment(
        self, q: Sequence[float] | Array, dq: Sequence[float] | Array | None = None
    ) -> Moment:
        """Return the instant at ``q`` (d,) in motion along ``dq`` (d,); at rest without it."""
        return Moment(self.pose(q), None if dq is None else self.velocity(q, dq))
