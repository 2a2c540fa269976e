"""Lower bounds on plans that keep the whole hand, where free motion turns about one axis alone.

In the plane across it the object goes along two axes, or along a face that leans on the corners of
two obstacles. Every rotation is about a point of the outline that the plane shows, or about the
centre of mass. What it goes along the axis counts as nothing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.cores import share_out
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.potentials import POTENTIALS, SLOPES, PlaneGoal, set_up_all
from gm_ompl.motion.free import SLACK, FreeMotion, PoseGoal
from gm_ompl.problem import Problem

PIECES: Final = 96
"""The outline is cut into about so many pieces."""

POINTS: Final = 3
"""A point o of the object is first looked for on a grid of so many by so many."""

LEVEL: Final = 1e-9
"""A component of a unit vector that counts as nothing."""

ALIKE: Final = 1e-12
"""Fingertips are in one place where they differ by no more than this, relative to D."""

AT_ONCE: Final = 512
"""Sets of placements treated at once, between two looks at the limits."""


def turning_axis(problem: Problem) -> int | None:
    """Return the only axis about which free motion turns, where a plane across it tells enough.

    The object's faces lie along that axis or across it, obstacles' faces along the world's axes.
    Where it slides along its ends, on what they touch, both axes of the plane must be listed: then
    the ends' contact lines offer nothing else, nor do lone points but on the outline. None where
    that is not so.
    """
    motion, D = problem.motion, problem.body.diagonal
    if not isinstance(motion, FreeMotion) or motion.steps.rotate is None:
        return None
    along = np.abs(motion.steps.rotate)
    axis = int(along[0].argmax()) if len(along) else 2
    one = len(along) > 0 and np.allclose(along[:, axis], 1.0, rtol=0.0, atol=LEVEL)
    low, high = motion.region[:, axis]
    if not one:
        return None
    plane = [(axis + 1) % 3, (axis + 2) % 3]
    both = set(plane) <= set(motion.steps.translate)
    R, near = motion.start.rotation, (problem.environment.contact_tolerance + SLACK) * D
    fixed = [piece for o in problem.environment.obstacles for piece in o.body.pieces]
    upright = all(_is_along(p.face_normals @ R.T, (axis,)) for p in problem.body.pieces)
    level = all(_is_along(p.face_normals, plane) for p in fixed)
    own = [_reach(p.vertices @ R[axis] + low) for p in problem.body.pieces]
    beside = all(
        abs(max(a[0] - b[1], b[0] - a[1])) > near + (high - low)
        for a in own
        for b in (_reach(p.vertices[:, axis]) for p in fixed)
    )
    # What is narrower may count as a lone point, on an end wherever it likes.
    wide = all(np.ptp(p.vertices[:, plane], axis=0).max() > 2.0 * near for p in fixed)
    told = (both and wide) or (beside and (both or axis != 2))
    return axis if upright and level and told else None


def _is_along(normals: Array, axes: Sequence[int]) -> bool:
    """Whether unit vectors (n, 3) all lie along each of the world's axes or across it."""
    parts = np.abs(normals) <= LEVEL
    return all((parts[:, k] | np.delete(parts, k, axis=1).all(axis=1)).all() for k in axes)


def _reach(heights: Array) -> tuple[float, float]:
    return float(heights.min()), float(heights.max())


def leans(problem: Problem, axis: int) -> bool:
    """Whether a face may lie askew on corners of two obstacles, and slide along them.

    Both are on one side of it then: it is along their hull, between them.

    Args:
        problem: of free motion.
        axis: its ``turning_axis``.
    """
    plane, D = [(axis + 1) % 3, (axis + 2) % 3], problem.body.diagonal
    fixed = [piece for o in problem.environment.obstacles for piece in o.body.pieces]
    return any(
        (np.abs(side).min() > LEVEL * D) and np.linalg.norm(side) <= (1.0 + SLACK) * D
        for a, b in itertools.combinations([piece.vertices[:, plane] for piece in fixed], 2)
        for side in _sides(np.concatenate([a, b]))
    )


class Outline(NamedTuple):
    """What the plane shows of the object, cut into pieces.

    Attributes:
        ends: (S, 2, 2), the pieces' ends; the last one is the centre of mass.
        near: (Q, S, 2), the distance of each place of fingertips at the pieces' ends, from below;
            less what moving a point by the contact tolerance takes from a gap of ``set_up``.
        tips: (Q, 2), the places.
        points: (M, 2), points of the object to choose from.
    """

    ends: Array
    near: Array
    tips: Array
    points: Array


