"""What every search walks: the object's poses, and the arcs that lead from one to another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment
from gm_ompl.motion.lattice import Coordinates


class GraphArc(NamedTuple):
    """An arc of an object graph, or of a route.

    Attributes:
        head: the node it leads to.
        arc: the object's motion.
        parts: in how many segments it is judged.
    """

    head: int
    arc: Arc
    parts: int

    def middles(self) -> tuple[Moment, ...]:
        """Return the instants at which the segments are judged."""
        return self.arc.middles(self.parts)

    def lengths(self, points: Array) -> Array:
        """Return |dq_finger i,j| of Eq. (9) for fingertip centres (m, 3), as (m, parts)."""
        return self.arc.chords(points, self.parts).T


@dataclass(frozen=True, eq=False)
class Way:
    """The object's way: arcs that follow each other.

    Attributes:
        poses: where it is before, between and behind the arcs, one more than these.
        coordinates: the same places in the motion's coordinates, unwrapped; each empty where the
            motion has none.
        arcs: arc k leads from place k to place k + 1, its ``head``.
    """

    poses: tuple[Pose, ...]
    coordinates: tuple[Coordinates, ...]
    arcs: tuple[GraphArc, ...]


class ObjectGraph(Protocol):
    """A directed graph of poses, made on demand; at most one arc leads from a node to another.

    Nodes are numbers from 0 to 2^63 - 1. An arc need not have a reverse, nor a node coordinates.
    """

    @property
    def start(self) -> int:
        """The node at the start."""

    @property
    def goal_nodes(self) -> tuple[int, ...] | None:
        """The nodes in the goal, increasing; None where they cannot be listed."""

    def arcs_from(self, node: int) -> Sequence[GraphArc]:
        """Return the arcs that leave a node, whether or not the object is free along them."""

    def in_goal(self, node: int) -> bool:
        """Whether the object has arrived at a node."""

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""

    def coordinates(self, node: int) -> Coordinates:
        """Return the coordinates of a node; empty where the motion has none."""

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
