"""Screws of any length that the object may make from a pose of free motion, ended where it must.

The contact lattice offers whole steps; here a motion goes as far as it helps, or to the first new
contact, exactly.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.expansion import Offered, Room, ended
from gm_ompl.contact.poses import NumberedPoses
from gm_ompl.contact.stops import lengths
from gm_ompl.geometry.packed import packed
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import SHORTEST, SLACK, FreeMotion
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.motion.screw import Piece, Screw, Slide, Tumble
from gm_ompl.problem import Problem
from gm_ompl.sampling.contacts import Ways, subsets, touching

WORLD: Final = np.eye(3)

WHOLE: Final = 1e-9
"""What lacks so little of a number of steps is that number."""

DECIMALS: Final = 9
"""Forms equal to so many decimals (in D, or radians) are one."""

NONE: Final = 1e-9
"""A translation shorter than this, relative to D, or a turn smaller than this [rad], is none."""

ROUNDING: Final = 1e-14
"""A coordinate of a way that is so much smaller than the greatest is what projecting it leaves."""

FARTHEST: Final = math.pi
"""A turn that is to end at a contact goes no farther [rad]."""


class Leap(NamedTuple):
    """A screw from a pose.

    Attributes:
        tail: the number of the pose where it begins.
        piece: the motion.
        steps: its length in steps of the lattice.
        end: where it ends.
        bare: whether the object touches nothing in the middle of some segment.
    """

    tail: int
    piece: Piece
    steps: float
    end: Pose
    bare: bool


class Stride(NamedTuple):
    """At most a step of a leap: an arc, judged by itself.

    Attributes:
        arc: the motion; its head is the number of the pose where it ends.
        tail: the number of the pose where it begins.
    """

    arc: GraphArc
    tail: int


@final
class Screws:
    """Poses by numbers, and the screws that lead on from them.

    Args:
        problem: of free motion.

    Attributes:
        motion: its motion.
        start: the number of the pose at the start.
    """

    def __init__(self, problem: Problem) -> None:
        assert isinstance(problem.motion, FreeMotion), "other motions have coordinates"
        self.motion, self._problem, body = problem.motion, problem, problem.body
        self._D, self._P = body.diagonal, problem.cost.samples_per_arc
        environment, steps = problem.environment, self.motion.steps
        small = lengths(self._D, environment.contact_tolerance)
        fixed = packed([piece for o in environment.obstacles for piece in o.body.pieces])
        shortest = SHORTEST * self._D
        self._room = Room(packed(body.pieces), fixed, environment.floor, small, shortest, self._P)
        self._book = NumberedPoses(self._D)
        self._ways: dict[Hashable, Ways] = {}
        self._projections: dict[bytes, list[Array]] = {}
        listed = [k for k in range(3) if k not in steps.translate]
        self._barred = WORLD[listed]
        own = float(np.linalg.norm(body.vertices, axis=1).max())
        self._reach = max(own, problem.fingers.reach)
        self.start = self.number(self.motion.start)

    def number(self, pose: Pose) -> int:
        """Return the number of a pose: the first one found stands for all next to it."""
        return self._book.number(pose.rotation, pose.position)

    def pose(self, place: int) -> Pose:
        """Return the pose of a number."""
        return self._book.pose(place)

    def ways(self, place: int) -> Ways:
        """Return how the object touches at a pose."""
        key = self._stands(place)
        known = self._ways.get(key)
        if known is None:
            problem, rotate = self._problem, self.motion.steps.rotate
            body, environment = problem.body, problem.environment
            known = self._ways[key] = touching(body, environment, self.pose(place), rotate)
        return known

    def _stands(self, place: int) -> Hashable:
        """Return what is equal where the object stands alike on the floor, nothing being near."""
        book = self._book.book
        low, high = self._room.obstacles.low, self._room.obstacles.high
        way = np.minimum(np.maximum(book.positions[place], low), high) - book.positions[place]
        far = self._reach + self.motion.steps.translation + self._room.lengths.touching
        if (np.einsum("ij,ij->i", way, way) <= (1.5 * far) ** 2).any():
            return place
        height = int(book.heights[place]) if self._room.floor else 0
        return int(book.attitudes[place]), height

    def towards(self, place: int, target: Pose) -> list[Leap]:
        """Return the leaps from a pose that bring the object nearer to a target in some way.

        Translations by what contacts that are kept leave of the way there, turns by what brings
        the object nearest to how it must be turned, or up to the next contact.
        """
        return self._ended(place, [*self._slides(place, target), *self._tumbles(place, target)])

    def _slides(self, place: int, target: Pose) -> Iterator[Piece]:
        ways, way = self.ways(place), target.position - self.pose(place).position
        found = [left @ way for left in self._left(ways.normals)]
        found += [axis * (axis @ way) for axis in WORLD[list(self.motion.steps.translate)]]
        if len(self._barred):
            found += [slope * (slope @ way) for slope in ways.slopes]
        made = list[Array]()
        for by in found:
            if np.abs(by).max() <= NONE * self._D:
                continue
            by = np.where(np.abs(by) <= ROUNDING * np.abs(by).max(), 0.0, by)
            if not any(np.abs(by - other).max() <= NONE * self._D for other in made):
                made.append(by)
                yield Slide(by)

    def _left(self, normals: Array) -> list[Array]:
        """Return what contacts that are kept leave of translations: projections (3, 3)."""
        key = normals.tobytes()
        if key not in self._projections:
            held = [np.concatenate([kept, self._barred]) for kept in subsets(normals)]
            self._projections[key] = [WORLD - np.linalg.pinv(rows) @ rows for rows in held]
        return self._projections[key]

    def _tumbles(self, place: int, target: Pose) -> Iterator[Piece]:
        pose = self.pose(place)
        turn = Pose(target.rotation @ pose.rotation.T, pose.position).quaternion()
        lines = list(self.ways(place).lines)
        for line in lines:
            angle = 2.0 * math.atan2(float(turn[1:] @ line.direction), float(turn[0]))
            angle = math.remainder(angle, 2.0 * math.pi)
            angles = [FARTHEST, -FARTHEST]
            if abs(angle) > NONE and abs(abs(angle) - FARTHEST) > NONE:
                angles.append(angle)
            for one in angles:
                yield Tumble(line.point + pose.position, line.direction, one)

    def _ended(self, place: int, pieces: Sequence[Piece]) -> list[Leap]:
        """Return what motions from a pose come to; those that come to nothing are left out."""
        if not pieces:
            return []
        pose, steps = self.pose(place), self.motion.steps
        turns = [isinstance(piece, Tumble) for piece in pieces]
        by = [p.pivot - pose.position if isinstance(p, Tumble) else p.by for p in pieces]
        axes = [p.axis if isinstance(p, Tumble) else WORLD[2] for p in pieces]
        angles = [p.angle if isinstance(p, Tumble) else 0.0 for p in pieces]
        whole = [
            abs(p.angle) / steps.rotation
            if isinstance(p, Tumble)
            else float(np.linalg.norm(p.by)) / steps.translation
            for p in pieces
        ]
        offered = Offered(
            np.array(turns, dtype=np.bool_), np.array(by), np.array(axes), np.array(angles),
            np.array(whole),
        )  # fmt: skip
        book = self._book.book  # arrays that compiled code knows as the lattice's
        found = ended(offered, book.rotations[place], book.positions[place], self._room)
        slack, (low, high) = SLACK * self._D, self.motion.region - pose.position
        inside = (found.low >= low - slack).all(axis=1) & (found.high <= high + slack).all(axis=1)
        leaps = []
        for i, piece in enumerate(pieces):
            share = float(found.shares[i])
            if share <= 0.0:
                continue
            if not inside[i]:
                share = share * self._inside(pose, piece, share)
                if share * whole[i] <= NONE:
                    continue
            if isinstance(piece, Tumble):
                part: Piece = Tumble(piece.pivot, piece.axis, share * piece.angle)
            else:
                part = piece if share == 1.0 else Slide(share * piece.by)
            end, bare = part.pose(pose, 1.0), bool(found.bare[i])
            leaps.append(Leap(place, part, share * whole[i], end, bare))
        return leaps

    def _inside(self, pose: Pose, piece: Piece, share: float) -> float:
        """Return the part of a share of a motion along which the region holds the object."""
        low, high = self.motion.region
        if isinstance(piece, Tumble):
            return 0.0
        ahead = share * piece.by
        part = 1.0
        for k in range(3):
            room = (high if ahead[k] > 0.0 else low)[k] - pose.position[k]
            if abs(ahead[k]) > NONE * self._D:
                part = min(part, max(0.0, room / ahead[k]))
        return part

    def strides(self, leap: Leap) -> list[Stride]:
        """Return a leap as strides of a step, the last one shorter."""
        count = max(1, math.ceil(leap.steps - WHOLE))
        whole = count if abs(leap.steps - count) <= WHOLE else leap.steps
        tail, strides = leap.tail, list[Stride]()
        for k in range(count):
            part = min(1.0, whole - k) / whole
            start = self.pose(tail)
            if isinstance(leap.piece, Slide):
                piece: Piece = Slide(part * leap.piece.by)
            else:
                piece = Tumble(leap.piece.pivot, leap.piece.axis, part * leap.piece.angle)
            end = leap.end if k == count - 1 else piece.pose(start, 1.0)
            head = self.number(end)
            strides.append(Stride(self._arc(tail, head, piece), tail))
            tail = head
        return strides

    def _arc(self, tail: int, head: int, piece: Piece) -> GraphArc:
        steps = self.motion.steps
        if isinstance(piece, Tumble):
            length = abs(piece.angle) / steps.rotation
        else:
            length = float(np.linalg.norm(piece.by)) / steps.translation
        pitch, parts = None, self._P
        if length < 1.0 - WHOLE:
            parts = max(self.motion.fewest, math.ceil(self._P * length - WHOLE))
            pitch = 1.0 / (self._P * length)
        stands, kind = self._stands(tail), None
        if stands != tail:
            kind = (stands, *self._form(self.pose(tail), piece))
        screw = Screw(self.pose(tail), piece, pitch=pitch, ends=self.motion.ends)
        return GraphArc(head, screw, parts, kind)

    def _form(self, pose: Pose, piece: Piece) -> tuple[float, ...]:
        """Return what is equal for motions that are one as the object sees them."""
        if isinstance(piece, Slide):
            own = piece.by @ pose.rotation / self._D
            return tuple((np.round(own, DECIMALS) + 0.0).tolist())
        arm = piece.pivot - pose.position
        arm = arm - (arm @ piece.axis) * piece.axis
        numbers = [*(arm @ pose.rotation / self._D), *(piece.axis @ pose.rotation), piece.angle]
        return tuple((np.round(numbers, DECIMALS) + 0.0).tolist())
