"""The contact lattice: the object graph of free motion (docs/free-motion.md)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, environment_contacts
from gm_ompl.contact.lines import Line, contact_groups
from gm_ompl.contact.offers import Offer, Offers
from gm_ompl.contact.poses import NumberedPoses
from gm_ompl.contact.stops import Stops
from gm_ompl.contact.templates import DECIMALS, Template, extremes, form
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.motion.screw import Piece, Screw, Slide, Tumble

SHORTEST: Final = 1e-4
"""An arc on which no corner moves farther than this, relative to D, is none."""

SLACK: Final = 1e-6
"""How far the centre of mass may leave the region, relative to D."""

COUNTED: Final = 1e-9
"""A number of segments that is whole up to this is that number."""


@final
class ContactLattice:
    """Poses and the screws between them, made on demand.

    Args:
        motion: start, goal, region and steps.
        body: the object.
        environment: what it touches and may run into.
        parts: segments per step.
        reach: how far object and fingertips reach from the centre of mass.

    Attributes:
        start: the node at the start.
        goal_nodes: None: they are not known beforehand.
    """

    def __init__(
        self, motion: FreeMotion, body: Body, environment: Environment, parts: int, reach: float
    ) -> None:
        self._motion, self._body, self._environment = motion, body, environment
        self._parts, self._D = parts, body.diagonal
        self._touching = environment.contact_tolerance * self._D
        steps = motion.steps
        self._offers = Offers(steps, motion.start.position, self._D, self._touching)
        self._open = replace(environment, obstacles=())
        self._stops, self._floor = Stops(body, environment), Stops(body, self._open)
        own = float(np.linalg.norm(body.vertices, axis=1).max())
        # A pivot is on the object; nothing goes farther from it than twice round the object.
        self._far = max(own, reach) + max(2.0 * own, steps.translation) + self._touching
        self._nodes = NumberedPoses(self._D)
        self._templates: dict[Hashable, tuple[Template, ...]] = {}
        self._arcs: dict[int, tuple[GraphArc, ...]] = {}
        self._depths: dict[int, int] | None = None
        self.start = self._nodes.number(motion.start.rotation, motion.start.position, None)
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
        """Yield the arcs that leave a node, none of them to where another leads."""
        pose, heads = self._nodes.poses[node], {node}
        for template in self._templates_at(node):
            if not self._inside(pose.position, template):
                continue
            line = template.line if template.goes_on else None
            if line is not None:
                line = Line(line.point + pose.position, line.direction)
            head = self._nodes.number(template.rotation, pose.position + template.by, line)
            if head not in heads:
                heads.add(head)
                piece = template.piece
                if isinstance(piece, Tumble):
                    piece = Tumble(piece.pivot + pose.position, piece.axis, piece.angle)
                arc = Screw(pose, piece, pitch=template.pitch)
                yield GraphArc(head, arc, template.parts, template.kind)

    def _templates_at(self, node: int) -> Iterable[Template]:
        """Return the arcs at a node."""
        pose = self._nodes.poses[node]
        corners = pose.apply(self._body.vertices)
        if self._stops.beside(corners.min(axis=0), corners.max(axis=0)):
            return self._cut_short(node, self._environment, None)
        templates = self._over_floor(node)
        if not self._stops.near(pose.position, self._far):
            return templates
        found = (self._beside(pose, template) for template in templates)
        return (template for template in found if template is not None)

    def _over_floor(self, node: int) -> tuple[Template, ...]:
        """Return the arcs at a node as they are with nothing but the floor there."""
        pose, line, steps = self._nodes.poses[node], self._nodes.lines[node], self._motion.steps
        places = (pose.position - self._motion.start.position) / steps.translation
        between = np.round(places[list(steps.translate)], DECIMALS - 1) % 1.0
        height = round(float(pose.position[2]) / self._D, DECIMALS)
        turning: Hashable = None
        if line is not None:
            arm = (line.point - pose.position) / self._D
            arm = arm - (arm @ line.direction) * line.direction
            turning = (*(np.round([*arm, *line.direction], DECIMALS - 1) + 0.0).tolist(),)
        stands = self._nodes.attitudes[node], height
        key = (stands, between.tobytes(), turning)
        known = self._templates.get(key)
        if known is None:
            known = self._templates[key] = tuple(self._cut_short(node, self._open, stands))
        return known

    def _beside(self, pose: Pose, template: Template) -> Template | None:
        """Return what obstacles leave of an arc."""
        low, high = pose.position + template.box
        if not self._stops.beside(low, high):
            return template._replace(kind=None)
        piece, line = template.piece, template.line
        if isinstance(piece, Tumble):
            piece = Tumble(piece.pivot + pose.position, piece.axis, piece.angle)
        if line is not None:
            line = Line(line.point + pose.position, line.direction)
        offer = Offer(piece, line, template.steps)
        return self._template(pose, offer, self._environment, self._stops)

    def _cut_short(
        self, node: int, environment: Environment, stands: Hashable | None
    ) -> Iterator[Template]:
        """Yield what the motions that are offered come to.

        Args:
            node: where they begin.
            environment: what is looked at: all of it, or the floor alone.
            stands: equal where the object stands alike on the floor, with nothing else near.
        """
        pose, stops = self._nodes.poses[node], self._stops
        if environment is self._open:
            stops = self._floor
        contacts = environment_contacts(self._body, environment, pose)
        for offer in self._offers.at(pose, contacts, self._nodes.lines[node]):
            template = self._template(pose, offer, environment, stops)
            if template is not None:
                alike = None if stands is None else (stands, form(template.piece, self._D))
                yield template._replace(kind=alike)

    def _template(
        self, pose: Pose, offer: Offer, environment: Environment, stops: Stops
    ) -> Template | None:
        """Return what a motion comes to; None: it is too short to be one."""
        share = stops.free_share(offer.piece.sweep(pose, 1.0))
        if share * self._longest_way(pose, offer.piece) < SHORTEST * self._D:
            return None
        steps, line = share * offer.steps, offer.line
        pitch, parts, goes_on = None, self._parts, False
        if steps < 1.0 - COUNTED:
            parts = max(1, math.ceil(self._parts * steps - COUNTED))
            pitch = 1.0 / (self._parts * steps)
        piece: Piece
        if isinstance(offer.piece, Slide):
            piece = offer.piece if share == 1.0 else Slide(share * offer.piece.by)
            end = Pose(pose.rotation, pose.position + piece.by)
        else:
            turn = offer.piece
            end = pose.turned(turn.pivot, turn.axis, share * turn.angle)
            piece = Tumble(turn.pivot - pose.position, turn.axis, share * turn.angle)
        if line is not None:
            contacts = environment_contacts(self._body, environment, end)
            goes_on = not self._offers.begins(end, contact_groups(contacts, self._touching))
            line = Line(line.point - pose.position, line.direction)
        extent, box = self._extents(pose, end, piece)
        by = end.position - pose.position
        return Template(
            piece, line, by, extent, box, end.rotation, steps, parts, pitch, goes_on, None
        )

    def _extents(self, pose: Pose, end: Pose, piece: Piece) -> tuple[Array, Array]:
        """Return the boxes (2, 3) in which the centre of mass and the object stay on an arc."""
        by = end.position - pose.position
        ends = np.array([np.zeros(3), by, *(extremes(piece) if isinstance(piece, Tumble) else ())])
        first = self._body.vertices @ pose.rotation.T
        corners = np.concatenate([first, self._body.vertices @ end.rotation.T + by])
        margin = self._touching
        if isinstance(piece, Tumble):
            margin += piece.sweep(Pose(pose.rotation, np.zeros(3)), 1.0).sagitta(
                first - piece.pivot
            )
        box = np.array([corners.min(axis=0) - margin, corners.max(axis=0) + margin])
        return np.array([ends.min(axis=0), ends.max(axis=0)]), box

    def _longest_way(self, pose: Pose, piece: Piece) -> float:
        """Return how far a corner goes at most."""
        if isinstance(piece, Slide):
            return float(np.linalg.norm(piece.by))
        arms = pose.apply(self._body.vertices) - piece.pivot
        beside = arms - np.outer(arms @ piece.axis, piece.axis)
        return abs(piece.angle) * float(np.linalg.norm(beside, axis=1).max())

    def _inside(self, position: Array, template: Template) -> bool:
        """Whether the centre of mass stays in the region."""
        over = position + template.extent - self._motion.region
        slack = SLACK * self._D
        return bool(over[0].min() >= -slack and over[1].max() <= slack)

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
