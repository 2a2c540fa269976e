"""The contact lattice: the object graph of free motion (docs/background/free-motion.md)."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Hashable, Iterator, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment
from gm_ompl.contact.expansion import Ended, Offered, Room, arrive, ended, forms, touches
from gm_ompl.contact.lines import SAME, Line
from gm_ompl.contact.offers import Stand, begins, find, may_begin, offered, rules, stand
from gm_ompl.contact.poses import NumberedPoses
from gm_ompl.contact.stops import lengths
from gm_ompl.contact.touching import Toucher
from gm_ompl.geometry.packed import packed
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.free import SHORTEST, SLACK, FreeMotion
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.motion.screw import Piece, Screw, Slide, Tumble

COUNTED: Final = 1e-9
"""A number of segments that is whole up to this is that number."""

DECIMALS: Final = 7
"""Lines under way (over D) and places between the grid's (in steps) are told apart by so many."""


NONE_TURNING: Final[tuple[tuple[int, ...], Array]] = ((), np.empty((0, 2, 3)))
"""Nodes at a place with a rotation under way, and their lines, where there are none."""


class Motions(NamedTuple):
    """What is offered where the object stands in one way, and what it comes to.

    Attributes:
        offered: the motions.
        ended: what they come to.
        forms: (m), equal for motions that are one as the object sees them, whichever way.
        kinds: (m), as ``GraphArc`` has them.
    """

    offered: Offered
    ended: Ended
    forms: list[int]
    kinds: list[Hashable]


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
    """

    def __init__(
        self, motion: FreeMotion, body: Body, environment: Environment, parts: int, reach: float
    ) -> None:
        self._motion, self._parts, self._D = motion, parts, body.diagonal
        small, steps = lengths(self._D, environment.contact_tolerance), motion.steps
        self._rules = rules(steps, motion.start.position, self._D, small.touching)
        self._toucher = Toucher(body, environment)
        fixed = packed([piece for o in environment.obstacles for piece in o.body.pieces])
        shortest = SHORTEST * self._D
        self._room = Room(packed(body.pieces), fixed, environment.floor, small, shortest, parts)
        self._open = self._room._replace(obstacles=packed([]))
        self._walls = self._room._replace(floor=False)
        own = float(np.linalg.norm(body.vertices, axis=1).max())
        # A pivot is on the object; nothing goes farther from it than twice round the object.
        self._far = max(own, reach) + max(2.0 * own, steps.translation) + small.touching
        self._numbered = NumberedPoses(self._D)
        self._nodes: list[tuple[int, Line | None]] = []
        self._resting: dict[int, int] = {}
        self._turning: dict[int, tuple[tuple[int, ...], Array]] = {}
        self._stands: dict[Hashable, Stand] = {}
        self._begin: dict[int, bool] = {}
        self._beside: dict[int, bool] = {}
        self._over_floor: dict[Hashable, Motions] = {}
        self._forms: dict[bytes, int] = {}
        self._arcs: dict[int, tuple[GraphArc, ...]] = {}
        self._depths: dict[int, int] | None = None
        place = self._numbered.number(motion.start.rotation, motion.start.position)
        self.start = self._node(place, None)
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
        (place, way), position = self._nodes[node], self._position(node)
        motions = self._motions(place, None if way is None else way.moved(-position))
        heads = np.empty(len(motions.forms), dtype=np.int64)
        book, slack = self._numbered.reserve(len(heads)), SLACK * self._D
        arrive(motions.ended, position, self._motion.region, slack, book, self._D, heads)
        seen = {node}
        steps = (motions.ended.shares * motions.offered.steps).tolist()
        turns, bare = motions.offered.turns.tolist(), motions.ended.bare.tolist()
        inside = not self._motion.ends
        for i, end in enumerate(heads.tolist()):
            if end < 0:
                continue
            line = None
            if turns[i] and not self._begins(end):
                line = Line(position + motions.offered.by[i], motions.offered.axes[i])
            head = self._node(end, line)
            if head in seen:
                continue
            seen.add(head)
            pitch, parts, fewest = None, self._parts, self._motion.fewest
            if steps[i] < 1.0 - COUNTED:
                parts = max(fewest, math.ceil(self._parts * steps[i] - COUNTED))
                pitch = 1.0 / (self._parts * steps[i])
            made = functools.partial(self._screw, place, motions, i, pitch)
            form = motions.forms[i], parts
            along = (min(place, end), max(place, end), form)
            kind, lifts = motions.kinds[i], bare[i] and inside
            yield GraphArc(head, made, parts, kind, form, along, bare=lifts)

    def _screw(self, place: int, motions: Motions, i: int, pitch: float | None) -> Screw:
        """Return motion ``i`` from a pose."""
        pose, offered, ended = self._numbered.pose(place), motions.offered, motions.ended
        piece: Piece = Slide(ended.ways[i])
        if offered.turns[i]:
            angle = float(ended.shares[i]) * float(offered.angles[i])
            piece = Tumble(offered.by[i] + pose.position, offered.axes[i], angle)
        return Screw(pose, piece, pitch=pitch, ends=self._motion.ends)

    def _motions(self, place: int, line: Line | None) -> Motions:
        """Return the motions at a pose, a rotation under way about a line seen from there."""
        at, book = self._stand(place), self._numbered.book
        position, turning = book.positions[place], np.empty((0, 2, 3))
        if line is not None:
            turning = np.array([line])
        if self._near(place):
            found = offered(at, position, self._rules, turning)
            return self._cut_short(place, found, self._room, None)
        stands = int(book.attitudes[place]), int(book.heights[place])
        known_by: Hashable = None
        if line is not None:
            arm = line.point - (line.point @ line.direction) * line.direction
            numbers = np.round([*(arm / self._D), *line.direction], DECIMALS)
            known_by = (*(numbers + 0.0).tolist(),)
        steps = self._motion.steps
        counts = (position - self._motion.start.position)[list(steps.translate)] / steps.translation
        key = (stands, (np.round(counts, DECIMALS) % 1.0).tobytes(), known_by)
        known = self._over_floor.get(key)
        if known is None:
            found = offered(at, position, self._rules, turning)
            known = self._over_floor[key] = self._cut_short(place, found, self._open, stands)
        return known

    def _cut_short(
        self, place: int, motions: Offered, room: Room, stands: Hashable | None
    ) -> Motions:
        """Return what motions come to.

        Args:
            place: where they begin.
            motions: what is offered.
            room: what is in their way.
            stands: equal where the object stands alike on the floor, with nothing else near.
        """
        R, p = self._numbered.book.rotations[place], self._numbered.book.positions[place]
        found = ended(motions, R, p, room)
        numbers, ahead = forms(motions, found, R, self._D)
        own = [self._forms.setdefault(row.tobytes(), len(self._forms)) for row in numbers]
        kinds: list[Hashable] = [None] * len(own)
        if stands is not None:
            kinds = [(stands, one, way) for one, way in zip(own, ahead.tolist(), strict=True)]
        return Motions(motions, found, own, kinds)

    def _near(self, place: int) -> bool:
        """Whether an obstacle may be in reach of object or hand around a pose."""
        known = self._beside.get(place)
        if known is None:
            low, high = self._room.obstacles.low, self._room.obstacles.high
            position = self._numbered.book.positions[place]
            way = np.minimum(np.maximum(position, low), high) - position
            reached = np.einsum("ij,ij->i", way, way) <= self._far * self._far
            known = self._beside[place] = bool(reached.any())
        return known

    def _stand(self, place: int) -> Stand:
        """Return how the object stands at a pose."""
        book = self._numbered.book
        R, p = book.rotations[place], book.positions[place]
        beside = self._near(place) and touches(R, p, self._walls)
        key = place if beside else (int(book.attitudes[place]), int(book.heights[place]))
        known = self._stands.get(key)
        if known is None:
            points, normals = self._toucher.corners(R, p, with_obstacles=beside)
            known = self._stands[key] = stand(p, points, normals, self._rules)
        return known

    def _begins(self, place: int) -> bool:
        """Whether rotations may begin at a pose."""
        known = self._begin.get(place)
        if known is None:
            R, p = self._numbered.book.rotations[place], self._numbered.book.positions[place]
            said = may_begin(R, p, self._room, self._rules, self._D)
            known = self._begin[place] = (
                begins(self._stand(place).exempt, p, self._rules) if said < 0 else said > 0
            )
        return known

    def _node(self, place: int, line: Line | None) -> int:
        """Return the node at a pose with this rotation under way."""
        if line is None:
            known = self._resting.get(place)
            if known is None:
                known = self._resting[place] = len(self._nodes)
                self._nodes.append((place, None))
            return known
        nodes, lines = self._turning.get(place, NONE_TURNING)
        row = find(lines, line.point, line.direction, SAME * self._D)
        if row < 0:
            row, new = len(nodes), np.array([line])
            self._turning[place] = ((*nodes, len(self._nodes)), np.concatenate([lines, new]))
            self._nodes.append((place, line))
            return len(self._nodes) - 1
        return nodes[row]

    def in_goal(self, node: int) -> bool:
        """Whether the object has arrived at a node."""
        return self._motion.goal.contains(self.pose(node))

    def pose(self, node: int) -> Pose:
        """Return the object's pose at a node."""
        return self._numbered.pose(self._nodes[node][0])

    def _position(self, node: int) -> Array:
        position: Array = self._numbered.book.positions[self._nodes[node][0]]
        return position

    def coordinates(self, node: int) -> Coordinates:  # noqa: ARG002
        """Return no coordinates: there are none."""
        return ()

    def way(self, nodes: Sequence[int]) -> Way:
        """Return the way past nodes that arcs join, the first of them the start."""
        arcs = []
        for k, (tail, head) in enumerate(itertools.pairwise(nodes), start=1):
            arc = next(arc for arc in self._leaving(tail) if arc.head == head)
            arcs.append(arc.leading_to(k))
        poses = tuple(self.pose(node) for node in nodes)
        return Way(poses, ((),) * len(nodes), tuple(arcs))
