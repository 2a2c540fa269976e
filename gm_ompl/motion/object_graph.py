"""What every search walks: poses and the arcs between them; for coordinates, their lattice."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc, Moment, Motion
from gm_ompl.motion.lattice import Coordinates, Goal, Lattice


@final
class GraphArc:
    """An arc of an object graph, or of a route.

    Args:
        head: the node it leads to.
        arc: the object's motion, or what makes it when it is asked for.
        parts: in how many segments it is judged.
        kind: equal for arcs that are the same but for where on the floor they begin, nothing else
            being near; None where nothing is said.
        form: equal for arcs along which fingertips go equally far; None likewise.
        along: equal for arcs that pass the same poses, whichever way; None likewise.
        bare: whether the object is known to touch nothing in the middle of some segment.
    """

    __slots__ = ("_arc", "along", "bare", "form", "head", "kind", "parts")

    def __init__(
        self, head: int, arc: Arc | Callable[[], Arc], parts: int,
        kind: Hashable = None, form: Hashable = None, along: Hashable = None, *, bare: bool = False,
    ) -> None:  # fmt: skip
        self.head, self._arc, self.parts = head, arc, parts
        self.kind, self.form, self.along, self.bare = kind, form, along, bare

    @property
    def arc(self) -> Arc:
        """The object's motion."""
        if not isinstance(self._arc, Arc):
            self._arc = self._arc()
        return self._arc

    def leading_to(self, head: int) -> GraphArc:
        """Return the same arc, its head numbered otherwise."""
        names = self.kind, self.form, self.along
        return GraphArc(head, self._arc, self.parts, *names, bare=self.bare)

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


ON_LATTICE = 1e-9
"""How far a coordinate may be off its node, relative to its axis's extent."""
GOAL_BYTES = 150.0
"""What a goal node takes, listed and looked up."""


@final
class LatticeGraph:
    """The lattice of a path or of planar motion.

    Args:
        motion: the object's degrees of freedom.
        lattice: the nodes.
        start: coordinates of the start; they may be whole periods off the lattice.
        goal: where the object must end.
        parts: segments per arc.

    Attributes:
        start: the node at the start.
        goal_nodes: the nodes in the goal, increasing.

    Raises:
        InputError: the start is off the lattice, or no node lies in the goal.
    """

    def __init__(
        self, motion: Motion, lattice: Lattice, start: Coordinates, goal: Goal, parts: int
    ) -> None:
        self._motion, self._lattice, self._from, self._parts = motion, lattice, start, parts
        node = lattice.find(start, ON_LATTICE)
        if node is None:
            raise self._error(f"start {_named(motion, start)} is not a node of", "start")
        self.start: int = node
        inside = [_inside(lattice, goal, d) for d in range(len(lattice.axes))]
        if not all(map(len, inside)):
            raise self._error(f"goal {_region(motion, goal)} holds no node of", "goal")
        count = math.prod(map(len, inside))
        remedy = "make the goal smaller, or the lattice's steps larger"
        limits.claim(GOAL_BYTES * count, f"a goal of {count:,} nodes", remedy)
        numbers = np.ravel_multi_index(np.ix_(*inside), lattice.shape)
        self.goal_nodes: tuple[int, ...] = tuple(numbers.ravel().tolist())
        self._members = frozenset(self.goal_nodes)

    def _error(self, what: str, end: str) -> InputError:
        return InputError(
            f"{what} the lattice ({_steps(self._motion, self._lattice)}); move the {end} or change "
            "the lattice's steps, or use a planner that needs no lattice"
        )

    def arcs_from(self, node: int) -> list[GraphArc]:
        """Return the arcs that leave a node."""
        here, arc = self._lattice.coordinates(node), self._motion.arc
        neighbours = self._lattice.neighbours(node)
        return [GraphArc(head, arc(here, there), self._parts) for head, there in neighbours]

    def in_goal(self, node: int) -> bool:
        """Whether a node lies in the goal."""
        return node in self._members

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""
        return self._motion.pose(self._lattice.coordinates(node))

    def coordinates(self, node: int) -> Coordinates:
        """Return the coordinates of a node."""
        return self._lattice.coordinates(node)

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
        return way_along(self._motion, tuple(self._unwrapped(nodes)), self._parts)

    def _unwrapped(self, nodes: Sequence[int]) -> Iterator[Coordinates]:
        """Yield the nodes' coordinates, continuing from the start's; the lattice wraps them."""
        near = self._lattice.coordinates(nodes[0])
        q = self._shifted(near, near, self._from)
        yield q
        for tail, head in itertools.pairwise(nodes):
            there = dict(self._lattice.neighbours(tail))[head]
            q = self._shifted(there, self._lattice.coordinates(tail), q)
            yield q

    def _shifted(self, q: Coordinates, tail: Coordinates, unwrapped: Coordinates) -> Coordinates:
        """Return ``q`` moved by the whole periods that take ``tail`` next to ``unwrapped``."""
        return tuple(
            value if period is None else value + period * round((there - here) / period)
            for value, here, there, period in zip(
                q, tail, unwrapped, self._lattice.periods, strict=True
            )
        )


def way_along(motion: Motion, points: tuple[Coordinates, ...], parts: int) -> Way:
    """Return the way past these coordinates, unwrapped, each arc in so many parts."""
    arcs, poses = list[GraphArc](), [motion.pose(points[0])]
    for k, (a, b) in enumerate(itertools.pairwise(points), start=1):
        limits.check()
        arcs.append(GraphArc(k, motion.arc(a, b), parts))
        poses.append(motion.pose(b))
    return Way(tuple(poses), points, tuple(arcs))


def _inside(lattice: Lattice, goal: Goal, d: int) -> IntArray:
    """Return which node values of a coordinate lie in the goal, as ``Goal.contains`` has it."""
    axis, period = lattice.axes[d], lattice.periods[d]
    low, high, turn = goal.low[d], goal.high[d], goal.periods[d]
    if low is None or high is None:
        return np.arange(len(axis))
    tolerance = ON_LATTICE * (period or float(axis[-1] - axis[0]) or 1.0)
    offset = axis - low
    if turn is not None:
        offset = (offset + tolerance) % turn - tolerance
    return np.flatnonzero((offset >= -tolerance) & (offset <= high - low + tolerance))


def _region(motion: Motion, goal: Goal) -> str:
    parts = []
    for name, low, high in zip(motion.names, goal.low, goal.high, strict=True):
        if low is None or high is None:
            parts.append(f"{name} = any")
        else:
            parts.append(f"{name} = {low:g}" + ("" if low == high else f" to {high:g}"))
    return "(" + ", ".join(parts) + ")"


def _named(motion: Motion, values: Coordinates) -> str:
    pairs = zip(motion.names, values, strict=True)
    return "(" + ", ".join(f"{n} = {v:g}" for n, v in pairs) + ")"


def _steps(motion: Motion, lattice: Lattice) -> str:
    parts = []
    for name, axis in zip(motion.names, lattice.axes, strict=True):
        step = float(axis[1] - axis[0]) if len(axis) > 1 else math.nan
        spacing = f" in steps of {step:g}" if len(axis) > 1 else ""
        parts.append(f"{name} from {axis[0]:g} to {axis[-1]:g}{spacing}")
    return ", ".join(parts)
