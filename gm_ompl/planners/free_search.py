"""Exact search of free motion, whose object graph is made on demand.

Two searches share the work. One is for plans that regrasp at most once; it needs few poses where
those that regrasp more often are dearer than the best plan. The other is over lanes, in ever larger
parts of the object graph, until no better plan can leave the part. Whichever ends first has the
proof.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final, final

import numpy as np

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.closure import Closure
from gm_ompl.holds.watch import Stop
from gm_ompl.planners.impossible import impossible
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.lane_parts import PartSearch, PartTask, cheaper, part_search
from gm_ompl.planners.outcome import PROVEN, Log, result_of, without_search
from gm_ompl.planners.planner import Report, SearchResult, Status
from gm_ompl.problem import Problem

TURN: Final = 5.0
"""A turn of lanes is no shorter [s]."""

PER_SECOND: Final = 2000
"""Where iterations are limited so many count as a second: then turns fall the same every time."""

FEW_NODES: Final = 4000
"""Where these may have the proof, larger parts of the object graph are not searched over lanes."""

SHARE: Final = 5.0
"""Plans that regrasp at most once get so many times the time of lanes."""

BUILDING: Final = 2.0
"""Before it is searched, a part takes about so many times as long as finding its nodes."""


@final
class FreeSearch:
    """One search; ``run`` may be called once.

    Args:
        problem: what to plan.
        judge: answers about it; its back end is the kernel's.
        log: told of the progress; its budget is spent.
        report: likewise.
    """

    def __init__(self, problem: Problem, judge: Judge, log: Log, report: Report) -> None:
        self._problem, self._judge, self._log, self._report = problem, judge, log, report
        self._result = without_search(Status.BUDGET, 0.0, log.meter)
        self._kept: KeptSearch | None = None
        self._part: PartSearch | None = None
        self._reached = False
        self._counts = np.zeros((2, 2), dtype=np.int64)  # expanded, generated: before, in this part
        self._taken = [0.0, 0.0]  # by lanes, and by the other search [s]
        self._asked = 0  # iterations of both
        self._paused = False  # whether a turn of lanes was over
        self._resting = False  # whether lanes leave the proof to the other search
        self._growing = 0.0  # what the closure has taken [s]
        self._due = 0.0  # what building the next part will take, where that waits [s]

    def run(self) -> SearchResult:
        """Search for a plan of least cost."""
        try:
            if impossible(self._problem, self._judge):
                return without_search(Status.INFEASIBLE, math.inf, self._log.meter)
            closure = Closure(self._judge, self._log.meter.spent)
            self._kept = KeptSearch.of(self._judge, self._log)
            while not (self._keep() or self._by_lanes(closure)):
                pass
        except KeyboardInterrupt:
            self._take_kept()
            return dataclasses.replace(self._counted(self._result), status=Status.INTERRUPTED)
        except LimitError as stopped:
            self._take_kept()
            ended = {"ended_by": str(stopped)} if str(stopped) else {}
            counted = self._counted(self._result)
            return dataclasses.replace(counted, statistics={**counted.statistics, **ended})
        return self._result

    def _by_lanes(self, closure: Closure) -> bool:
        """Let lanes have a turn; whether that is all."""
        before, turn, self._paused = self._now(), math.inf, False
        if self._kept is not None and not self._kept.done:
            turn = max(TURN, self._taken[1] / SHARE - self._taken[0])

        def pause() -> bool:
            self._asked += 1
            self._paused = self._now() - before > turn
            return self._paused

        try:
            while self._grown(closure, pause):
                if self._search(closure, pause):
                    return True
                if self._paused or pause():
                    break
            return False
        finally:
            self._taken[0] += self._now() - before

    def _now(self) -> float:
        """Return how far the search has come [s], or by how many iterations."""
        meter = self._log.meter
        limited = meter.budget.max_iterations is not None
        return self._asked / PER_SECOND if limited else meter.elapsed()

    def _grown(self, closure: Closure, pause: Stop) -> bool:
        """Whether there is a part to be searched; where the last one is done, it grows."""
        if self._part is not None:
            return True
        before = self._now()
        try:
            grown = self._grow(closure, pause)
        finally:
            self._growing += self._now() - before
        return grown and self._affords()

    def _grow(self, closure: Closure, pause: Stop) -> bool:
        """Whether the closure has grown to the next part; it is gone on with where not."""
        cost = self._result.cost
        if cost is None:
            if not self._reached and not self._reach(closure, pause):
                return False
            return self._due > 0.0 or closure.double(pause)
        kept = self._kept
        if kept is not None and cost <= kept.bound * (1.0 + PROVEN):
            return False
        proves = kept is not None and not kept.done and kept.proves(cost)
        most = max(FEW_NODES, len(closure)) if proves else math.inf
        if not closure.grow(cost, most, pause):
            return False
        self._resting = closure.next <= cost and proves
        return not self._resting

    def _affords(self) -> bool:
        """Whether the other search had its share of what building a part will take."""
        self._due = BUILDING * self._growing
        if self._due > TURN:
            kept, share = self._kept, SHARE * (self._taken[0] + self._due)
            if kept is not None and not kept.done and self._taken[1] < share:
                return False
        self._due = 0.0
        return True

    def _reach(self, closure: Closure, pause: Stop) -> bool:
        """Grow a part until the goal is in it, or it is whole; whether it is so."""
        try:
            self._reached = closure.to_goal(pause) is not None
        finally:
            if not self._reached:  # every plan leaves it
                bound = max(self._result.lower_bound, closure.next)
                self._result = dataclasses.replace(self._result, lower_bound=bound)
        return self._reached

    def _search(self, closure: Closure, pause: Stop) -> bool:
        """Search a part over lanes, or go on with that; whether that is all."""
        ask = self._problem, self._judge, self._log, self._report
        part = self._part or part_search(PartTask(*ask, closure, self._result.cost))
        self._log.meter.elsewhere = int(self._counts[0, 0])
        found, self._part = part.run(pause), part
        self._counts[1] = found.statistics["expanded"], found.statistics["generated"]
        before = self._result.lower_bound
        self._result = _within(cheaper(self._result, self._counted(found)), closure.next, before)
        if not part.exhausted:
            return found.status is Status.INTERRUPTED or not self._paused
        self._part = None
        self._counts[0] += self._counts[1]
        self._counts[1] = 0
        return closure.next == math.inf or self._result.optimal

    def _counted(self, found: SearchResult) -> SearchResult:
        """Return what was found with the counts of the whole search."""
        counts = self._log.statistics(*self._counts.sum(axis=0).tolist())
        return dataclasses.replace(found, statistics={**found.statistics, **counts})

    def _keep(self) -> bool:
        """Go on with plans that regrasp at most once; whether a plan is optimal."""
        kept, cost = self._kept, self._result.cost
        if kept is None:
            return False
        share = SHARE * (self._taken[0] + max(TURN, self._due))
        most = math.inf if self._resting else share
        while self._taken[1] < most and not kept.done:
            before, expanded = self._now(), kept.expanded
            self._log.meter.elsewhere = int(self._counts[:, 0].sum())
            kept.step(math.inf if cost is None else cost)
            self._counts[0, 0] += kept.expanded - expanded
            self._asked += kept.expanded - expanded
            self._taken[1] += self._now() - before
        self._take_kept()
        return self._result.optimal

    def _take_kept(self) -> None:
        """Take over what the other search has found so far."""
        kept, result = self._kept, self._result
        if kept is None:
            return
        bound, counted = max(result.lower_bound, kept.bound), self._counted(result)
        if kept.cost < (math.inf if result.cost is None else result.cost):
            solved = Status.SOLVED, kept.cost, bound, kept.moves()
            self._result = result_of(*solved, dict(counted.statistics))
            self._log.event(kept.cost, bound, kept.expanded, kept.waiting)
            return
        bound = bound if result.cost is None else min(bound, result.cost)
        optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
        self._result = dataclasses.replace(counted, lower_bound=bound, optimal=optimal)


def _within(result: SearchResult, beyond: float, before: float) -> SearchResult:
    """Return what was found in a part of the object graph.

    Args:
        result: in that part.
        beyond: what plans that leave it cost at least.
        before: what was known that all cost at least.
    """
    if result.status is Status.INFEASIBLE and beyond == math.inf:
        return result
    if result.status is Status.INFEASIBLE:
        return dataclasses.replace(result, status=Status.BUDGET, lower_bound=max(beyond, before))
    bound = max(before, min(result.lower_bound, beyond))
    bound = bound if result.cost is None else min(bound, result.cost)
    optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
    return dataclasses.replace(result, lower_bound=bound, optimal=optimal)
