"""A lifted finger: where it stands off, and its way from one placement to the next."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body
from gm_ompl.problem import Problem

TOUCHING = 1e-6
"""Fingertips that touch something are clear of it, up to this [D], as in the plan's geometry."""

HALVINGS = 6  # how often a height above a placement is halved where something is in the way
BEARINGS = 16  # directions in the surface in which a finger may leave where it cannot lift
CELLS = 36  # grid cells along the longest side of the region searched
LOOK = 1e-3  # least distance between points looked at along a straight line, of the region searched

_STEPS = np.array([s for s in itertools.product((-1, 0, 1), repeat=3) if any(s)])


class Clearance:
    """Which points a fingertip's centre may pass, the object at rest.

    A sphere is clear of a convex piece where its centre is a radius beyond one of its faces: exact
    beside faces, on the safe side around edges and corners.

    Args:
        problem: the scenario.
        pose: where the object rests.
        finger: the finger that moves.
        others: (k, 3), centres of the other fingertips.
        other_radii: (k,).
        margin: least distance kept; a touching fingertip is clear of what it touches up to a
            negative one.
        object_alone: whether floor and obstacles do not count.
    """

    def __init__(
        self,
        problem: Problem,
        pose: Pose,
        finger: int,
        others: Array,
        other_radii: Array,
        margin: float,
        *,
        object_alone: bool = False,
    ) -> None:
        self.margin = margin
        self._reach = float(problem.fingers.radius[finger]) + margin
        self._floor = problem.environment.floor and not object_alone
        self._planes = [
            (p.face_normals @ pose.rotation.T,
             p.face_offsets + p.face_normals @ pose.rotation.T @ pose.position)
            for p in problem.body.pieces
        ]  # fmt: skip
        fixed: Sequence[Body] = [obstacle.body for obstacle in problem.environment.obstacles]
        if not object_alone:
            self._planes += [(p.face_normals, p.face_offsets) for b in fixed for p in b.pieces]
        self._others, self._apart = others, other_radii + self._reach

    def free(self, points: Array) -> BoolArray:
        """Return (P,), which of ``points`` (P, 3) are clear."""
        clear = np.ones(len(points), dtype=bool)
        if self._floor:
            clear &= points[:, 2] >= self._reach
        for normals, offsets in self._planes:
            clear &= (points @ normals.T - offsets).max(axis=1) >= self._reach
        for centre, apart in zip(self._others, self._apart, strict=True):
            clear &= np.linalg.norm(points - centre, axis=1) >= apart
        return clear

    def line(self, a: Array, b: Array, spacing: float) -> bool:
        """Whether the straight line between two points is clear."""
        return bool(self.lines(a, b[None], spacing)[0])

    def lines(self, a: Array, ends: Array, spacing: float) -> BoolArray:
        """Return (E,), which straight lines from ``a`` to ``ends`` (E, 3) are clear."""
        longest = float(np.linalg.norm(ends - a, axis=1).max(initial=0.0))
        shares = np.linspace(0.0, 1.0, max(2, int(np.ceil(longest / spacing)) + 1))
        points = a + shares[:, None, None] * (ends - a)
        clear: BoolArray = np.all(self.free(points.reshape(-1, 3)).reshape(len(shares), -1), axis=0)
        return clear


def shortest(clearance: Clearance, start: Array, end: Array, size: float) -> Array | None:
    """Return the corners (k, 3) of a clear way from ``start`` to ``end``; None if none is found.

    A straight line if it is clear, else the shortest way over a grid, its corners cut.

    Args:
        clearance: what is clear.
        start: (3,), clear.
        end: (3,), clear.
        size: how far around the two ends to search.
    """
    low, high = np.minimum(start, end) - size, np.maximum(start, end) + size
    spacing = float((high - low).max()) / CELLS
    # A point is at most half of this from one that is clear by the margin.
    look = max(clearance.margin, LOOK * size)
    if clearance.line(start, end, look):
        return np.array([start, end])
    shape = np.ceil((high - low) / spacing).astype(int) + 1
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    points = low + spacing * index
    free = clearance.free(points)
    ends = [_nearest(clearance, points, free, point, look) for point in (start, end)]
    if ends[0] is None or ends[1] is None:
        return None
    cells = _over_grid(clearance, points, tuple(map(int, shape)), ends[0], ends[1], look)
    if cells is None:
        return None
    return _cut(clearance, np.array([start, *points[cells], end]), look)


def _nearest(
    clearance: Clearance, points: Array, free: BoolArray, to: Array, look: float
) -> int | None:
    distance = np.where(free, np.linalg.norm(points - to, axis=1), np.inf)
    for row in np.argsort(distance)[:200]:
        if free[row] and clearance.line(points[row], to, look):
            return int(row)
    return None


