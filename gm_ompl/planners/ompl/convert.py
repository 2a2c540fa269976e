"""The compound state space of a problem, and what its states mean: coordinates and placements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, final

from ompl import base as ob

from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.planar import FULL_TURN
from gm_ompl.problem import Move, Problem
from gm_ompl.sampling.motions import UNPLACED, HybridState
from gm_ompl.sampling.stages import states_along

COORDINATE_WEIGHT = 1.0
"""Two ends of a coordinate's range are this far apart."""

PLACEMENT_WEIGHT = 1.0
"""The first and the last row of the placement table are this far apart."""

LABEL_WEIGHT = 1e-6
"""Far below any difference that means something, far above rounding."""

AUTOMATIC_RANGE = 0.2
"""The share of a space's extent that OMPL takes for the longest motion where none is set."""

LONGER = 1.01
"""The automatic range is this times the longest distance: rounding shortens no motion."""


def make_space(problem: Problem) -> Any:
    """Return OMPL's compound state space for ``problem``.

    Parts, in order: one per coordinate (real, or circular where it has a period), then one
    discrete part per finger: 0 is "not placed yet", k + 1 is row k of the placement table.
    Distances are relative to each coordinate's range, so they do not depend on units.

    Two more parts mean nothing. A label in [0, 1]: states with equal coordinates are often
    equally far from a third, and OMPL then prefers the one at the lower address; without the
    label's tiny share in the distance the same seed would not give the same plan. And a time that
    is 0 in every state, with a large weight: it stretches the space's extent, of which OMPL's
    automatic range is a share, until that range is the longest distance there is. Motions then end
    at the states they were meant for, not at placements that lie between two others in the table.
    """
    space, motion = ob.CompoundStateSpace(), problem.motion
    space.setName(f"{problem.name}: object and placements")
    for name, low, high, period in zip(
        motion.names, motion.low, motion.high, motion.periods, strict=True
    ):
        part, extent = _real(low, high) if period is None else (ob.SO2StateSpace(), FULL_TURN / 2)
        part.setName(name)
        space.addSubspace(part, COORDINATE_WEIGHT / extent)
    add_placements(space, problem)
    add_meaningless(space)
    return space


def add_placements(space: Any, problem: Problem, weight: float = PLACEMENT_WEIGHT) -> None:
    """Add a discrete part per finger to a space."""
    rows = len(problem.fingers.placements)
    for finger in range(problem.fingers.count):
        part = ob.DiscreteStateSpace(0, rows)
        part.setName(f"placement of finger {finger}")
        space.addSubspace(part, weight / rows)


def add_meaningless(space: Any) -> None:
    """Add the two parts that mean nothing to a space, and lock it."""
    label, _ = _real(0.0, 1.0)
    label.setName("label")
    space.addSubspace(label, LABEL_WEIGHT)
    stretch = ob.TimeStateSpace()  # unbounded: its extent is 1, all its samples are 0
    stretch.setName("stretch")
    space.addSubspace(stretch, space.getMaximumExtent() * (LONGER / AUTOMATIC_RANGE - 1.0))
    space.lock()


def longest_motion(space: Any) -> float:
    """Return OMPL's automatic range in a space of ``make_space``: no two states are farther."""
    return AUTOMATIC_RANGE * float(space.getMaximumExtent())


def _real(low: float, high: float) -> tuple[Any, float]:
    part, bounds = ob.RealVectorStateSpace(1), ob.RealVectorBounds(1)
    bounds.setLow(0, low)
    bounds.setHigh(0, high)
    part.setBounds(bounds)
    return part, (high - low) or 1.0


