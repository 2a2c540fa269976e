"""Flood fill of the air over a grid of sphere centres, its edges swept.

The grid is that of the object's frame, so that what it says does not depend on where the scene
stands. It has no bounds: it grows where it is free, until it reaches what was sought, can leave
straight on for ever, or is full.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Container
from dataclasses import dataclass, field
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.geometry.air import FreeAir

STEPS: Final = np.concatenate([np.eye(3, dtype=np.int64), -np.eye(3, dtype=np.int64)])
"""From a node to its neighbours."""

CORNERS: Final = np.array(list(itertools.product((0, 1), repeat=3)), dtype=np.int64)
"""From the lowest corner of a cell to all of them."""

BITS: Final = 21
"""Of a node's number, those that each of its three coordinates takes."""

HALF: Final = 1 << (BITS - 1)

ASKED: Final = 4
"""Nodes all of whose coordinates this divides are asked whether they can go straight on."""

CELL: Final = 3.0**0.5 / 2.0
"""From a cell's middle to its corners, in spacings."""

FURTHEST: Final = HALF - 2
"""No coordinate of a node is larger."""


class Ending(enum.Enum):
    """How a fill ended; the value is a sentence for the user."""

    OUTSIDE = "it leads away for ever"
    CLOSED = "it is full: there is no way out"
    FOUND = "what was sought is reached"
    STOPPED = "it has more nodes than are looked at"


@dataclass
class Flood:
    """What was filled.

    Attributes:
        ending: how it ended.
        parents: per node its parent's number, -1 at the seeds.
        last: the node at which it ended, where one was found.
    """

    ending: Ending
    parents: dict[int, int] = field(default_factory=dict)
    last: int = -1

    def back(self, node: int) -> list[int]:
        """Return the nodes from a seed to ``node``."""
        way = [node]
        while self.parents[way[-1]] >= 0:
            way.append(self.parents[way[-1]])
        return way[::-1]


def numbers(nodes: IntArray) -> IntArray:
    """Return the numbers (n,) of nodes given by whole coordinates (n, 3)."""
    x, y, z = (nodes + HALF).T
    found: IntArray = (x << (2 * BITS)) | (y << BITS) | z
    return found


def nodes_of(found: IntArray) -> IntArray:
    """Return whole coordinates (n, 3) of numbered nodes."""
    mask = (1 << BITS) - 1
    return np.stack([found >> (2 * BITS), (found >> BITS) & mask, found & mask], axis=1) - HALF


def for_ever(air: FreeAir) -> float:
    """Return a length that leads beyond everything there is, from wherever something is near."""
    return 4.0 * air.extent


def straight_ways(air: FreeAir) -> Array:
    """Return the directions (w, 3) that are tried for ever: up, and along the object's axes."""
    return np.concatenate([air.up[None], STEPS.astype(float)])


@final
class Grid:
    """A grid in one air.

    Args:
        air: where it is free.
        spacing: of its nodes.
        most: nodes that a fill looks at.
        cells: whether a node stands for the cell around it and two are joined where both may hold
            a free place: then what is closed is closed for certain. Else edges are swept, and what
            is joined is joined for certain.
    """

    def __init__(self, air: FreeAir, spacing: float, most: int, *, cells: bool = False) -> None:
        self.spacing = spacing
        self._air = air.wider(-CELL * spacing) if cells else air
        self._most, self._cells = most, cells
        self._far = for_ever(air)
        self._ways = straight_ways(air)

    def places(self, nodes: IntArray) -> Array:
        """Return where nodes given by whole coordinates (n, 3) are, (n, 3)."""
        places: Array = self.spacing * nodes.astype(np.float64)
        return places

    def joints(self, points: Array) -> IntArray:
        """Return the numbers of the nodes around ``points`` (n, 3) that they join, swept."""
        lowest = np.floor(points / self.spacing).astype(np.int64)
        if np.abs(lowest).max(initial=0) >= FURTHEST:
            return np.zeros(0, dtype=np.int64)
        around = (lowest[:, None] + CORNERS).reshape(-1, 3)
        free = self._air.clear(np.repeat(points, len(CORNERS), axis=0), self.places(around))
        return np.unique(numbers(around[free]))

    def fill(
        self, seeds: IntArray, sought: Container[int] | None = None, *, leaves: bool = True
    ) -> Flood:
        """Fill from nodes, numbered, breadth first.

        Args:
            seeds: free nodes.
            sought: ends at the first of these.
            leaves: whether it ends, too, where it leads away for ever.
        """
        flood = Flood(Ending.CLOSED, dict.fromkeys(seeds.tolist(), -1))
        front = seeds
        while len(front):
            limits.check()
            for node in front.tolist():
                if sought is not None and node in sought:
                    flood.ending, flood.last = Ending.FOUND, node
                    return flood
            here = nodes_of(front)
            leaver = self._leaver(here) if leaves else None
            if leaver is not None:
                flood.ending, flood.last = Ending.OUTSIDE, int(front[leaver])
                return flood
            if len(flood.parents) > self._most or np.abs(here).max() >= FURTHEST:
                flood.ending = Ending.STOPPED
                return flood
            front = self._grown(front, here, flood)
        return flood

    def _leaver(self, here: IntArray) -> int | None:
        """Return the place among nodes of one that can go straight on for ever; None of none.

        Few nodes are asked: who has left finds one.
        """
        asked = np.flatnonzero((here % ASKED == 0).all(axis=1))
        if not len(asked):
            return None
        points = self.places(here[asked])
        for way in self._ways:
            away = np.flatnonzero(self._air.clear(points, points + self._far * way))
            if len(away):
                return int(asked[away[0]])
        return None

    def _grown(self, front: IntArray, here: IntArray, flood: Flood) -> IntArray:
        """Return the nodes next to ``front`` that are new."""
        near = (here[:, None] + STEPS).reshape(-1, 3)
        known, tails = flood.parents, np.repeat(front, len(STEPS))
        heads = numbers(near)
        new = np.array([head not in known for head in heads.tolist()])
        tails, heads, near = tails[new], heads[new], near[new]
        room = np.repeat(self._air.room(self.places(here)), len(STEPS))[new]
        free = room >= self.spacing
        close = np.flatnonzero(~free)
        ends = self.places(near[close])
        begin = ends if self._cells else self.places(nodes_of(tails[close]))
        free[close] = self._air.clear(begin, ends)
        tails, heads = tails[free], heads[free]
        heads, first = np.unique(heads, return_index=True)
        known.update(zip(heads.tolist(), tails[first].tolist(), strict=True))
        return heads
