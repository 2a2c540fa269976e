"""What the contact lattice offers at a pose: screws of the object, before they are cut short."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import EnvironmentContacts
from gm_ompl.contact.expansion import Offered
from gm_ompl.contact.lines import (
    ContactGroup,
    Line,
    contact_groups,
    distinct,
    is_offered,
    parallel,
    rim_lines,
)
from gm_ompl.motion.free import ContactSteps

ON_GRID: Final = 1e-6
"""A coordinate is on the grid up to this many steps."""

NEAR: Final = 1e-6
"""Lines as near to each other as this, relative to D, are one."""

WORLD = np.eye(3)


class Stand(NamedTuple):
    """How the object stands at a pose, seen from the centre of mass.

    Attributes:
        exempt: the listed world axes along which contact fixes it.
        lines: about which it may turn where rotations begin.
        slopes: unit directions (3,) of contact lines that the listed axes do not offer.
    """

    exempt: frozenset[int]
    lines: tuple[Line, ...]
    slopes: tuple[Array, ...]


ALOFT: Final = Stand(frozenset(), (), ())
"""As where nothing touches, its lines left out."""


@final
class Offers:
    """Lists the motions at a pose, as docs/background/free-motion.md has them.

    Args:
        steps: of the lattice.
        start: (3,), where the grid of translations is counted from, world frame.
        diagonal: D.
        touching: the contact tolerance (a length).
    """

    def __init__(self, steps: ContactSteps, start: Array, diagonal: float, touching: float) -> None:
        self._steps, self._start = steps, start.tolist()
        self._near, self._touching = NEAR * diagonal, touching
        self._listed = WORLD[list(steps.translate)]
        self._turning_axes = [axis for axis in WORLD if self._turns(axis)]

    def _turns(self, direction: Array) -> bool:
        """Whether the object may turn about lines of this direction (3,)."""
        allowed = self._steps.rotate
        return allowed is None or any(parallel(direction, axis) for axis in allowed)

    def stand(self, position: Array, contacts: EnvironmentContacts) -> Stand:
        """Return how the object stands with its centre of mass at a position (3,)."""
        groups = contact_groups(contacts, self._touching)
        exempt = frozenset(
            k for k in self._steps.translate if any(parallel(g.normal, WORLD[k]) for g in groups)
        )
        lines = (
            Line(line.point - position, line.direction) for line in self._lines(position, groups)
        )
        return Stand(exempt, tuple(distinct(lines, self._near)), tuple(self._slopes(groups)))

    def counts(self, position: Sequence[float]) -> list[float]:
        """Return the listed coordinates of a position (3,), in steps from the start."""
        step = self._steps.translation
        return [(position[k] - self._start[k]) / step for k in self._steps.translate]

    def begins(self, stand: Stand, position: Sequence[float]) -> bool:
        """Whether rotations may begin: the listed coordinates that are free are on the grid."""
        counts = zip(self._steps.translate, self.counts(position), strict=True)
        return all(k in stand.exempt or abs(c - round(c)) <= ON_GRID for k, c in counts)

    def at(self, stand: Stand, position: Sequence[float], under_way: Line | None) -> Offered:
        """Return the motions that are offered.

        Args:
            stand: how the object stands.
            position: (3,), where its centre of mass is.
            under_way: the line of a rotation that may go on, seen from there.
        """
        step, slides = self._steps.translation, list[tuple[Array, float]]()
        for k, count in zip(self._steps.translate, self.counts(position), strict=True):
            for target in (np.floor(count + ON_GRID) + 1.0, np.ceil(count - ON_GRID) - 1.0):
                by = np.zeros(3)
                by[k] = self._start[k] + target * step - position[k]
                slides.append((by, min(1.0, abs(float(by[k])) / step)))
        slides += [(sign * step * way, 1.0) for way in stand.slopes for sign in (1.0, -1.0)]
        if self.begins(stand, position):
            lines = stand.lines
        else:
            lines = () if under_way is None else (under_way,)
        turns = list(itertools.product(lines, (self._steps.rotation, -self._steps.rotation)))
        up = WORLD[2]
        return Offered(
            np.array([False] * len(slides) + [True] * len(turns), dtype=np.bool_),
            np.array([by for by, _ in slides] + [line.point for line, _ in turns]).reshape(-1, 3),
            np.array([up] * len(slides) + [line.direction for line, _ in turns]).reshape(-1, 3),
            np.array([0.0] * len(slides) + [angle for _, angle in turns]),
            np.array([steps for _, steps in slides] + [1.0] * len(turns)),
        )

    def _lines(self, position: Array, groups: Sequence[ContactGroup]) -> Iterator[Line]:
        if not groups:
            yield from (Line(position, axis) for axis in self._turning_axes)
        for group in groups:
            for line in rim_lines(group, self._turning_axes, self._touching):
                if self._turns(line.direction):
                    yield line
        for group in groups:
            if self._turns(group.normal):
                yield Line(position, group.normal)

    def _slopes(self, groups: Sequence[ContactGroup]) -> list[Array]:
        """Return directions of contact lines that the listed axes do not offer."""
        found = list[Array]()
        for group in groups:
            for line in rim_lines(group, (), self._touching):
                known = any(parallel(line.direction, other) for other in found)
                if known or is_offered(line.direction, group.normal, self._listed):
                    continue
                if not any(parallel(line.direction, axis) for axis in self._listed):
                    found.append(line.direction)
        return found
