"""What waits in the search over lanes: lanes to be entered, and hubs being left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from gm_ompl.arrays import Array, IntArray
from gm_ompl.graph.lane import Hub
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.sets import LIFTED
from gm_ompl.problem import Placements


@dataclass(frozen=True, eq=False)
class Entry:
    """A lane entered at a node.

    Attributes:
        placements: the lane's.
        config: the node.
        g: cost of getting there, all judged.
        parent: the entry before the regrasp; None at the start.
        way: the arcs along the parent's lane up to there.
    """

    placements: Placements
    config: int
    g: float
    parent: Entry | None
    way: tuple[int, ...] = ()


@dataclass(eq=False)
class Choices:
    """A hub being left: its placements in increasing order of their bounds, one at a time."""

    hub: Hub
    config: int
    g: float
    parent: Entry
    way: tuple[int, ...]
    keys: Array
    order: IntArray
    pocket: bool = False
    next: int = 0

    @property
    def row(self) -> int:
        """From which placement the finger was lifted."""
        return lifted_row(self.hub, self.parent.placements)


Waiting: TypeAlias = Entry | Choices


def lifted_row(hub: Hub, placements: Placements) -> int:
    """Return the placement of a lane's finger that is lifted at a hub."""
    left = list(placements)
    for row in hub.placements:
        if row != LIFTED:
            left.remove(row)
    return left[0]


def legs(entry: Entry, way: tuple[int, ...]) -> tuple[tuple[int, ...], list[Leg]]:
    """Return the arcs of a plan that follows an entry's lane along ``way``, and its legs.

    A leg's places are counted in arcs from the start.
    """
    arcs, parts = way, [(entry.placements, len(way))]
    while entry.parent is not None:
        arcs = entry.way + arcs
        parts.append((entry.parent.placements, len(entry.way)))
        entry = entry.parent
    found, at = list[Leg](), 0
    for placements, count in reversed(parts):
        found.append((placements, at, at + count))
        at += count
    return arcs, found
