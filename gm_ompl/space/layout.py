"""The compound state space of a problem: one part per coordinate, one per finger."""

from __future__ import annotations

from typing import Any

from ompl import base as ob

from gm_ompl.motion.planar import FULL_TURN
from gm_ompl.problem import Problem

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