@final
class PlanarBounds:
    """Potentials of sets of placements, and where the object must end.

    Args:
        judge: of the problem.
        axis: its ``turning_axis``.

    Attributes:
        target: where the object must end.
        sites: per finger, (P,), which fingertips the plane shows in one place.
    """

    def __init__(self, judge: Judge, axis: int) -> None:
        problem = judge.problem
        motion = problem.motion
        assert isinstance(motion, FreeMotion)
        # Turned by a positive angle the first goes towards the second.
        self._plane, self._from = [(axis + 1) % 3, (axis + 2) % 3], motion.start.rotation
        tips = [self._flat(judge.centres(i)) for i in range(problem.fingers.count)]
        near = np.rint(np.concatenate(tips) / (ALIKE * problem.body.diagonal))
        _, first, of = np.unique(near, axis=0, return_index=True, return_inverse=True)
        self.sites = np.split(of.reshape(-1), len(tips))
        self._outline = self._shown(problem, np.concatenate(tips)[first])
        # Judged from end to end, the middle one of three segments is half of all.
        longest = 1.5 if motion.ends else 1.0
        delta = longest * motion.steps.rotation / problem.cost.samples_per_arc
        self._kappa = math.sin(delta / 2.0) / (delta / 2.0)
        self._steepest = 1.0 if leans(problem, axis) else float(SLOPES[-1])
        self._goal, self.target = motion.goal, self._target(motion.goal)

    def _shown(self, problem: Problem, tips: Array) -> Outline:
        ends = np.concatenate(
            [_rim(self._flat(piece.vertices)) for piece in problem.body.pieces]
            + [np.zeros((1, 2, 2))]
        )
        far = np.abs(self._flat(problem.body.vertices)).max(axis=0) * 1.5
        axes = [np.linspace(-f, f, POINTS) for f in far]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        # What counts as touched is off the outline by no more than the contact tolerance.
        off = (1.0 + SLOPES[-1]) * problem.environment.contact_tolerance * problem.body.diagonal
        return Outline(ends, _from_pieces(tips, ends) - off, tips, points)

    def _flat(self, points: Array) -> Array:
        """Return points (m, 3) of the object as the plane shows them at the start, (m, 2)."""
        return np.ascontiguousarray((points @ self._from.T)[:, self._plane])

    def _turns(self, rotations: Array) -> Array:
        """Return by how much the object is turned [rad], (...), counted from the start."""
        i, j = self._plane
        since = rotations @ self._from.T
        turns: Array = np.arctan2(since[..., j, i], since[..., i, i])
        return turns

    def _target(self, goal: PoseGoal) -> PlaneGoal:
        turn = 0.0 if goal.rotation is None else float(self._turns(goal.rotation))
        where = goal.low[self._plane], goal.high[self._plane], goal.rotation is not None
        across = math.sin(min(goal.angle, math.pi / 2.0))
        along = 1.0 - math.cos(min(goal.angle, math.pi))
        return PlaneGoal(*where, math.cos(turn), math.sin(turn), goal.distance, across, along)

    def places(self, rotations: Array, positions: Array) -> Array:
        """Return how the plane shows poses (N, 5), as ``potential`` has it.

        Args:
            rotations: (N, 3, 3), of the object.
            positions: (N, 3), of its centre of mass.
        """
        turns, left = self._turns(rotations), np.zeros(len(rotations))
        if self._goal.rotation is not None:
            off = self._turns(self._goal.rotation) - turns
            off = np.abs(np.arctan2(np.sin(off), np.cos(off)))
            left = np.maximum(off - self._goal.angle, 0.0)
        return np.column_stack([positions[:, self._plane], np.cos(turns), np.sin(turns), left])

    def potentials(self, rows: IntArray, fingers: IntArray | None = None) -> Array:
        """Return the potentials (L, POTENTIALS, 4) of sets of placements (L, n).

        Args:
            rows: the sets.
            fingers: (n,), whose they are; None: the whole hand's.

        Raises:
            LimitError: a limit is reached.
        """
        which = range(len(self.sites)) if fingers is None else fingers.tolist()
        at = [self.sites[i][row] for i, row in zip(which, rows.T, strict=True)]
        # Who is in which place does not matter.
        sets, of = np.unique(np.sort(np.stack(at, axis=1), axis=1), axis=0, return_inverse=True)
        outline, found = self._outline, np.empty((len(sets), POTENTIALS, 4))

        def work(part: slice) -> None:
            near, tips = outline.near[sets[part]], outline.tips[sets[part]]
            set_up_all(near, outline.points, outline.ends, self._kappa, tips, found[part])

        share_out(work, len(sets), most=AT_ONCE)
        # A shorter y gains less from rotations.
        found[..., 2] = np.minimum(found[..., 2], self._steepest)
        return found[of.reshape(-1)]


def _rim(points: Array) -> Array:
    """Return the hull of points (m, 2) in pieces (S, 2, 2)."""
    from scipy.spatial import ConvexHull  # takes long to load

    corners = points[ConvexHull(points).vertices]
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    lengths = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    longest, pieces = lengths.sum() / PIECES, []
    for (a, b), length in zip(sides, lengths, strict=True):
        t = np.linspace(0.0, 1.0, math.ceil(length / longest) + 1)[:, None]
        along = a + t * (b - a)
        pieces.append(np.stack([along[:-1], along[1:]], axis=1))
    return np.ascontiguousarray(np.concatenate(pieces))


def _sides(points: Array) -> Array:
    """Return the sides (m, 2) of the hull of points (k, 2)."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    sides: Array = points[hull.simplices[:, 1]] - points[hull.simplices[:, 0]]
    return sides


def _from_pieces(points: Array, pieces: Array) -> Array:
    """Return linear lower bounds (P, S, 2) on the distances of points from pieces, at their ends.

    A distance is convex along a piece: it lies above its tangent in the middle.
    """
    half = (pieces[:, 1] - pieces[:, 0]) / 2.0
    off = (pieces[:, 0] + pieces[:, 1]) / 2.0 - points[:, None]
    middle = np.linalg.norm(off, axis=2)
    slope = (off * half).sum(axis=2) / np.maximum(middle, 1e-300)
    return np.ascontiguousarray(np.stack([middle - slope, middle + slope], axis=2))
