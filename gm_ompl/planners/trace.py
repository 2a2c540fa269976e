"""What a search may tell beyond its progress, for pictures of it.

A search asks once, ``trace = tracer(report)``, and where that is not None hands it an
``Expansion`` or a ``Vertex`` whenever one comes to be. Nobody listening costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.planner import Report
from gm_ompl.problem import Placements


@dataclass(frozen=True)
class Expansion:
    """A best-first search took something from the front of its open list.

    Attributes:
        q: object coordinates of what was taken.
        placements: per finger, -1 for a lifted one; empty where none are fixed yet.
        cost: of getting there.
        bound: on the cost of every plan through there, its key.
        why: what was done with it, in a word or two: "renewed", "judged", "left a hub".
    """

    q: Coordinates
    placements: Placements
    cost: float
    bound: float
    why: str


@dataclass(frozen=True)
class Vertex:
    """A sampling search added a state to a tree.

    Attributes:
        number: unlike that of any other vertex.
        parent: the vertex it hangs on; None at a root. A later event with the same number moves
            the vertex to another parent.
        q: object coordinates.
        placements: per finger, a row of the placement table; empty where they are not discrete.
        kind: of the arc from the parent: "displacement" or "regrasp"; "root" without a parent.
        tree: "start" or "goal", where the tree is rooted.
    """

    number: int
    parent: int | None
    q: Coordinates
    placements: Placements
    kind: str
    tree: str = "start"


Trace: TypeAlias = Callable[[Expansion | Vertex], None]


def tracer(report: Report) -> Trace | None:
    """Return where ``report`` wants to hear of expansions and vertices; None is nowhere."""
    trace: Trace | None = getattr(report, "trace", None)
    return trace
