"""Routes of free motion: the object's way through SE(3), drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final
from weakref import WeakKeyDictionary

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.object_graph import GraphArc, Way
from gm_ompl.sampling.carrying import Carrying
from gm_ompl.sampling.lane_store import SetDraw
from gm_ompl.sampling.pose_tree import Metric, PoseTree, nearest_in
from gm_ompl.sampling.route import Route
from gm_ompl.sampling.screws import Screws, Stride
from gm_ompl.sampling.stride_states import may_lift

STEPS: Final = 400
"""Steps of a tree before another one is grown."""

BESIDE_SHARE: Final = 0.5
"""Share of the variants that begin with a leap to somewhere else."""

ELSEWHERE_SHARE: Final = 0.5
"""Share of the variants of a route's end that may end elsewhere in the goal."""

LEAPS: Final = 8
"""Leaps from one place of a route to another at most."""


@final
class FreeRouteMaker:
    """Makes routes along which some hands carry the object.

    Args:
        judge: answers about the problem.
        draw: draws sets of placements; it learns here, too.
        rng: the source of randomness.
    """

    def __init__(self, judge: Judge, draw: SetDraw, rng: np.random.Generator) -> None:
        problem = judge.problem
        self._judge, self._rng = judge, rng
        self._screws, self._metric = Screws(problem), Metric(problem.body.diagonal)
        self._carrying = Carrying(judge, self._screws, draw, rng)
        self._lifts = may_lift(problem)
        # Routes that nobody takes up are let go.
        self._drawn = WeakKeyDictionary[Route, tuple[Stride, ...]]()

    def make(self, stop: Stop) -> Route | None:
        """Return the next route, or None where the attempt failed."""
        tree = PoseTree(self._screws, self._carrying, self._metric, self._lifts, self._rng)
        found = tree.search(STEPS, stop)
        return None if found is None else self._along(tree.path(found))

    def variant(self, route: Route) -> Route | None:
        """Return a route much like ``route``: another way between two of its places.

        The object goes from one to the other by leaps that bring it nearer, at times from a place
        beside the first.
        """
        strides, rng = self._drawn[route], self._rng
        places = [self._screws.start, *(stride.arc.head for stride in strides)]
        if len(strides) < 2:
            return None
        first, last = sorted(rng.choice(len(places), size=2, replace=False).tolist())
        between = list[Stride]()
        if rng.random() < BESIDE_SHARE:
            target = self._screws.pose(places[int(rng.integers(len(places)))])
            between = self._leapt(places[first], target)
        begin = between[-1].arc.head if between else places[first]
        end = places[last]
        if last == len(strides) and rng.random() < ELSEWHERE_SHARE:
            end = self._screws.number(
                nearest_in(self._screws.motion.goal, self._screws.pose(begin))
            )
        onwards = self._between(begin, end)
        if onwards is None:
            return None
        return self._along([*strides[:first], *between, *onwards, *strides[last:]])

    def _between(self, begin: int, end: int) -> list[Stride] | None:
        """Return strides from a place to another by leaps that bring the object nearer."""
        target, found = self._screws.pose(end), list[Stride]()
        for _ in range(LEAPS):
            if begin == end:
                return found
            strides = self._leapt(begin, target, nearer=True)
            if not strides:
                return None
            found += strides
            begin = strides[-1].arc.head
        return found if begin == end else None

    def _leapt(self, begin: int, target: Pose, *, nearer: bool = False) -> list[Stride]:
        """Return the strides of a leap towards a target, a random one of those on offer.

        Where it must bring the object nearer, those that do so more are likelier.
        """
        leaps = [
            leap for leap in self._screws.towards(begin, target) if self._lifts or not leap.bare
        ]
        weights = np.ones(len(leaps))
        if nearer:
            here = self._metric.between(self._screws.pose(begin), target)
            gains = [here - self._metric.between(leap.end, target) for leap in leaps]
            weights = np.where(np.array(gains) > self._metric.none, gains, 0.0)
        if not weights.any():
            return []
        return self._screws.strides(
            leaps[int(self._rng.choice(len(leaps), p=weights / weights.sum()))]
        )

    def adopted(self, way: Way) -> Route:
        """Return the route along a way of a plan that was found elsewhere."""
        places = [self._screws.number(pose) for pose in way.poses]
        route = Route(self._judge, way)
        self._drawn[route] = tuple(
            Stride(arc.leading_to(head), tail)
            for arc, tail, head in zip(way.arcs, places[:-1], places[1:], strict=True)
        )
        return route

    def _along(self, strides: Sequence[Stride]) -> Route | None:
        places = [self._screws.start, *(stride.arc.head for stride in strides)]
        poses = tuple(self._screws.pose(place) for place in places)
        # Along a route each stride is a kind of its own.
        arcs = tuple(
            GraphArc(k, stride.arc.arc, stride.arc.parts)
            for k, stride in enumerate(strides, start=1)
        )
        route = Route(self._judge, Way(poses, ((),) * len(poses), arcs))
        if not route.table.object_free:
            return None
        self._drawn[route] = tuple(strides)
        return route
