"""Runs a randomised search under a budget and says how it ended."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goals import restricted
from gm_ompl.graph.sets import ordered_sets
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.moves import Move
from gm_ompl.planners.hybrid_trace import Growth
from gm_ompl.planners.outcome import result_of
from gm_ompl.planners.planner import Budget, Progress, Report, SearchResult, Status
from gm_ompl.planners.trace import tracer
from gm_ompl.problem import Problem
from gm_ompl.sampling.explorer import Course
from gm_ompl.sampling.tree import Stop


class Search(Protocol):
    """A search that goes on an iteration at a time."""

    cost: float
    moves: tuple[Move, ...]

    @property
    def branches(self) -> int:
        """How much it has gathered."""

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far, with the trees grown along them."""

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether the best plan changed."""


@final
class HybridRun:
    """One run of a randomised search.

    Args:
        judge: answers about the problem.
        budget: what may be spent.
        report: called now and then with the progress.

    Attributes:
        meter: the running budget.
    """

    def __init__(self, judge: Judge, budget: Budget, report: Report) -> None:
        self.meter = budget.start()
        self._judge, self._report = judge, report
        trace = tracer(report)
        self._growth = None if trace is None else Growth(judge.problem, trace)
        self._decided = judge.mode_decisions
        self._iterations = 0
        self._history: list[list[float | None]] = []
        self._next_event = 0.0

    def until_first(self, search: Search) -> SearchResult:
        """Search until there is a plan or the budget is spent."""
        return self._run(search, patience=0)

    def improve(self, search: Search, patience: int | None) -> SearchResult:
        """Search until the budget is spent, or for ``patience`` iterations in vain."""
        return self._run(search, patience)

    def _run(self, search: Search, patience: int | None) -> SearchResult:
        status = Status.BUDGET
        try:
            self._loop(search, patience)
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        if status is Status.BUDGET and search.cost < math.inf:
            status = Status.SOLVED
        self._event(search)
        statistics: dict[str, Any] = {
            "time_s": self.meter.elapsed(),
            "expanded": self._iterations,
            "generated": search.branches,
            "mode_decisions": self._judge.mode_decisions - self._decided,
            "history": self._history,
        }
        return result_of(status, search.cost, 0.0, search.moves, statistics)

    def _loop(self, search: Search, patience: int | None) -> None:
        def stop() -> bool:
            return self.meter.spent(self._iterations)

        last = 0
        while not stop():
            changed = search.step(stop)
            self._iterations += 1
            if self._growth is not None:
                self._growth.grown(search.courses)
                if changed:
                    self._growth.planned(search.moves)
            if changed:
                last = self._iterations
                self._event(search)
            elif self.meter.elapsed() >= self._next_event:
                self._event(search)
            waited = self._iterations - last
            if patience is not None and search.cost < math.inf and waited >= patience:
                return

    def _event(self, search: Search) -> None:
        now = self.meter.elapsed()
        # Ever rarer: a long run tells its story in a few hundred events.
        self._next_event = now + max(0.1, 0.02 * now)
        cost = search.cost if search.cost < math.inf else None
        self._history.append([now, cost, 0.0])
        self._report(
            Progress(
                time=now,
                expanded=self._iterations,
                open=search.branches,
                mode_decisions=self._judge.mode_decisions - self._decided,
                cost=cost,
                lower_bound=0.0,
            )
        )


def impossible(problem: Problem, judge: Judge) -> bool:
    """Whether it is proven that no plan exists: no set is valid at the start, or at the goal.

    A goal that is a region is not searched for proofs.
    """
    if not _has_set(problem, judge, problem.start, problem.fingers.start):
        return True
    low, high = problem.goal.low, problem.goal.high
    if None in low or low != high:
        return False
    goal = tuple(float(value or 0.0) for value in low)
    return not _has_set(problem, judge, goal, problem.fingers.goal)


def _has_set(problem: Problem, judge: Judge, q: Coordinates, given: tuple[int | None, ...]) -> bool:
    geometry = judge.node(problem.motion.pose(q))
    if not geometry.object_free:
        return False
    allowed = restricted(geometry.free, given)
    keys = [np.zeros(len(mask)) for mask in allowed]
    sets = ordered_sets(problem.fingers.groups(), allowed, keys, judge.clear)
    return next(sets, None) is not None
