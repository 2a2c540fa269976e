"""The contact lattice: the object graph of free motion (docs/free-motion.md)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, environment_contacts
from gm_ompl.contact.lines import Line, contact_groups
from gm_ompl.contact.offers import Offer, Offers
from gm_ompl.contact.stops import Stops
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.geometry.sweep import Sweep, heights
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.motion.screw import Screw, Slide, Tumble

SHORTEST: Final = 1e-4
"""An arc on which no corner moves farther than this, relative to D, is none."""

SLACK: Final = 1e-6
"""How far the centre of mass may leave the region, relative to D."""

SAME: Final = 1e-6
"""Poses are one up to this, relative to D and in radians."""

COUNTED: Final = 1e-9
"""A number of segments that is whole up to this is that number."""

AXES = np.eye(3)


@final
class ContactLattice:
    """Poses and the screws between them, made on demand.

    Args:
        motion: start, goal, region and steps.
        body: the object.
        environment: what it touches and may run into.
        parts: segments per step.

    Attributes:
        start: the node at the start.
        goal_nodes: None: they are not known beforehand.
    """

    def __init__(
        self, motion: FreeMotion, body: Body, environment: Environment, parts: int
    ) -> None:
        self._motion, self._body, self._environment = motion, body, environment
        self._parts, self._D = parts, body.diagonal
        self._touching = environment.contact_tolerance * self._D
        steps = motion.steps
        self._offers = Offers(steps, motion.start.position, self._D, self._touching)
        self._stops = Stops(body, environment)
        self._nodes = _Nodes(self._D)
        self._arcs: dict[int, tuple[GraphArc, ...]] = {}
        self._depths: dict[int, int] | None = None
        self.start = self._nodes.number(motion.start, None)
        self.goal_nodes: tuple[int, ...] | None = None

    def arcs_from(self, node: int) -> Sequence[GraphArc]:
        """Return the arcs that leave a node."""
        depth = self._motion.steps.depth
        if depth is not None and self._depth(node, depth) >= depth:
            return ()
        return self._leaving(node)

    def _leaving(self, node: int) -> tuple[GraphArc, ...]:
        known = self._arcs.get(node)
        if known is None:
            limits.check()
            known = self._arcs[node] = tuple(self._made(node))
        return known

    def _depth(self, node: int, most: int) -> int:
        """Return the least number of arcs from the start; all nodes up to ``most`` are made."""
        if self._depths is None:
            depths, layer = {self.start: 0}, [self.start]
            for depth in range(1, most + 1):
                heads = [arc.head for tail in layer for arc in self._leaving(tail)]
                layer = [head for head in dict.fromkeys(heads) if head not in depths]
                depths |= dict.fromkeys(layer, depth)
            self._depths = depths
        return self._depths[node]

    def _made(self, node: int) -> Iterator[GraphArc]:
        pose, under_way = self._nodes.poses[node], self._nodes.lines[node]
        contacts = environment_contacts(self._body, self._environment, pose)
        heads = {node}
        for offer in self._offers.at(pose, contacts, under_way):
            arc = self._arc(pose, offer)
            if arc is not None and arc.head not in heads:
                heads.add(arc.head)
                yield arc

    def _arc(self, pose: Pose, offer: Offer) -> GraphArc | None:
        """Return the arc that a motion comes to; None where there is none."""
        whole = offer.piece.sweep(pose, 1.0)
        least = SHORTEST * self._D / self._longest_way(whole)
        if least > 1.0 or not self._inside(whole, least, SLACK):
            return None
        share = self._stops.free_share(whole)
        if share < least:
            return None
        if not self._inside(whole, share, SLACK):
            return None
        steps, piece = share * offer.steps, offer.piece
        if share < 1.0 and isinstance(piece, Slide):
            piece = Slide(share * piece.by)
        elif share < 1.0 and isinstance(piece, Tumble):
            piece = Tumble(piece.pivot, piece.axis, share * piece.angle)
        pitch, parts = None, self._parts
        if steps < 1.0 - COUNTED:
            parts = max(1, math.ceil(self._parts * steps - COUNTED))
            pitch = 1.0 / (self._parts * steps)
        screw = Screw(pose, piece, pitch=pitch)
        return GraphArc(self._head(screw.end, offer.line), screw, parts)

    def _head(self, pose: Pose, line: Line | None) -> int:
        """Return the node at an arc's end."""
        if line is not None:
            contacts = environment_contacts(self._body, self._environment, pose)
            if self._offers.begins(pose, contact_groups(contacts, self._touching)):
                line = None
        return self._nodes.number(pose, line)

    def _longest_way(self, whole: Sweep) -> float:
        """Return how far a corner goes at most."""
        if whole.angle == 0.0:
            return float(np.linalg.norm(whole.drift))
        arms = whole.arms(self._body.vertices)
        beside = arms - np.outer(arms @ whole.axis, whole.axis)
        return abs(whole.angle) * float(np.linalg.norm(beside, axis=1).max())

    def _inside(self, whole: Sweep, share: float, slack: float) -> bool:
        """Whether the centre of mass stays in the region for a share of a motion."""
        arm = (whole.start.position - whole.pivot)[None]
        low, high = self._motion.region
        over = heights(whole, arm, AXES, low).least(0.0, share)[:, 0]
        under = heights(whole, arm, -AXES, -high).least(0.0, share)[:, 0]
        return bool(min(over.min(), under.min()) >= -slack * self._D)

    def in_goal(self, node: int) -> bool:
        """Whether the object has arrived at a node."""
        return self._motion.goal.contains(self.pose(node))

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""
        return self._nodes.poses[node]

    def coordinates(self, node: int) -> Coordinates:  # noqa: ARG002
        """Return no coordinates: there are none."""
        return ()

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
        arcs = []
        for k, (tail, head) in enumerate(itertools.pairwise(nodes), start=1):
            arc = next(arc for arc in self._leaving(tail) if arc.head == head)
            arcs.append(arc._replace(head=k))
        poses = tuple(self.pose(node) for node in nodes)
        return Way(poses, ((),) * len(nodes), tuple(arcs))


