"""Routes: motions of the object from start to goal that all sets share; drawn at random."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.lattice import Coordinates, between
from gm_ompl.motion.object_graph import Way
from gm_ompl.sampling.lines import polyline, same, split, unwrapped
from gm_ompl.sampling.route import Route

OBJECT_STEPS = 2000
"""Steps of the object's own tree before a route is given up."""

REACH = 0.2
"""Longest step of that tree, as a share of the coordinates' ranges."""

STRAIGHT = 1.0 - 1e-12
"""Cosine of the greatest angle between two straight lines that are one."""

SHORTCUTS = 30
"""Random shortcuts tried on the tree's path."""


@final
class RouteMaker:
    """Makes routes: first the straight one, then ever other ones.

    Args:
        judge: answers about the problem.
        rng: the source of randomness.
    """

    def __init__(self, judge: Judge, rng: np.random.Generator) -> None:
        self._judge, self._rng = judge, rng
        self._problem = judge.problem
        self._extents = np.array(self._problem.motion.extents)
        self._made = 0
        self._drawn: dict[Route, tuple[tuple[Coordinates, ...], int]] = {}  # corners, strides

    def make(self, stop: Stop) -> Route | None:  # noqa: ARG002 (none takes long)
        """Return the next route, or None where the attempt failed."""
        self._made += 1
        problem = self._problem
        goal = self._goal(nearest=self._made == 1)
        start = problem.start
        if self._made == 1:
            points: list[Coordinates] | None = [start, goal]
        elif problem.motion.dimension == 1 or self._rng.random() < 0.5:
            via = unwrapped(problem, self._anywhere(), start)
            points = [start, via, unwrapped(problem, goal, via)]
        else:
            points = self._path(start, goal)
        return None if points is None else self._along(points)

    def variant(self, route: Route) -> Route | None:
        """Return a route much like ``route``: a corner moved, added or left out, or finer strides.

        With one coordinate there are no corners to move: strides get finer each time.
        """
        if self._problem.motion.dimension == 1:
            corners, finer = self._drawn[route]
            return self._along(corners, finer + 1)
        points = list(self._drawn[route][0])
        k = int(self._rng.integers(len(points) - 1))
        if len(points) > 2 and self._rng.random() < 0.5:
            del points[max(k, 1)]
        elif len(points) > 2 and self._rng.random() < 0.5:
            points[max(k, 1)] = self._beside(points[max(k, 1)])
        else:
            middle = between(points[k], points[k + 1], float(self._rng.random()))
            points.insert(k + 1, self._beside(middle))
        return self._along(points)

    def adopted(self, way: Way) -> Route:
        """Return the route along a way of a plan that was found elsewhere."""
        route = Route(self._judge, way)
        self._drawn[route] = tuple(self._corners(way.coordinates)), 1
        return route

    def _corners(self, points: Sequence[Coordinates]) -> list[Coordinates]:
        """Return the ends of a polyline and where it changes its direction."""
        kept = [points[0]]
        for here, onward in itertools.pairwise(points[1:]):
            into, out = (
                (np.array(b) - np.array(a)) / self._extents
                for a, b in ((kept[-1], here), (here, onward))
            )
            lengths = np.linalg.norm(into) * np.linalg.norm(out)
            if into @ out < STRAIGHT * lengths:
                kept.append(here)
        return [*kept, points[-1]]

    def _beside(self, q: Coordinates) -> Coordinates:
        """Return a point near ``q``, near and far alike likely, within bounds."""
        spread = 0.3 * float(self._rng.random()) ** 2
        moved = np.array(q) + spread * self._extents * self._rng.normal(size=len(q))
        motion = self._problem.motion
        return tuple(
            float(v) if period is not None else min(max(float(v), low), high)
            for v, low, high, period in zip(
                moved, motion.low, motion.high, motion.periods, strict=True
            )
        )

    def _along(self, points: Sequence[Coordinates], finer: int = 1) -> Route | None:
        kept = [points[0], *(b for a, b in itertools.pairwise(points) if a != b)]
        if len(kept) == 1 and not self._problem.goal.contains(kept[0]):
            return None
        route = Route(self._judge, polyline(self._problem, kept, finer))
        if not route.table.object_free:
            return None
        self._drawn[route] = tuple(kept), finer
        return route

    def _anywhere(self) -> Coordinates:
        low, high = np.array(self._problem.motion.low), np.array(self._problem.motion.high)
        return tuple(float(v) for v in self._rng.uniform(low, high))

    def _goal(self, nearest: bool) -> Coordinates:
        """Return a point of the goal, near the start or at random."""
        goal, start = self._problem.goal, self._problem.start
        values = []
        for d, (low, high) in enumerate(zip(goal.low, goal.high, strict=True)):
            if low is None or high is None:
                values.append(start[d] if nearest else self._anywhere()[d])
            elif nearest:
                values.append(min(max(start[d], low), high))
            else:
                values.append(float(self._rng.uniform(low, high)))
        return unwrapped(self._problem, tuple(values), start)

    def _path(self, start: Coordinates, goal: Coordinates) -> list[Coordinates] | None:
        """Return a polyline along which the object penetrates nothing, by a random tree."""
        points, parents = [start], [-1]
        for _ in range(OBJECT_STEPS):
            towards = goal if self._rng.random() < 0.2 else self._anywhere()
            nearest = self._nearest(points, towards)
            here = points[nearest]
            step = self._step(here, unwrapped(self._problem, towards, here))
            if step == here or not self._object_free(here, step):
                continue
            points.append(step)
            parents.append(nearest)
            if same(self._problem, step, goal):
                path, k = [step], nearest
                while k >= 0:
                    path.append(points[k])
                    k = parents[k]
                return self._shortened(path[::-1])
        return None

    def _nearest(self, points: list[Coordinates], q: Coordinates) -> int:
        gaps: Array = np.array(points) - np.array(q)
        for d, period in enumerate(self._problem.motion.periods):
            if period is not None:
                gaps[:, d] = (gaps[:, d] + period / 2) % period - period / 2
        return int(np.argmin(np.linalg.norm(gaps / self._extents, axis=1)))

    def _step(self, here: Coordinates, towards: Coordinates) -> Coordinates:
        gap = float(np.linalg.norm((np.array(towards) - np.array(here)) / self._extents))
        return towards if gap <= REACH else between(here, towards, REACH / gap)

    def _object_free(self, a: Coordinates, b: Coordinates) -> bool:
        points, motion = split(self._problem, a, b), self._problem.motion
        if not self._judge.node(motion.pose(b)).object_free:
            return False
        arcs = (motion.arc(*ends) for ends in itertools.pairwise(points))
        return all(self._judge.along(arc).object_free for arc in arcs)

    def _shortened(self, path: list[Coordinates]) -> list[Coordinates]:
        for _ in range(SHORTCUTS):
            if len(path) < 3:
                break
            i, j = sorted(int(k) for k in self._rng.choice(len(path), size=2, replace=False))
            if j - i < 2:
                continue
            there = unwrapped(self._problem, path[j], path[i])
            if there == path[j] and self._object_free(path[i], path[j]):
                path = path[: i + 1] + path[j:]
        return path
