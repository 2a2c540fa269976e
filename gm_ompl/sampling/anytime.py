"""From the first plan towards the best: explore, improve by informed draws, vary the route.

A set is drawn near the best plan (one finger elsewhere), near any other lane of the sample, or at
random; it joins the sample only where a lower bound on the cost of every plan through it is below
the best cost. As draws never exclude a set, the best plan of a route is approached.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.extraction import Leg, moves_of
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Move, Placements
from gm_ompl.sampling.explorer import Course, Explorer
from gm_ompl.sampling.lane_sample import CHEAPER, LaneSample
from gm_ompl.sampling.lane_store import LaneStore, SetDraw, as_sets
from gm_ompl.sampling.plan_way import way_and_legs
from gm_ompl.sampling.settings import ImprovingSettings
from gm_ompl.sampling.stages import Refinement


@final
class Improver:
    """Improves plans along one route.

    Args:
        judge: answers about the problem.
        store: what is known along the route.
        draw: draws whole sets.
        settings: how.
        rng: the source of randomness.

    Attributes:
        sample: the lanes sampled.
        legs: the best plan along this route.
        steps: iterations so far.
    """

    def __init__(
        self,
        judge: Judge,
        store: LaneStore,
        draw: SetDraw,
        settings: ImprovingSettings,
        rng: np.random.Generator,
    ) -> None:
        self._judge, self._store, self._draw = judge, store, draw
        self._settings, self._rng = settings, rng
        self.sample = LaneSample(judge.problem, store)
        self.legs: list[Leg] = []
        self.steps = 0
        self._done: set[tuple[Placements, int]] = set()

    def seed(self, lanes: Sequence[Placements]) -> None:
        """Put lanes into the sample."""
        count = self._judge.problem.fingers.count
        self.sample.add(as_sets(lanes, count))

    def step(self, below: float, stop: Stop) -> list[Leg] | None:
        """Do one iteration; return the legs of a plan cheaper than ``below`` if one is found."""
        self.steps += 1
        if not self.sample.least[0] < below:
            return None
        self._join(self._candidates(), below)
        legs = self.sample.improve(below, self._settings.tries, stop)
        if legs is not None:
            self.legs = legs
            self._prune(self.sample.best)
        return legs

    def _candidates(self) -> IntArray:
        chance, settings = self._rng.random(), self._settings
        if chance < settings.best_neighbour_share and self.legs:
            lanes = [lane for lane, _, _ in self.legs]
            near = self._neighbours(lanes[int(self._rng.integers(len(lanes)))])
            if len(near):
                return near
        near_any = settings.best_neighbour_share + settings.neighbour_share
        if chance < near_any and len(self.sample):
            row = self.sample.sets[int(self._rng.integers(len(self.sample)))]
            near = self._neighbours(tuple(row.tolist()))
            if len(near):
                return near
        route = self._store.route  # random sets that are free at a random vertex
        vertex = int(self._rng.integers(route.strides + 1))
        allowed = tuple(route.node_free[:, :, vertex])
        return self._draw.draw(self._settings.drawn, allowed, self._rng)

    def _neighbours(self, lane: Placements) -> IntArray:
        """Return the sets that differ in one random finger, where it may be somewhere."""
        slot = int(self._rng.integers(len(lane)))
        if (lane, slot) in self._done:
            return as_sets((), len(lane))
        self._done.add((lane, slot))
        hub = self._store.lifted(lane, slot)
        return self._store.anywhere(hub)

    def _join(self, sets: IntArray, below: float) -> None:
        """Add the most promising of ``sets`` to the sample, some others that may do by luck."""
        if not len(sets):
            return
        _, g = self.sample.so_far()
        _, d = self.sample.onward()
        bound, here = self.sample.bounds(sets, g, d)
        limit = below * CHEAPER
        hopeful = np.flatnonzero(bound < limit)
        if math.isfinite(limit):
            self._draw.learn(sets, (bound < limit).astype(float))
        jitter = self._rng.random(len(hopeful))
        # Those that improve on the plan at once by what is known, then the rest at random.
        at_once = np.where(here[hopeful] < limit, here[hopeful], np.inf)
        order = np.lexsort((jitter, at_once))
        self.sample.add(sets[hopeful[order][: self._settings.joining]])

    def _prune(self, best: float) -> None:
        """Drop lanes that no plan cheaper than ``best`` can use, and the worst if too many."""
        _, g = self.sample.so_far()
        _, d = self.sample.onward()
        bound, here = self.sample.bounds(self.sample.sets, g, d)
        keep = bound < best / CHEAPER
        if keep.sum() > self._settings.sample_limit:
            order = np.lexsort((bound, here))
            keep &= np.isin(np.arange(len(keep)), order[: self._settings.sample_limit])
        self.sample.keep(keep)


@final
class Anytime:
    """Finds a plan and improves it, an iteration at a time.

    Args:
        judge: answers about the problem.
        settings: how.
        rng: the source of randomness.

    Attributes:
        cost: of the best plan, +inf without one.
        moves: the best plan's.
    """

    def __init__(self, judge: Judge, settings: ImprovingSettings, rng: np.random.Generator) -> None:
        self._judge, self._settings, self._rng = judge, settings, rng
        self._coordinates = judge.problem.motion.dimension > 0
        self._explorer = Explorer(judge, True, settings, rng)
        self._draw = SetDraw(judge.problem, judge, settings.placement_bias, settings.uniform_share)
        self._improvers: dict[Course, Improver] = {}
        self._best: Course | None = None
        self._next: list[Course] = []
        self._stalled = 0
        self._unrefined = math.inf
        self._refinement: Refinement | None = None
        self.cost, self.moves = math.inf, tuple[Move, ...]()

    @property
    def branches(self) -> int:
        """Branches of trees and lanes of samples."""
        lanes = sum(len(improver.sample) for improver in self._improvers.values())
        return self._explorer.branches + lanes

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far."""
        return self._explorer.courses

    def begin(self, moves: Sequence[Move]) -> None:
        """Go on from a plan, its placements by the rows of this problem's table."""
        way, legs = way_and_legs(self._judge.problem, moves)
        self._accept(self._explorer.adopted(way), legs)
        cost = math.fsum(move.cost for move in moves)
        if self._refinement is not None and self._keep(cost, tuple(moves)):
            self._refinement = Refinement(self._judge.problem, self._judge, moves, self._rng)

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether the best plan changed."""
        if self._best is None or self._rng.random() < self._settings.exploring_share:
            found = self._explorer.step(stop)
            return found is not None and self._accept(*found)
        if self._coordinates and self._rng.random() < self._settings.smoothing_share:
            return self._polish(stop)
        if not self._coordinates and self._rng.random() < self._settings.rerouting_share:
            self._reroute()
        elif self._stalled >= self._settings.stall_limit:
            self._vary()
        course = self._course()
        improver = self._improvers[course]
        if course is self._best:
            self._stalled += 1
        legs = improver.step(self._unrefined, stop)
        return legs is not None and self._accept(course, legs)

    def _accept(self, course: Course, legs: list[Leg]) -> bool:
        moves = moves_of(self._judge, course.store.route.way, legs)
        cost = math.fsum(move.cost for move in moves)
        if course not in self._improvers:
            self._add(course)
        self._improvers[course].seed([lane for lane, _, _ in legs])
        if not cost < self._unrefined:
            return False
        self._improvers[course].legs = legs
        self._best, self._stalled = course, 0
        self._unrefined = cost
        if self._coordinates:
            self._refinement = Refinement(self._judge.problem, self._judge, moves, self._rng)
        return self._keep(cost, moves)

    def _keep(self, cost: float, moves: tuple[Move, ...]) -> bool:
        if not cost < self.cost:
            return False
        self.cost, self.moves = cost, moves
        return True

    def _polish(self, stop: Stop) -> bool:
        """Refine the best plan that lanes gave; it may become better than all."""
        refinement = self._refinement
        if refinement is None or not refinement.moves:
            return False
        if not refinement.tidied:
            refinement.tidy(stop)
        else:
            refinement.step()
        return self._keep(refinement.cost, refinement.moves)

    def _add(self, course: Course) -> None:
        improver = Improver(self._judge, course.store, self._draw, self._settings, self._rng)
        improver.seed([branch.lane for tree in course.trees for branch in tree.branches])
        self._improvers[course] = improver

    def _course(self) -> Course:
        """Return the best course, or now and then another one that may become better."""
        assert self._best is not None, "there is a plan"
        if self._next:
            return self._next.pop()
        others = [
            course
            for course, improver in self._improvers.items()
            if course is not self._best and improver.sample.least[0] < self._unrefined
        ]
        if not others or self._rng.random() >= self._settings.other_routes_share:
            return self._best
        # The newest first: an older one had its turns.
        weights = 1.0 / (1.0 + np.array([self._improvers[c].steps for c in others]))
        return others[int(self._rng.choice(len(others), p=weights / weights.sum()))]

    def _vary(self) -> None:
        """Add a route much like the best one, with the best one's sets to begin with."""
        assert self._best is not None, "there is a plan"
        self._stalled = 0
        course = self._explorer.variant(self._best.store.route)
        if course is not None:
            self._take_up(course)

    def _take_up(self, course: Course) -> None:
        """Add a course, with the best one's sets to begin with."""
        assert self._best is not None, "there is a plan"
        self._add(course)
        known = self._improvers[self._best]
        lanes = [lane for lane, _, _ in known.legs]
        self._improvers[course].seed(lanes)
        self._improvers[course].sample.add(known.sample.sets)

    def _reroute(self) -> None:
        """Look for a route beside the best one along which the best one's sets may do better."""
        assert self._best is not None, "there is a plan"
        best = self._improvers[self._best]
        route = self._explorer.routes.variant(self._best.store.route)
        if route is None:
            return
        course = self._explorer.course(route)
        if self._hoped(course, best) < self._unrefined * CHEAPER:
            self._explorer.courses.append(course)
            self._take_up(course)
            self._next.append(course)

    def _hoped(self, course: Course, best: Improver) -> float:
        """Return what a plan along a route may cost with the sets of the best plan."""
        lanes = as_sets([lane for lane, _, _ in best.legs], best.sample.sets.shape[1])
        costs = course.store.costs(np.concatenate([lanes, best.sample.sets]))
        together = costs[: len(lanes)].min(axis=0, initial=math.inf).sum()
        regrasps = (len(lanes) - 1) * self._judge.problem.cost.regrasp
        return float(min(costs.sum(axis=1).min(initial=math.inf), together + regrasps))
