"""What every motion of the object offers: poses, arcs, bounds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.motion.arc import Arc, Moment

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
    """

    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    periods: tuple[float | None, ...]
    breakpoints: tuple[tuple[float, ...], ...]

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