@final
class _Nodes:
    """Numbers poses, with the rotation under way; the first one found stands for all near it.

    Args:
        diagonal: D.

    Attributes:
        poses: of the nodes.
        lines: of the rotations under way there.
    """

    def __init__(self, diagonal: float) -> None:
        self._D = diagonal
        self.poses: list[Pose] = []
        self.lines: list[Line | None] = []
        self._cells: dict[tuple[int, ...], list[int]] = {}

    def number(self, pose: Pose, line: Line | None) -> int:
        """Return the node with this pose and this rotation under way."""
        features = self._features(pose)
        cells = [np.unique(np.floor(f + np.array([-SAME, 0.0, SAME]) / CELL)) for f in features]
        for cell in itertools.product(*(part.astype(int).tolist() for part in cells)):
            for node in self._cells.get(cell, ()):
                if self._same(node, pose, line):
                    return node
        home = tuple(np.floor(features).astype(int).tolist())
        self._cells.setdefault(home, []).append(len(self.poses))
        self.poses.append(pose)
        self.lines.append(line)
        return len(self.poses) - 1

    def _features(self, pose: Pose) -> Array:
        """Return numbers (4,), in cells, that hardly differ between poses that are one."""
        position = pose.position / self._D
        turned = float((pose.rotation * WEIGHTS).sum()) / 4.0  # changes by less than the angle
        features: Array = np.array([*position.tolist(), turned]) / CELL + OFFSET
        return features

    def _same(self, node: int, pose: Pose, line: Line | None) -> bool:
        other, under_way = self.poses[node], self.lines[node]
        if np.linalg.norm(pose.position - other.position) > SAME * self._D:
            return False
        # The norm of the difference is sqrt(8) times the sine of half the angle.
        if np.linalg.norm(pose.rotation - other.rotation) > math.sqrt(2.0) * SAME:
            return False
        if line is None or under_way is None:
            return line is under_way
        return line.same(under_way, SAME * self._D)


CELL: Final = 1e-3
"""Width of the cells in which poses are looked up."""

OFFSET: Final = 0.3819660112501051
"""Where cells begin, in cells: on a lattice poses lie at whole multiples, not near a cell's end."""

WEIGHTS = np.array([[0.61, -0.37, 0.83], [0.29, 0.71, -0.53], [-0.47, 0.59, 0.43]])
"""Tell rotations apart, no two alike."""
