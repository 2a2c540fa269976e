"""Straight motions of the object at any coordinates, judged as densely as the lattice does."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.decision import ModeDecision
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.tables import claim_tables
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.motion.object_graph import Way, way_along
from gm_ompl.problem import Placements, Problem

WHOLE_STEPS = 1e-7
"""An arc this little over a whole number of lattice steps spans that number."""

SAME_COORDINATE = 1e-12
"""Coordinates closer than this, relative to their range, are the same."""


def lattice_steps(problem: Problem, start: Sequence[float], end: Sequence[float]) -> float:
    """Return how many lattice steps a straight line spans: the most over the coordinates."""
    lattice = problem.lattice
    return max(
        abs(_position(axis, period, v) - _position(axis, period, u))
        for axis, period, u, v in zip(lattice.axes, lattice.periods, start, end, strict=True)
    )


def _position(axis: Array, period: float | None, value: float) -> float:
    """Return the fractional node number of ``value``, growing evenly beyond the axis."""
    if len(axis) < 2:
        return 0.0
    if period is not None:
        turns = math.floor((value - float(axis[0])) / period)
        knots = np.append(axis, axis[0] + period)
        here = float(np.interp(value - turns * period, knots, np.arange(len(knots))))
        return turns * len(axis) + here
    before = min(value - float(axis[0]), 0.0) / float(axis[1] - axis[0])
    behind = max(value - float(axis[-1]), 0.0) / float(axis[-1] - axis[-2])
    return float(np.interp(value, axis, np.arange(len(axis)))) + before + behind


def strides_needed(problem: Problem, start: Sequence[float], end: Sequence[float]) -> int:
    """Return into how many strides of at most one lattice step a straight line divides."""
    return max(1, math.ceil(lattice_steps(problem, start, end) - WHOLE_STEPS))


def same(problem: Problem, a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether two coordinates are equal, whole periods and rounding apart."""
    for u, v, extent, period in zip(
        a, b, problem.motion.extents, problem.motion.periods, strict=True
    ):
        off = v - u if period is None else math.remainder(v - u, period)
        if abs(off) > SAME_COORDINATE * extent:
            return False
    return True


def unwrapped(problem: Problem, q: Coordinates, near: Coordinates) -> Coordinates:
    """Return ``q`` moved by the whole periods that bring it closest to ``near``."""
    return tuple(
        v if period is None else u + math.remainder(v - u, period)
        for u, v, period in zip(near, q, problem.motion.periods, strict=True)
    )


def split(problem: Problem, start: Coordinates, end: Coordinates) -> list[Coordinates]:
    """Return the ends of the parts of a straight line that span no piece boundary."""
    cuts = set()
    for d, values in enumerate(problem.motion.breakpoints):
        margin = SAME_COORDINATE * problem.motion.extents[d]
        low, high = sorted((start[d], end[d]))
        for value in values:
            if low + margin < value < high - margin:
                cuts.add(((value - start[d]) / (end[d] - start[d]), d, value))
    points = [start]
    for fraction, d, value in sorted(cuts):
        point = between(start, end, fraction)
        points.append((*point[:d], value, *point[d + 1 :]))
    return [*points, end]


def polyline(problem: Problem, points: Sequence[Coordinates], finer: int = 1) -> Way:
    """Return the way along a polyline, in strides of at most a lattice step.

    Args:
        problem: the problem.
        points: corners, unwrapped, no two in a row equal.
        finer: strides per lattice step.
    """
    places = [points[0]]
    for a, b in itertools.pairwise(points):
        for start, end in itertools.pairwise(split(problem, a, b)):
            strides = finer * strides_needed(problem, start, end)
            claim_tables(problem, strides, "a way")
            places += [between(start, end, k / strides) for k in range(1, strides + 1)]
    return way_along(problem.motion, tuple(places), problem.cost.samples_per_arc)


@final
class RouteLine:
    """A straight motion within one piece, divided into segments (Sec. 4.2), judged on demand.

    Args:
        judge: answers about the problem.
        start: coordinates of its tail.
        end: of its head, unwrapped.
        parts: number of equal segments.

    Attributes:
        start: likewise.
        end: likewise.
        parts: likewise.
        arc: the object's motion.
        middles: of the segments.
    """

    def __init__(self, judge: Judge, start: Coordinates, end: Coordinates, parts: int) -> None:
        self._judge = judge
        self.start, self.end, self.parts = start, end, parts
        self.arc = judge.problem.motion.arc(start, end)
        self.middles = self.arc.middles(parts)

    def environment(self, segment: int) -> int:
        """Return the back end's number of the contact state at a segment's midpoint."""
        return self._judge.environment(self.middles[segment])

    def admits(self, placements: Placements) -> bool:
        """Whether object and fingertips penetrate nothing anywhere along it."""
        judge = self._judge
        if not judge.apart(placements):
            return False
        # Each by itself costs little and mostly fails where the whole does.
        ends = (self.arc.start, self.arc.end)
        if not all(judge.node(pose).admits(placements) for pose in ends):
            return False
        return judge.along(self.arc).admits(placements)

    def decisions(self, placements: Placements) -> tuple[ModeDecision, ...] | None:
        """Return the segments' mode decisions, or None where one has z < z_min."""
        backend, z_min = self._judge.backend, self._judge.problem.mechanics.z_min
        fingers = tuple(range(len(placements)))
        order = coarse_to_fine(self.parts)
        for j in order:
            if backend.bound(self.environment(j), fingers, placements) < z_min:
                return None
        found = {}
        for j in order:
            found[j] = backend.decide(self.environment(j), fingers, placements, z_min)
            if not found[j].z >= z_min:
                return None
        return tuple(found[j] for j in range(len(order)))

    def lengths(self, placements: Placements) -> Array:
        """Return |dq_finger i,j| of Eq. (9), (n, segments)."""
        rows = [self._judge.centres(i)[row] for i, row in enumerate(placements)]
        centres = np.array(rows).reshape(-1, 3)
        return np.ascontiguousarray(self.arc.chords(centres, self.parts).T)


def coarse_to_fine(count: int) -> list[int]:
    """Return 0..count-1, ordered so that every beginning is spread over the whole.

    The last comes first: a motion fails where it ends more often than where it begins.
    """
    order = [count - 1] if count else []
    met = set(order)
    width = count
    while width > 1:
        width = (width + 1) // 2
        for j in range(0, count, width):
            if j not in met:
                met.add(j)
                order.append(j)
    return order
