"""The compound state space of a problem, and what its states mean: coordinates and placements."""

from __future__ import annotations

from typing import Any, final

from ompl import base as ob

from gm_ompl.motion.lattice import Coordinates
from gm_ompl.motion.planar import FULL_TURN
from gm_ompl.problem import Problem
from gm_ompl.sampling.motions import UNPLACED, HybridState

COORDINATE_WEIGHT = 1.0
"""Two ends of a coordinate's range are this far apart."""

PLACEMENT_WEIGHT = 1.0
"""The first and the last row of the placement table are this far apart."""

LABEL_WEIGHT = 1e-6
"""Far below any difference that means something, far above rounding."""


def make_space(problem: Problem) -> Any:
    """Return OMPL's compound state space for ``problem``.

    Parts, in order: one per coordinate (real, or circular where it has a period), then one
    discrete part per finger: 0 is "not placed yet", k + 1 is row k of the placement table.
    Distances are relative to each coordinate's range, so they do not depend on units.

    The last part, a label in [0, 1], means nothing. States with equal coordinates are often
    equally far from a third, and OMPL then prefers the one at the lower address: without the
    label's tiny share in the distance the same seed would not give the same plan.
    """
    space, motion = ob.CompoundStateSpace(), problem.motion
    space.setName(f"{problem.name}: object and placements")
    for name, low, high, period in zip(
        motion.names, motion.low, motion.high, motion.periods, strict=True
    ):
        part, extent = _real(low, high) if period is None else (ob.SO2StateSpace(), FULL_TURN / 2)
        part.setName(name)
        space.addSubspace(part, COORDINATE_WEIGHT / extent)
    rows = len(problem.fingers.placements)
    for finger in range(problem.fingers.count):
        part = ob.DiscreteStateSpace(0, rows)
        part.setName(f"placement of finger {finger}")
        space.addSubspace(part, PLACEMENT_WEIGHT / rows)
    label, _ = _real(0.0, 1.0)
    label.setName("label")
    space.addSubspace(label, LABEL_WEIGHT)
    space.lock()
    return space


def _real(low: float, high: float) -> tuple[Any, float]:
    part, bounds = ob.RealVectorStateSpace(1), ob.RealVectorBounds(1)
    bounds.setLow(0, low)
    bounds.setHigh(0, high)
    part.setBounds(bounds)
    return part, (high - low) or 1.0


@final
class Codec:
    """What the states of a problem's compound space (``make_space``) mean.

    It keeps no space and no state, so whatever holds it can be freed with its space.

    Attributes:
        problem: what the states are states of.
        start: the start state, as it reads back from OMPL.
        nowhere: a state that is valid nowhere: no finger is placed, the object not at the start.
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
