"""Poses numbered as they are found; the first one stands for all near it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Final, Generic, TypeVar, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.lines import Line
from gm_ompl.geometry.pose import Pose

SAME: Final = 1e-6
"""Poses are one up to this, relative to D and in radians."""

CELL: Final = 1e-3
"""Width of the cells in which poses are looked up, relative to D."""

OFFSET: Final = 0.3819660112501051
"""Where cells begin, in cells: on a lattice poses lie at whole multiples, not near a cell's end."""

WEIGHTS = np.array([0.61, -0.37, 0.83, 0.29, 0.71, -0.53, -0.47, 0.59, 0.43]) / 4.0
"""Tell rotations apart, no two alike; the sum changes by less than the angle turned."""

EQUAL: Final = 1e-9
"""Rotations and heights that differ by at most this are made equal in every bit: then what holds
for one is found again by the other."""


Value = TypeVar("Value")


@final
class _Near(Generic[Value]):
    """Values numbered as they are found; the first one stands for all that are like it.

    Args:
        width: values that are alike have keys that differ by less.
    """

    def __init__(self, width: float) -> None:
        self._width = 100.0 * width
        self._found: dict[int, list[int]] = {}
        self._values: list[Value] = []

    def number(
        self, key: float, value: Value, alike: Callable[[Value, Value], bool]
    ) -> tuple[int, Value]:
        """Return the number of a value and what stands for it."""
        place = key / self._width + OFFSET
        for cell in {math.floor(place - 0.01), math.floor(place + 0.01)}:
            for known in self._found.get(cell, ()):
                if alike(self._values[known], value):
                    return known, self._values[known]
        self._found.setdefault(math.floor(place), []).append(len(self._values))
        self._values.append(value)
        return len(self._values) - 1, value


@final
class NumberedPoses:
    """Numbers poses, each with the rotation under way there.

    Args:
        diagonal: D.

    Attributes:
        poses: by number.
        lines: of the rotations under way, by number.
        attitudes: by number, the number of the rotation that the pose has.
    """

    def __init__(self, diagonal: float) -> None:
        self._D = diagonal
        self.poses: list[Pose] = []
        self.lines: list[Line | None] = []
        self.attitudes: list[int] = []
        self._cells: dict[tuple[int, ...], list[int]] = {}
        self._rotations = _Near[Array](EQUAL)
        self._heights = _Near[float](EQUAL * diagonal)

    def number(self, rotation: Array, position: Array, line: Line | None) -> int:
        """Return the number of the pose with this rotation under way."""
        x, y, z = position.tolist()
        turned = float(rotation.ravel() @ WEIGHTS)
        features = [value / CELL + OFFSET for value in (x / self._D, y / self._D, z / self._D)]
        features.append(turned / CELL + OFFSET)
        for cell in itertools.product(*map(_cells, features)):
            for node in self._cells.get(cell, ()):
                if self._same(node, rotation, position, line):
                    return node
        home = tuple(math.floor(feature) for feature in features)
        self._cells.setdefault(home, []).append(len(self.poses))
        attitude, known = self._rotations.number(turned, rotation, _alike)
        self.attitudes.append(attitude)
        height = self._heights.number(z, z, lambda a, b: abs(a - b) <= EQUAL * self._D)[1]
        self.poses.append(Pose(known, np.array([x, y, height])))
        self.lines.append(line)
        return len(self.poses) - 1

    def _same(self, node: int, rotation: Array, position: Array, line: Line | None) -> bool:
        other, under_way = self.poses[node], self.lines[node]
        arm, turn = position - other.position, (rotation - other.rotation).ravel()
        # The norm of the difference is sqrt(8) times the sine of half the angle.
        if arm @ arm > (SAME * self._D) ** 2 or turn @ turn > 2.0 * SAME * SAME:
            return False
        if line is None or under_way is None:
            return line is under_way
        return line.same(under_way, SAME * self._D)


def _cells(feature: float) -> set[int]:
    """Return the cells in which a number, or one that is the same, may lie."""
    return {math.floor(feature - SAME / CELL), math.floor(feature + SAME / CELL)}


def _alike(a: Array, b: Array) -> bool:
    return bool(np.abs(a - b).max() <= EQUAL)
