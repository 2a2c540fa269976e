"""The search for a first plan: trees of lanes along random routes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.extraction import Leg, merged, moves_of
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.holds.watch import Stop
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.object_graph import Way
from gm_ompl.problem import Move
from gm_ompl.sampling.free_routes import FreeRouteMaker
from gm_ompl.sampling.lane_store import LaneStore, SetDraw
from gm_ompl.sampling.route import Route
from gm_ompl.sampling.route_maker import RouteMaker
from gm_ompl.sampling.settings import ExploringSettings
from gm_ompl.sampling.tree import Tree, join

FREE_STEPS: Final = 25
"""Growth steps per route of free motion, on average, before another one is tried: they are cheap,
and some cannot be carried through."""


@dataclass(frozen=True, eq=False)
class Course:
    """A route with what is known along it and the trees grown there.

    Attributes:
        store: what is known.
        trees: from the start, and (with two trees) from the goal.
    """

    store: LaneStore
    trees: tuple[Tree, ...]

    @property
    def promise(self) -> float:
        """How much of the route the trees have covered, against the steps spent on it."""
        covered = sum(tree.best for tree in self.trees) / len(self.trees)
        return (0.05 + covered) / (1.0 + 0.01 * sum(tree.steps for tree in self.trees))


class Routes(Protocol):
    """Where routes come from."""

    def make(self, stop: Stop) -> Route | None:
        """Return the next route, or None where the attempt failed."""

    def variant(self, route: Route) -> Route | None:
        """Return a route much like ``route``, or None where that failed."""

    def adopted(self, way: Way) -> Route:
        """Return the route along a way of a plan that was found elsewhere."""


@final
class Explorer:
    """Grows trees until a plan is found.

    Args:
        judge: answers about the problem.
        two_trees: whether a second tree grows from the goal.
        settings: how.
        rng: the source of randomness.

    Attributes:
        courses: the routes tried so far.
        routes: where they come from.
        sets: canonical sets.
    """

    def __init__(
        self, judge: Judge, two_trees: bool, settings: ExploringSettings, rng: np.random.Generator
    ) -> None:
        problem = judge.problem
        self._judge, self._settings, self._rng = judge, settings, rng
        self._problem = problem
        ways = (True, False) if two_trees else (True,)
        self._draws = {
            way: SetDraw(problem, judge, settings.placement_bias, settings.uniform_share)
            for way in ways
        }
        self.routes: Routes = (
            FreeRouteMaker(judge, self._draws[True], rng)
            if isinstance(problem.motion, FreeMotion)
            else RouteMaker(judge, rng)
        )
        self.sets = PlacementSets(problem.fingers.groups())
        self.courses: list[Course] = []

    @property
    def branches(self) -> int:
        """Branches of all trees."""
        return sum(len(tree.branches) for course in self.courses for tree in course.trees)

    def step(self, stop: Stop) -> tuple[Course, list[Leg]] | None:
        """Do one iteration; return a plan's legs if it found one."""
        if self._wants_route():
            route = self.routes.make(stop)
            if route is not None:
                self._add(route)
        if not self.courses:
            return None
        course = self._pick()
        # The one that had fewer steps; the goal's first: it is the more selective.
        tree = min(reversed(course.trees), key=lambda tree: tree.steps)
        number = tree.grow(stop)
        if number is None:
            return None
        legs = self._plan(course, tree, number)
        return None if legs is None else (course, legs)

    def _wants_route(self) -> bool:
        """Whether another route is to be tried."""
        if not self.courses or self._rng.random() < self._settings.new_route_share:
            return True
        if self._problem.motion.dimension:
            return False
        steps = sum(tree.steps for course in self.courses for tree in course.trees)
        return steps >= FREE_STEPS * len(self.courses)

    def variant(self, route: Route) -> Course | None:
        """Return a new course along a route much like ``route``, or None where it is blocked."""
        other = self.routes.variant(route)
        return None if other is None else self._add(other)

    def adopted(self, way: Way) -> Course:
        """Return a new course along the way of a plan that was found elsewhere."""
        return self._add(self.routes.adopted(way))

    def _add(self, route: Route) -> Course:
        course = self.course(route)
        self.courses.append(course)
        return course

    def course(self, route: Route) -> Course:
        """Return a route with trees that are still to grow; it is not among ``courses`` yet."""
        store = LaneStore(self._judge, self.sets, route)
        problem, settings = self._judge.problem, self._settings
        trees = tuple(
            Tree(problem, store, draw, way, settings, self._rng)
            for way, draw in self._draws.items()
        )
        return Course(store, trees)

    def _pick(self) -> Course:
        if len(self.courses) == 1:
            return self.courses[0]
        promise = np.array([course.promise for course in self.courses]) ** 2
        return self.courses[int(self._rng.choice(len(promise), p=promise / promise.sum()))]

    def _plan(self, course: Course, tree: Tree, number: int) -> list[Leg] | None:
        branch, last = tree.branches[number], course.store.route.strides
        if tree.ahead and branch.reach == last and tree.fits_other_end(branch.lane):
            legs = merged(tree.legs(number, last))
            return legs if course.store.free_at_end(branch.lane, last) else None
        if not tree.ahead and branch.reach == 0 and tree.fits_other_end(branch.lane):
            legs = merged(tree.legs(number, 0))
            return legs if course.store.free_at_end(branch.lane, 0) else None
        if len(course.trees) == 1:
            return None
        other = course.trees[1] if tree is course.trees[0] else course.trees[0]
        return join(course.store, tree, number, other)


@final
class FirstPlan:
    """An explorer that turns what it finds into moves.

    Args:
        judge: answers about the problem.
        explorer: searches.

    Attributes:
        cost: of the plan, +inf without one.
        moves: the plan's.
    """

    def __init__(self, judge: Judge, explorer: Explorer) -> None:
        self._judge, self._explorer = judge, explorer
        self.cost, self.moves = math.inf, tuple[Move, ...]()

    @property
    def branches(self) -> int:
        """Branches of all trees."""
        return self._explorer.branches

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far."""
        return self._explorer.courses

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether it found a plan."""
        found = self._explorer.step(stop)
        if found is None:
            return False
        course, legs = found
        moves = moves_of(self._judge, course.store.route.way, legs)
        self.cost, self.moves = math.fsum(move.cost for move in moves), moves
        return True
