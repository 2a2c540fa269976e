"""The air around the object at one pose, and its parts: the outside and pockets."""

from __future__ import annotations

import enum
from typing import Final, NamedTuple, TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.air import FreeAir
from gm_ompl.geometry.flood import CELL, Ending, Grid, for_ever
from gm_ompl.geometry.surface import PlacementTable

LEVELS: Final = (4, 2, 1)
"""Spacings of the grids tried, over the finest."""

MOST_NODES: Final = 200_000
"""Nodes that one fill looks at: some seconds' work. What is larger than that is not decided."""


class Label(enum.Enum):
    """What a part of the air is, beside the numbers of pockets."""

    OUTSIDE = "joined to far away"
    UNKNOWN = "too large to be filled"


Part: TypeAlias = Label | int
"""A part of the air; a pocket's number is its smallest node's."""


@final
class Fills:
    """Fills over one grid, each part of the air once.

    Args:
        air: what is filled.
        spacing: of the grid.
        cells: as ``Grid`` has it.

    Attributes:
        grid: likewise.
    """

    def __init__(self, air: FreeAir, spacing: float, *, cells: bool) -> None:
        self.grid = Grid(air, spacing, MOST_NODES, cells=cells)
        self._labels: dict[int, Part] = {}

    def parts(self, points: Array) -> set[Part]:
        """Return the parts of the air that ``points`` (n, 3) join; OUTSIDE alone, where it is."""
        found = set[Part]()
        for joint in self.grid.joints(points).tolist():
            if joint not in self._labels:
                self._fill(joint)
            found.add(self._labels[joint])
            if Label.OUTSIDE in found:
                return {Label.OUTSIDE}
        return found

    def _fill(self, joint: int) -> None:
        flood = self.grid.fill(np.array([joint]), self)
        label: Part = Label.UNKNOWN
        if flood.ending is Ending.CLOSED:
            label = min(flood.parents)
        elif flood.ending is not Ending.STOPPED:
            label = Label.OUTSIDE
        self._labels.update(dict.fromkeys(flood.parents, label))

    def __len__(self) -> int:
        """Return how many nodes were looked at."""
        return len(self._labels)

    def __contains__(self, node: object) -> bool:
        """Whether a node is known to be outside."""
        return self._labels.get(node) is Label.OUTSIDE  # type: ignore[call-overload]


@final
class Space:
    """The air around the object with some fingertips in it, and what was filled of it.

    Attributes:
        air: likewise.
        swept: at every level, the coarsest first, what is joined for certain.
        closed: likewise, what is closed for certain.
    """

    def __init__(self, air: FreeAir, finest: float) -> None:
        self.air = air
        self.swept = [Fills(air, level * finest, cells=False) for level in LEVELS]
        self.closed = [
            Fills(air, level * finest, cells=True)
            for level in LEVELS[:-1]
            if CELL * level * finest < air.radius
        ]

    @property
    def nodes(self) -> int:
        """How many nodes were looked at so far, of all grids."""
        return sum(len(fills) for fills in (*self.swept, *self.closed))


class StraightWays(NamedTuple):
    """Ways out without a grid: off along the normal, and from there straight on for ever.

    Attributes:
        corner: (P, 3), where each turns.
        end: (P, 3), far away.
        found: (P,), whether there is one.
    """

    corner: Array
    end: Array
    found: BoolArray


def straight_out(air: FreeAir, here: Array, table: PlacementTable, heights: Array) -> StraightWays:
    """Return the straight ways out of all placements.

    Args:
        air: with no other fingertip in it.
        here: (P, 3), the fingertip's centre at every placement.
        table: the placements.
        heights: how far off they are tried.
    """
    limits.check()
    away = for_ever(air)
    corner, end = here.copy(), here - away * table.normals
    found = air.clear(here, end, table.piece)
    rows = np.flatnonzero(~found)
    for height in heights.tolist():
        off = here[rows] - height * table.normals[rows]
        free = air.clear(here[rows], off, table.piece[rows])
        rows, off = rows[free], off[free]  # what stops a fingertip here stops it farther off, too
        if not len(rows):
            break
        on = off + away * air.up
        out = air.clear(off, on)
        found[rows[out]], corner[rows[out]], end[rows[out]] = True, off[out], on[out]
        rows = rows[~out]
    return StraightWays(corner, end, found)