def _over_grid(
    clearance: Clearance, points: Array, shape: tuple[int, ...], start: int, goal: int, look: float
) -> list[int] | None:
    """Return the cells of the shortest way over clear steps between neighbours (A*)."""
    lengths = np.linalg.norm(_STEPS, axis=1)
    there = np.array(np.unravel_index(goal, shape))
    best, parent = {start: 0.0}, {start: start}
    queue, closed = [(0.0, start)], set()
    while queue:
        _, cell = heapq.heappop(queue)
        if cell == goal:
            cells = [cell]
            while parent[cells[-1]] != cells[-1]:
                cells.append(parent[cells[-1]])
            return cells[::-1]
        if cell in closed:
            continue
        closed.add(cell)
        near = np.array(np.unravel_index(cell, shape)) + _STEPS
        inside = ((near >= 0) & (near < shape)).all(axis=1)
        rows = np.ravel_multi_index(tuple(near[inside].T), shape)
        clear = clearance.lines(points[cell], points[rows], look)
        ahead = np.linalg.norm(near[inside] - there, axis=1)
        for row, step, left in zip(
            rows[clear].tolist(), lengths[inside][clear], ahead[clear], strict=True
        ):
            cost = best[cell] + float(step)
            if cost < best.get(row, np.inf):
                best[row], parent[row] = cost, cell
                heapq.heappush(queue, (cost + float(left), row))
    return None


def _cut(clearance: Clearance, corners: Array, look: float) -> Array:
    """Return the corners left when every clear short cut is taken, from the start on."""
    kept, k = [corners[0]], 0
    while k < len(corners) - 1:
        ahead = range(len(corners) - 1, k + 1, -1)
        k = next((j for j in ahead if clearance.line(corners[k], corners[j], look)), k + 1)
        kept.append(corners[k])
    return np.array(kept)


@dataclass(frozen=True, eq=False)
class Transit:
    """Fingers about to land, or just lifted, while the object rests and others stay."""

    problem: Problem  # the scenario
    pose: Pose  # where the object rests
    points: Array  # (n, 3), the fingers' placements, object frame
    normals: Array  # (n, 3), into the object
    height: float  # how far a finger stands off where it can

    def off(self, i: int, point: Array, normal: Array) -> Array:
        """Return (3,), from where finger ``i`` touches at ``point`` to where it stands off.

        It lifts along the normal, less high where something is in the way. Where it cannot lift at
        all it leaves along the surface, straight, until it is past the object: in a slot as wide
        as a fingertip there is no other way. Object frame.
        """
        radius = float(self.problem.fingers.radius[i])
        touching, clear = point - radius * normal, self.clearance(i, 0.0)
        for height in self.height / 2.0 ** np.arange(HALVINGS):
            if clear.free(self.pose.apply(touching - height * normal)[None])[0]:
                return np.asarray(-height * normal)
        ways = [self._along(i, touching, side) for side in _sideways(normal)]
        found = [side for side in ways if side is not None]
        wanted = np.asarray(-self.height * normal)
        return min(found, key=lambda side: float(np.linalg.norm(side)), default=wanted)

    def _along(self, i: int, touching: Array, side: Array) -> Array | None:
        """Return the way along unit ``side`` until finger ``i`` is past the object, if clear."""
        size, start = self.problem.body.diagonal, self.pose.apply(touching)
        alone = self.clearance(i, self.height / 2.0, object_alone=True)
        for length in np.arange(0.05, 1.5, 0.05) * size:
            end = self.pose.apply(touching + length * side)
            if alone.free(end[None])[0]:
                clear = self.clearance(i, -TOUCHING * size)
                return length * side if clear.line(start, end, self.height / 4.0) else None
        return None

    def way(self, i: int, point: Array, normal: Array) -> tuple[Array, bool]:
        """Return finger ``i``'s way to another placement, and whether it is clear of everything.

        Corners (k, 3), world frame: where it touches, where it stands off, and so on to where it
        touches again. The way keeps as much of a margin as it finds room for; where none is clear
        of everything it is clear of the object, where that can be.
        """
        ends = []
        for place in ((self.points[i], self.normals[i]), (point, normal)):
            touching = place[0] - float(self.problem.fingers.radius[i]) * place[1]
            ends.append(self.pose.apply(np.stack([touching, touching + self.off(i, *place)])))
        (first, start), (last, end) = ends
        span = self.problem.body.diagonal + 4.0 * float(self.problem.fingers.radius.max())
        least = -TOUCHING * self.problem.body.diagonal
        for object_alone in (False, True):
            for margin in (self.height / 2.0, self.height / 4.0, 0.0, least):
                clearance = self.clearance(i, margin, object_alone=object_alone)
                corners = shortest(clearance, start, end, span)
                if corners is not None:
                    return np.array([first, *corners, last]), not object_alone
        return np.array([first, start, end, last]), False

    def clearance(self, i: int, margin: float, *, object_alone: bool = False) -> Clearance:
        """Return where finger ``i`` may be while the others keep their placements."""
        others = [k for k in range(len(self.points)) if k != i and not object_alone]
        radii = self.problem.fingers.radius[others]
        out = self.points[others] - radii[:, None] * self.normals[others]
        return Clearance(
            self.problem, self.pose, i, self.pose.apply(out), radii, margin,
            object_alone=object_alone,
        )  # fmt: skip


def _sideways(normal: Array) -> Array:
    """Return (BEARINGS, 3), unit directions in the surface, evenly around."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, axis) / np.linalg.norm(np.cross(normal, axis))
    angle = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS
    around: Array = np.outer(np.cos(angle), first) + np.outer(
        np.sin(angle), np.cross(normal, first)
    )
    return around
