"""What waits in the open list of the search over lanes, and the plan that an entry stands for."""

from __future__ import annotations

from dataclasses import dataclass

from gm_ompl.arrays import Array, IntArray
from gm_ompl.graph.extraction import Leg
from gm_ompl.graph.lane import Hub
from gm_ompl.problem import Placements


@dataclass(frozen=True, eq=False)
class Entry:
    """A lane entered at a node.

    Attributes:
        placements: the lane's.
        config: the node.
        g: cost of getting there, all judged.
        parent: the entry before the regrasp; None at the start.
    """

    placements: Placements
    config: int
    g: float
    parent: Entry | None


@dataclass(eq=False)
class Choices:
    """A hub being left: its placements in increasing order of their bounds, one at a time."""

    hub: Hub
    config: int
    g: float
    parent: Entry
    keys: Array
    order: IntArray
    next: int = 0


def legs(entry: Entry, last: int) -> list[Leg]:
    """Return the way from the start along an entry's lane to node ``last``."""
    way: list[Leg] = []
    now: Entry | None = entry
    while now is not None:
        way.append((now.placements, now.config, last))
        last, now = now.config, now.parent
    return way[::-1]
