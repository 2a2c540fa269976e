"""What the contact lattice offers at a pose: screws of the object, before they are cut short."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import EnvironmentContacts
from gm_ompl.contact.lines import (
    ContactGroup,
    Line,
    contact_groups,
    distinct,
    is_offered,
    parallel,
    rim_lines,
)
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.free import ContactSteps
from gm_ompl.motion.screw import Piece, Slide, Tumble

ON_GRID: Final = 1e-6
"""A coordinate is on the grid up to this many steps."""

NEAR: Final = 1e-6
"""Lines as near to each other as this, relative to D, are one."""

WORLD = np.eye(3)


class Offer(NamedTuple):
    """One motion.

    Attributes:
        piece: the whole of it.
        line: of a rotation; None for translations.
        steps: its length in steps of the lattice, at most one.
    """

    piece: Piece
    line: Line | None
    steps: float


@final
class Offers:
    """Lists the motions at a pose, as docs/free-motion.md has them.

    Args:
        steps: of the lattice.
        start: (3,), where the grid of translations is counted from, world frame.
        diagonal: D.
        touching: the contact tolerance (a length).
    """

    def __init__(self, steps: ContactSteps, start: Array, diagonal: float, touching: float) -> None:
        self._steps, self._start = steps, start
        self._near, self._touching = NEAR * diagonal, touching
        self._listed = WORLD[list(steps.translate)]
        self._turning_axes = [axis for axis in WORLD if self._turns(axis)]

    def _turns(self, direction: Array) -> bool:
        """Whether the object may turn about lines of this direction (3,)."""
        allowed = self._steps.rotate
        return allowed is None or any(parallel(direction, axis) for axis in allowed)

    def at(
        self, pose: Pose, contacts: EnvironmentContacts, under_way: Line | None
    ) -> Iterator[Offer]:
        """Yield the motions that are offered at ``pose``.

        Args:
            pose: where the object is.
            contacts: there.
            under_way: the line of a rotation that may go on.
        """
        groups = contact_groups(contacts, self._touching)
        yield from self._axial(pose)
        yield from self._slopes(groups)
        for line in self.lines(pose, groups, under_way):
            for turn in (self._steps.rotation, -self._steps.rotation):
                yield Offer(Tumble(line.point, line.direction, turn), line, 1.0)

    def lines(
        self, pose: Pose, groups: Sequence[ContactGroup], under_way: Line | None
    ) -> list[Line]:
        """Return the lines about which the object may turn by a step."""
        if not self.begins(pose, groups):
            return [] if under_way is None else [under_way]
        return distinct(self._lines(pose, groups), self._near)

    def begins(self, pose: Pose, groups: Sequence[ContactGroup]) -> bool:
        """Whether rotations may begin: the listed coordinates that are free are on the grid."""
        for k in self._steps.translate:
            if any(parallel(group.normal, WORLD[k]) for group in groups):
                continue
            count = (pose.position[k] - self._start[k]) / self._steps.translation
            if abs(count - round(count)) > ON_GRID:
                return False
        return True

    def _lines(self, pose: Pose, groups: Sequence[ContactGroup]) -> Iterator[Line]:
        if not groups:
            yield from (Line(pose.position, axis) for axis in self._turning_axes)
        for group in groups:
            for line in rim_lines(group, self._turning_axes, self._touching):
                if self._turns(line.direction):
                    yield line
        for group in groups:
            if self._turns(group.normal):
                yield Line(pose.position, group.normal)

    def _axial(self, pose: Pose) -> Iterator[Offer]:
        """Yield translations along the listed axes, each to the next multiple of the step."""
        step = self._steps.translation
        for k in self._steps.translate:
            count = float(pose.position[k] - self._start[k]) / step
            ahead, behind = np.floor(count + ON_GRID) + 1.0, np.ceil(count - ON_GRID) - 1.0
            for target in (ahead, behind):
                by = np.zeros(3)
                by[k] = self._start[k] + target * step - pose.position[k]
                yield Offer(Slide(by), None, min(1.0, abs(float(by[k])) / step))

    def _slopes(self, groups: Sequence[ContactGroup]) -> Iterator[Offer]:
        """Yield translations along contact lines that the listed axes do not offer."""
        step, found = self._steps.translation, list[Array]()
        for group in groups:
            for line in rim_lines(group, (), self._touching):
                known = any(parallel(line.direction, other) for other in found)
                if known or is_offered(line.direction, group.normal, self._listed):
                    continue
                if any(parallel(line.direction, axis) for axis in self._listed):
                    continue
                found.append(line.direction)
                for by in (step * line.direction, -step * line.direction):
                    yield Offer(Slide(by), None, 1.0)
