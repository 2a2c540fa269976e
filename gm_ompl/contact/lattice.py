"""The contact lattice: the object graph of free motion (docs/background/free-motion.md)."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import Final, TypeAlias, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.departures import (
    Departures,
    Tails,
    Terrain,
    depart,
    departures,
    in_reach,
)
from gm_ompl.contact.environment import Environment
from gm_ompl.contact.expansion import Room
from gm_ompl.contact.nodes import NONE, NumberedNodes, arrive, join, resting, settle_beginnings
from gm_ompl.contact.numbered_arcs import NumberedArcs
from gm_ompl.contact.offers import begins, rules, stand
from gm_ompl.contact.poses import NumberedPoses
from gm_ompl.contact.stops import lengths
from gm_ompl.contact.touching import NO_ROOM, Toucher, sheet
from gm_ompl.cores import share_out
from gm_ompl.geometry.packed import packed
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.courses import Courses
from gm_ompl.motion.free import SHORTEST, SLACK, FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.motion.screw import Piece, Screw, Slide, Tumble

AT_ONCE: Final = 512
"""Nodes whose arcs are made between two looks at the limits in force."""

A_FEW: Final = 16
"""Poses whose motions take longer to find than it takes to start a thread."""

MOTIONS: Final = 16
"""Motions from a pose that there is room for at first."""

CONTACTS: Final = 64
"""Contacts that there is room for at first."""


Corners: TypeAlias = tuple[Array, Array]
"""Points and normals (m, 3) of the corners of contact patches, world frame."""


@final
class ContactLattice:
    """Poses and the screws between them, made on demand.

    A node is a pose, by its number, and the line of the rotation under way there.

    Args:
        motion: start, goal, region and steps.
        body: the object.
        environment: what it touches and may run into.
        parts: segments per step.
        reach: how far object and fingertips reach from the centre of mass.

    Attributes:
        start: the node at the start.
        goal_nodes: None: they are not known beforehand.
        arcs: those that were made, by numbers.
    """

    def __init__(
        self, motion: FreeMotion, body: Body, environment: Environment, parts: int, reach: float
    ) -> None:
        self._motion, self._parts, self._D = motion, parts, body.diagonal
        self._toucher = Toucher(body, environment)
        self._terrain = self._setting(body, environment, reach)
        self._poses, self._nodes = NumberedPoses(self._D), NumberedNodes()
        self.arcs = NumberedArcs(parts, motion.fewest, inside=not motion.ends)
        self._asked: dict[int, tuple[GraphArc, ...]] = {}
        self._depths: dict[int, int] | None = None
        place = self._poses.number(motion.start.rotation, motion.start.position)
        self.start = int(resting(place, self._nodes.reserve(1, len(self._poses.book.positions))))
        self.goal_nodes: tuple[int, ...] | None = None

    def _setting(self, body: Body, environment: Environment, reach: float) -> Terrain:
        motion, small = self._motion, lengths(self._D, environment.contact_tolerance)
        fixed = packed([piece for o in environment.obstacles for piece in o.body.pieces])
        shortest = SHORTEST * self._D
        room = Room(packed(body.pieces), fixed, environment.floor, small, shortest, self._parts)
        own = float(np.linalg.norm(body.vertices, axis=1).max())
        # A pivot is on the object; nothing goes farther from it than twice round the object.
        far = max(own, reach) + max(2.0 * own, motion.steps.translation) + small.touching
        return Terrain(
            room, room._replace(obstacles=packed([])), self._toucher.world, self._toucher.floor,
            rules(motion.steps, motion.start.position, self._D, small.touching),
            motion.region.copy(), SLACK * self._D, far, self._D,
        )  # fmt: skip

    def arcs_from(self, node: int) -> Sequence[GraphArc]:
        """Return the arcs that leave a node."""
        known = self._asked.get(node)
        if known is None:
            limits.check()
            known = self._asked[node] = () if self._ends(node) else tuple(self._leaving(node))
        return known

    def leave(self, nodes: Sequence[int]) -> None:
        """Make the arcs that leave nodes, all at once; ``first`` and ``past`` tell which they are.

        Raises:
            LimitError: a limit is reached; those of some nodes may be made.
        """
        book = self._nodes.book
        wanted = [n for n in dict.fromkeys(nodes) if book.first[n] == NONE and not self._ends(n)]
        for k in range(0, len(wanted), AT_ONCE):
            limits.check()
            self._make(np.array(wanted[k : k + AT_ONCE], dtype=np.int64))

    def spans(self, nodes: IntArray) -> tuple[IntArray, IntArray]:
        """Return the first arc that leaves each of nodes (N,), and the one behind the last."""
        book = self._nodes.book
        gone = np.array([self._ends(n) for n in nodes.tolist()], dtype=bool)
        return np.where(gone, 0, book.first[nodes]), np.where(gone, 0, book.past[nodes])

    def __len__(self) -> int:
        """How many nodes there are: 0 to that, the start 0."""
        return len(self._nodes)

    def has_left(self, node: int) -> bool:
        """Whether the arcs that leave a node were made."""
        return bool(self._nodes.book.first[node] != NONE)

    @property
    def left(self) -> int:
        """How many nodes have their arcs."""
        return int((self._nodes.book.first[: len(self)] != NONE).sum())

    def poses(self, nodes: IntArray) -> tuple[Array, Array]:
        """Return the rotations (N, 3, 3) and positions (N, 3) at nodes (N,)."""
        places, book = self._nodes.book.places[nodes], self._poses.book
        return book.rotations[places], book.positions[places]

    def bodies(self) -> tuple[IntArray, Array, Array]:
        """Return the rows of nodes among rotations (B, 3, 3) and positions (B, 3), and these."""
        book = self._poses.book
        return self._nodes.book.places, book.rotations, book.positions

    def _ends(self, node: int) -> bool:
        """Whether a node is as deep as nodes may be: nothing leaves it."""
        depth = self._motion.steps.depth
        return depth is not None and self._depth(node, depth) >= depth

    def _depth(self, node: int, most: int) -> int:
        """Return the least number of arcs from the start; all nodes up to ``most`` are made."""
        if self._depths is None:
            depths, layer = {self.start: 0}, [self.start]
            for depth in range(1, most + 1):
                limits.check()
                heads = [arc.head for tail in layer for arc in self._leaving(tail)]
                layer = [head for head in dict.fromkeys(heads) if head not in depths]
                depths |= dict.fromkeys(layer, depth)
            self._depths = depths
        return self._depths[node]

    def _leaving(self, node: int) -> Iterator[GraphArc]:
        """Yield the arcs that leave a node, however deep it is."""
        if self._nodes.book.first[node] == NONE:
            self._make(np.array([node]))
        for k in range(int(self._nodes.book.first[node]), int(self._nodes.book.past[node])):
            yield self.arc(k)

    def arc(self, k: int) -> GraphArc:
        """Return arc ``k``."""
        rows, places = self.arcs.rows, self._nodes.book.places
        head, parts = int(rows.heads[k]), int(rows.parts[k])
        ends, form = (int(places[rows.tails[k]]), int(places[head])), (int(rows.forms[k]), parts)
        kind = None if rows.alone[k] else int(rows.kinds[k])
        made, along = functools.partial(self._screw, k), (min(ends), max(ends), form)
        return GraphArc(head, made, parts, kind, form, along, bare=bool(rows.bare[k]))

    def courses(self, arcs: IntArray) -> Courses:
        """Return arcs (m,) as compiled code reads them."""
        rows = self.arcs.rows
        begin, end = self.poses(rows.tails[arcs]), self.poses(rows.heads[arcs])
        way = rows.by[arcs], rows.axes[arcs], rows.angles[arcs]
        return Courses(*begin, *way, *end, rows.parts[arcs], rows.pitches[arcs])

    def _screw(self, k: int) -> Screw:
        """Return the motion along arc ``k``."""
        rows = self.arcs.rows
        piece: Piece = Slide(rows.by[k])
        if rows.turns[k]:
            piece = Tumble(rows.by[k], rows.axes[k], float(rows.angles[k]))
        pitch = float(rows.pitches[k]) if rows.short[k] else None
        return Screw(self.pose(int(rows.tails[k])), piece, pitch=pitch, ends=self._motion.ends)

    def _make(self, nodes: IntArray) -> None:
        """Make the arcs that leave nodes (N,), which have none yet."""
        parts = list[tuple[int, Departures]]()

        def work(part: slice) -> None:
            parts.append((part.start, self._departing(self._nodes.tails(nodes[part]))))

        share_out(work, len(nodes), A_FEW)
        untold = list[int]()
        for first, found in sorted(parts, key=itemgetter(0)):
            some = nodes[first : first + len(found.past)]
            told = ~found.untold
            self._join(some[told], found._replace(past=found.past[told], near=found.near[told]))
            untold += some[found.untold].tolist()
        for node in untold:
            tails = self._nodes.tails(np.array([node]))
            self._join(
                np.array([node]), self._departing(tails, self._corners(int(tails.places[0])))
            )

    def _departing(self, tails: Tails, corners: Corners | None = None) -> Departures:
        """Return the motions from poses; from one where its contacts are told."""
        N, told = len(tails.places), -1 if corners is None else len(corners[0])
        contacts, room = max(CONTACTS, told), MOTIONS * N
        while True:
            found, onto = departures(N, room), sheet(contacts)
            if corners is not None:
                onto.points[:told], onto.normals[:told] = corners
            if depart(tails, self._poses.book, self._terrain, onto, told, found) != NO_ROOM:
                return found
            contacts, room = 2 * contacts, 2 * room

    def _corners(self, place: int) -> Corners:
        """Return the corners of contact patches at a pose, found by plain code where need be."""
        book, terrain = self._poses.book, self._terrain
        R, p = book.rotations[place], book.positions[place]
        points, normals = self._toucher.corners(R, p, with_obstacles=in_reach(p, terrain))
        return np.array(points), np.array(normals)

    def _join(self, nodes: IntArray, found: Departures) -> None:
        """Take motions that leave nodes (N,) for arcs."""
        motions = int(found.past[-1]) if len(nodes) else 0
        heads, kept = np.empty(motions, np.int64), np.empty(motions, np.int64)
        poses = self._poses.reserve(motions)
        arrive(found, poses, self._D, heads)
        book = self._nodes.reserve(motions, len(poses.positions))
        self._settle(found, heads)
        past = np.empty(len(nodes), np.int64)
        count = join(nodes, found, heads, kept, past, book, self._terrain.rules.near)
        of = np.repeat(np.arange(len(nodes)), np.diff(past, prepend=0))
        places, first = book.places[nodes[of]], len(self.arcs)
        stands = np.column_stack([poses.attitudes[places], poses.heights[places]])
        self.arcs.add(nodes[of], heads[:count], kept[:count], found, found.near[of], stands)
        book.past[nodes] = first + past
        book.first[nodes] = first + past - np.diff(past, prepend=0)  # last: Ctrl-C may come before

    def _settle(self, found: Departures, heads: IntArray) -> None:
        """Find whether rotations may begin where rotations lead."""
        book, nodes, contacts = self._poses.book, self._nodes.book, CONTACTS
        while (nodes.begins[heads[found.turns[: len(heads)]]] == NONE).any():
            asked = found.turns, heads, nodes, book, self._terrain, sheet(contacts)
            place = settle_beginnings(*asked)
            if place == NO_ROOM:
                contacts *= 2
            elif place < book.counts[0]:
                p = book.positions[place]
                at = stand(p, *self._corners(place), self._terrain.rules)
                nodes.begins[place] = int(begins(at.exempt, p, self._terrain.rules))

    def arrived(self, nodes: IntArray) -> BoolArray:
        """Return at which of nodes (N,) the object has arrived."""
        goal, (_, positions) = self._motion.goal, self.poses(nodes)
        off = positions - np.clip(positions, goal.low, goal.high)
        near: BoolArray = np.linalg.norm(off, axis=1) <= goal.distance + SLACK * self._D
        near[near] = [self.in_goal(node) for node in nodes[near].tolist()]
        return near

    def in_goal(self, node: int) -> bool:
        """Whether the object has arrived at a node."""
        return self._motion.goal.contains(self.pose(node))

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""
        return self._poses.pose(int(self._nodes.book.places[node]))

    def coordinates(self, node: int) -> Coordinates:  # noqa: ARG002
        """Return no coordinates: there are none."""
        return ()

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
        arcs = []
        for k, (tail, head) in enumerate(itertools.pairwise(nodes), start=1):
            arc = next(arc for arc in self.arcs_from(tail) if arc.head == head)
            arcs.append(arc.leading_to(k))
        poses = tuple(self.pose(node) for node in nodes)
        return Way(poses, ((),) * len(nodes), tuple(arcs))