class Codec(ABC):
    """What the states of a problem's compound space mean.

    It keeps no space and no state, so whatever holds it can be freed with its space.

    Attributes:
        problem: what the states are states of.
        start: the start state, as it reads back from OMPL.
        nowhere: a state that is valid nowhere.
    """

    problem: Problem
    start: HybridState
    nowhere: HybridState

    @abstractmethod
    def read(self, state: Any) -> HybridState:
        """Return what an OMPL state means; the state is not kept."""

    @abstractmethod
    def write(self, state: Any, meaning: HybridState, label: float = 0.0) -> None:
        """Make an OMPL state mean ``meaning``; states meant to differ get different labels."""

    def said(self, state: Any) -> HybridState | None:
        """Return what an OMPL state means; None where it is not settled."""
        return self.read(state)

    def meant(self, state: Any, origin: HybridState | None = None) -> HybridState:  # noqa: ARG002
        """Return what a state means once it is settled.

        Args:
            state: the state; where it is not settled, it is changed.
            origin: where a motion to it begins.
        """
        return self.read(state)

    @abstractmethod
    def along(self, moves: Sequence[Move]) -> list[HybridState]:
        """Return the states that moves lead through, first and last included."""

    @property
    @abstractmethod
    def projects(self) -> int:
        """How many numbers a projection has."""

    @abstractmethod
    def projected(self, state: Any) -> list[float]:
        """Return the numbers that tell where the object is, each over its range."""


@final
class CoordinateCodec(Codec):
    """What the states of ``make_space`` mean.

    Args:
        problem: on a path or in the plane.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        motion = problem.motion
        self._d, self._n = motion.dimension, problem.fingers.count
        self._centres = [
            None if period is None else low + period / 2.0
            for low, period in zip(motion.low, motion.periods, strict=True)
        ]
        self._scales = [(period or 0.0) / FULL_TURN for period in motion.periods]
        given = (UNPLACED if row is None else row for row in problem.fingers.start)
        self.start = HybridState(self._as_read(problem.start), tuple(given))
        far = tuple(
            high if high - q >= q - low else low
            for q, low, high in zip(problem.start, motion.low, motion.high, strict=True)
        )
        self.nowhere = HybridState(far, (UNPLACED,) * self._n)

    def read(self, state: Any) -> HybridState:
        """Return what an OMPL state means; the state is not kept."""
        first = self._d
        rows = tuple(state[first + i].value + UNPLACED for i in range(self._n))
        q = tuple(
            state[k][0] if centre is None else centre + state[k].value * self._scales[k]
            for k, centre in enumerate(self._centres)
        )
        return HybridState(q, rows)

    def write(self, state: Any, meaning: HybridState, label: float = 0.0) -> None:
        """Make an OMPL state mean ``meaning``; states meant to differ get different labels."""
        for k, (value, centre) in enumerate(zip(meaning.q, self._centres, strict=True)):
            if centre is None:
                state[k][0] = value
            else:
                state[k].value = self._angle(k, value)
        for i, row in enumerate(meaning.placements):
            state[self._d + i].value = row - UNPLACED
        state[self._d + self._n][0] = label
        state[self._d + self._n + 1].position = 0.0

    def along(self, moves: Sequence[Move]) -> list[HybridState]:
        """Return the states that moves lead through, first and last included."""
        return list(states_along(moves))

    @property
    def projects(self) -> int:
        """The number of coordinates."""
        return self._d

    def projected(self, state: Any) -> list[float]:
        """Return the object's coordinates, each over its range."""
        q, extents = self.read(state).q, self.problem.motion.extents
        return [value / extent for value, extent in zip(q, extents, strict=True)]

    def _angle(self, k: int, value: float) -> float:
        """Return the circular part, in [-pi, pi], that stands for coordinate ``k``."""
        angle = (value - (self._centres[k] or 0.0)) / self._scales[k]
        return angle - FULL_TURN * round(angle / FULL_TURN)

    def _as_read(self, q: Coordinates) -> Coordinates:
        """Return ``q`` as it reads back from a state: wrapped, with that way's rounding."""
        return tuple(
            value if centre is None else centre + self._angle(k, value) * self._scales[k]
            for k, (value, centre) in enumerate(zip(q, self._centres, strict=True))
        )
