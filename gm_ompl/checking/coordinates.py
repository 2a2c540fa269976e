"""Object coordinates: equality, bounds, and how much of the lattice an arc spans."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.motion.lattice import Goal
from gm_ompl.problem import Problem

MAX_TURNS = 1e4
"""A coordinate that wraps may be unwrapped this far; beyond, rounding would blur it."""


def gap(problem: Problem, a: Sequence[float], b: Sequence[float]) -> float:
    """Return the largest difference between ``a`` and ``b``, each over its coordinate's range.

    Coordinates that wrap are compared up to whole periods. Infinite where the numbers of
    coordinates differ.
    """
    if len(a) != len(b):
        return math.inf
    worst = 0.0
    for u, v, extent, period in zip(
        a, b, problem.motion.extents, problem.motion.periods, strict=True
    ):
        difference = u - v
        if period is not None:
            difference = math.remainder(difference, period)
        worst = max(worst, abs(difference) / extent)
    return worst


def outside(problem: Problem, q: Sequence[float]) -> float:
    """Return how far ``q`` is out of bounds, over the coordinate's range; 0 inside.

    A coordinate that wraps has no bounds, up to ``MAX_TURNS`` of its period.
    """
    motion, worst = problem.motion, 0.0
    for value, low, high, extent, period in zip(
        q, motion.low, motion.high, problem.motion.extents, motion.periods, strict=True
    ):
        if period is None:
            worst = max(worst, (low - value) / extent, (value - high) / extent)
        else:
            worst = max(worst, abs(value - low) / extent - MAX_TURNS)
    return worst


def in_goal(problem: Problem, q: Sequence[float], tolerance: float) -> bool:
    """Whether ``q`` lies in the goal; ``tolerance`` is relative to the coordinates' ranges."""
    goal = problem.goal
    return all(
        Goal((low,), (high,), (period,)).contains((value,), tolerance * extent)
        for value, low, high, period, extent in zip(
            q, goal.low, goal.high, goal.periods, problem.motion.extents, strict=True
        )
    )


def crossed(
    problem: Problem, start: Sequence[float], end: Sequence[float], tolerance: float
) -> float | None:
    """Return a piece boundary strictly between ``start`` and ``end``, or None."""
    for u, v, extent, values in zip(
        start, end, problem.motion.extents, problem.motion.breakpoints, strict=True
    ):
        margin = tolerance * extent
        for value in values:
            if min(u, v) + margin < value < max(u, v) - margin:
                return value
    return None


def lattice_steps(problem: Problem, start: Sequence[float], end: Sequence[float]) -> float:
    """Return how many lattice steps the straight line spans: the most over the coordinates."""
    lattice = problem.lattice
    return max(
        abs(_index(axis, period, v) - _index(axis, period, u))
        for axis, period, u, v in zip(lattice.axes, lattice.periods, start, end, strict=True)
    )


def _index(axis: Array, period: float | None, value: float) -> float:
    """Return the fractional node number of ``value``; it grows evenly beyond a bounded axis."""
    if period is not None:
        turns = math.floor((value - float(axis[0])) / period)
        knots, inside = np.append(axis, axis[0] + period), value - turns * period
        return turns * len(axis) + float(np.interp(inside, knots, np.arange(len(knots))))
    if len(axis) < 2:
        return 0.0
    below = float(min(value - axis[0], 0.0) / (axis[1] - axis[0]))
    above = float(max(value - axis[-1], 0.0) / (axis[-1] - axis[-2]))
    inside = float(np.interp(value, axis, np.arange(len(axis))))
    return inside + below + above
