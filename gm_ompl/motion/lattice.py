"""The lattice of object configurations that the graph of Sec. 4.2 stands on, and the goal there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array

Coordinates = tuple[float, ...]


def between(start: Coordinates, end: Coordinates, fraction: float) -> Coordinates:
    """Return the point at ``fraction`` of a straight line; its ends exactly."""
    if fraction in (0.0, 1.0):
        return end if fraction else start
    return tuple(u + fraction * (v - u) for u, v in zip(start, end, strict=True))


@dataclass(frozen=True)
class Goal:
    """Where the object must end: a box in coordinates (a point where low = high).

    Attributes:
        low: least value per coordinate, or None where any value will do.
        high: greatest value per coordinate, or None.
        periods: per coordinate, its period, or None.
    """

    low: tuple[float | None, ...]
    high: tuple[float | None, ...]
    periods: tuple[float | None, ...]

    def contains(self, q: Coordinates, tolerance: float = 1e-9) -> bool:
        """Whether ``q`` lies in the goal, up to ``tolerance`` in each coordinate's unit."""
        for value, low, high, period in zip(q, self.low, self.high, self.periods, strict=True):
            if low is None or high is None:
                continue
            offset = value - low
            if period is not None:
                offset = (offset + tolerance) % period - tolerance
            if not -tolerance <= offset <= high - low + tolerance:
                return False
        return True


@dataclass(frozen=True, eq=False)
class Lattice:
    """A regular product of node values per coordinate; a node is a 64-bit number.

    Attributes:
        axes: per coordinate, the increasing node values (a wrapping axis without its repeat).
        periods: per coordinate, its period, or None.
    """

    axes: tuple[Array, ...]
    periods: tuple[float | None, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of node values per coordinate."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of nodes."""
        return int(np.prod(self.shape, dtype=np.int64))

    def coordinates(self, node: int) -> Coordinates:
        """Return the coordinates of ``node``."""
        index = np.unravel_index(node, self.shape)
        return tuple(float(axis[i]) for axis, i in zip(self.axes, index, strict=True))

    def neighbours(self, node: int) -> Iterator[tuple[int, Coordinates]]:
        """Yield (neighbour, its coordinates): one step in one coordinate, either way.

        The neighbour's coordinates are unwrapped: they continue from this node's, so the
        straight line between the two is the arc.
        """
        index = [int(i) for i in np.unravel_index(node, self.shape)]
        here = self.coordinates(node)
        for d, (axis, period) in enumerate(zip(self.axes, self.periods, strict=True)):
            for step in (1, -1):
                i = index[d] + step
                turn = i // len(axis)  # -1 or 1 when a step leaves the axis
                if turn != 0 and (period is None or len(axis) < 3):
                    continue
                there = index.copy()
                there[d] = i - turn * len(axis)
                value = float(axis[there[d]]) + turn * (period or 0.0)
                yield (
                    int(np.ravel_multi_index(tuple(there), self.shape)),
                    (*here[:d], value, *here[d + 1 :]),
                )

    def find(self, q: Sequence[float], tolerance: float = 1e-9) -> int | None:
        """Return the node at ``q``, or None where ``q`` is off the lattice.

        ``tolerance`` is relative to each axis's extent.
        """
        index = []
        for value, axis, period in zip(q, self.axes, self.periods, strict=True):
            gaps = np.abs(axis - value)
            if period is not None:
                gaps = np.abs((axis - value + period / 2) % period - period / 2)
            extent = period or float(axis[-1] - axis[0]) or 1.0
            if gaps.min() > tolerance * extent:
                return None
            index.append(int(np.argmin(gaps)))
        return int(np.ravel_multi_index(tuple(index), self.shape))
