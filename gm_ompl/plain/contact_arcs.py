"""The arcs that leave a pose of the contact lattice, stated plainly (background/free-motion.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.contact.environment import Environment, EnvironmentContacts, environment_contacts
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.screw import Piece, Screw, Slide, Tumble
from gm_ompl.plain.contact_lines import (
    SAME,
    Group,
    PlainLine,
    contact_lines,
    distinct,
    groups,
    parallel,
)
from gm_ompl.plain.early_ends import WHOLE, EarlyEnds

ON_GRID = 1e-6
"""How far a coordinate may be off the grid of translations, in steps."""


@dataclass(frozen=True, eq=False)
class PlainStand:
    """A pose with what its contacts say.

    Attributes:
        pose: where the object is.
        groups: the contacts by normal and plane.
        lines: those about which it may turn: contact lines and turning lines, or those through
            the centre of mass where nothing touches.
        begins: whether rotations may begin here.
    """

    pose: Pose
    groups: tuple[Group, ...]
    lines: tuple[PlainLine, ...]
    begins: bool


@dataclass(frozen=True, eq=False)
class PlainOffer:
    """An arc that the contact lattice has, or would have in a wider region.

    Attributes:
        arc: the motion, from the pose where it begins to where it ends.
        parts: in how many segments it is judged.
        line: about which it turns; None for a translation.
        inside: whether the centre of mass stays in the region; else the lattice lacks it.
    """

    arc: Screw
    parts: int
    line: PlainLine | None
    inside: bool


class ContactArcs:
    """Which arcs leave a pose.

    Args:
        body: the object, object frame.
        environment: floor and obstacles.
        motion: start, region and steps.
        samples: P, segments per step.
    """

    def __init__(
        self, body: Body, environment: Environment, motion: FreeMotion, samples: int
    ) -> None:
        self._body, self._environment, self._motion = body, environment, motion
        self._samples, self._steps, self._D = samples, motion.steps, body.diagonal
        self._tolerance = environment.contact_tolerance * self._D
        self._ends = EarlyEnds(body, environment)

    def stand(self, pose: Pose) -> PlainStand:
        """Return what the contacts at ``pose`` say."""
        contacts = environment_contacts(self._body, self._environment, pose)
        found = groups(contacts, self._tolerance)
        lines = [line for group in found for line in contact_lines(group, self._tolerance)]
        lines += [PlainLine(pose.position, group.normal) for group in found]
        if not found:
            lines = [PlainLine(pose.position, axis) for axis in np.eye(3)]
        turned = distinct([line for line in lines if self._listed(line)], self._D)
        return PlainStand(pose, tuple(found), tuple(turned), self._begins(pose, contacts))

    def offers(self, stand: PlainStand, under_way: PlainLine | None) -> Iterator[PlainOffer]:
        """Yield the arcs that leave a pose, in the order of the rules, those out of the region too.

        Args:
            stand: the pose.
            under_way: the line about which the object was turning when it came here; None
                where rotations may begin.
        """
        for axis, by in self._translations(stand.pose):
            yield from self._offer(stand.pose, Slide(by), float(abs(by[axis])), None)
        step = self._steps.translation
        for direction in self._slopes(stand):
            for sign in (1.0, -1.0):
                yield from self._offer(stand.pose, Slide(sign * step * direction), step, None)
        lines = stand.lines if stand.begins else () if under_way is None else (under_way,)
        for line in lines:
            for angle in (self._steps.rotation, -self._steps.rotation):
                turn = Tumble(line.point, line.direction, angle)
                yield from self._offer(stand.pose, turn, self._steps.rotation, line)

    def under_way(self, head: PlainStand, line: PlainLine | None) -> PlainLine | None:
        """Return the rotation under way at ``head``, where an arc about ``line`` led."""
        return None if head.begins else line

    def in_region(self, start: Pose, piece: Piece) -> bool:
        """Whether the centre of mass stays in the region all along."""
        slack = SAME * self._D
        low, high = self._motion.region[0] - slack, self._motion.region[1] + slack
        if isinstance(piece, Slide):
            places = np.array([start.position, start.position + piece.by])
            return bool((places >= low).all() and (places <= high).all())
        arm = start.position - piece.pivot
        along = (arm @ piece.axis) * piece.axis
        out, side = arm - along, cross(piece.axis, arm)
        # A coordinate is m + a cos(u) + b sin(u); it is greatest and least where tan(u) = b / a.
        turns = [0.0, piece.angle]
        for a, b in zip(out, side, strict=True):
            for k in range(-2, 3):
                u = math.atan2(b, a) + k * math.pi
                turns += [u] if min(0.0, piece.angle) < u < max(0.0, piece.angle) else []
        angles = np.array(turns)[:, None]
        places = piece.pivot + along + np.cos(angles) * out + np.sin(angles) * side
        return bool((places >= low).all() and (places <= high).all())

    def slides_along(self, stand: PlainStand, direction: Array) -> bool:
        """Whether a direction (3,) is that of a line on which contacts of a pose lie."""
        lines = (
            line
            for group in stand.groups
            if len(group.points) > 1
            for line in contact_lines(group, self._tolerance)
        )
        return any(parallel(line.direction, direction) for line in lines)

    def _offer(
        self, start: Pose, whole: Piece, length: float, line: PlainLine | None
    ) -> Iterator[PlainOffer]:
        """Yield the arc that follows ``whole``, of a length in its own unit, if there is one."""
        t = self._ends.end(start, whole)
        if t == 0.0:
            return
        piece: Piece = whole
        if t < 1.0 and isinstance(whole, Tumble):
            piece = Tumble(whole.pivot, whole.axis, t * whole.angle)
        elif t < 1.0 and isinstance(whole, Slide):
            piece = Slide(t * whole.by)
        inside = self.in_region(start, piece)
        step = self._steps.translation if line is None else self._steps.rotation
        steps, ends = t * length / step, self._motion.ends
        if steps >= 1.0 - WHOLE:
            yield PlainOffer(Screw(start, piece, ends=ends), self._samples, line, inside)
            return
        parts = max(2 if ends else 1, math.ceil(self._samples * steps - WHOLE))
        pitch = 1.0 / (self._samples * steps)
        yield PlainOffer(Screw(start, piece, pitch=pitch, ends=ends), parts, line, inside)

    def _translations(self, pose: Pose) -> Iterator[tuple[int, Array]]:
        """Yield, per listed axis and sense, the way to the next multiple of the step."""
        step, origin = self._steps.translation, self._motion.start.position
        for axis in self._steps.translate:
            place = float(pose.position[axis] - origin[axis])
            for sign in (1.0, -1.0):
                following = sign * (math.floor(sign * place / step + ON_GRID) + 1)
                by = np.zeros(3)
                by[axis] = following * step - place
                yield axis, by

    def _slopes(self, stand: PlainStand) -> list[Array]:
        """Return directions of contact lines that the listed axes do not offer."""
        found: list[Array] = []
        for group in stand.groups:
            other = [
                axis
                for axis in range(3)
                if axis not in self._steps.translate or abs(group.normal[axis]) > SAME
            ]
            for line in contact_lines(group, self._tolerance):
                offered = np.linalg.norm(line.direction[other]) <= SAME
                if not offered and not any(parallel(line.direction, known) for known in found):
                    found.append(line.direction)
        return found

    def _listed(self, line: PlainLine) -> bool:
        rotate = self._steps.rotate
        return rotate is None or any(parallel(line.direction, axis) for axis in rotate)

    def _begins(self, pose: Pose, contacts: EnvironmentContacts) -> bool:
        """Whether the listed coordinates are on the grid, but for those that a contact fixes."""
        for axis in self._steps.translate:
            if any(parallel(normal, np.eye(3)[axis]) for normal in contacts.normals):
                continue
            place = pose.position[axis] - self._motion.start.position[axis]
            if abs(math.remainder(place / self._steps.translation, 1.0)) > ON_GRID:
                return False
        return True
