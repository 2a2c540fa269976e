"""One run of one of OMPL's planners: limits, progress, and the path judged anew."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, final

import numpy as np
from ompl import util as ou

from gm_ompl.errors import PathError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.moves import Move
from gm_ompl.planners.ompl_path import judged_anew
from gm_ompl.planners.ompl_setup import HybridSetup
from gm_ompl.planners.ompl_trace import tell
from gm_ompl.planners.planner import (
    Budget,
    Meter,
    Planner,
    Progress,
    Report,
    SearchResult,
    Status,
)
from gm_ompl.planners.trace import tracer

_NO_MOVES: tuple[Move, ...] = ()

REPORT_EVERY = 64
"""Iterations between two progress events."""


@contextmanager
def silence() -> Iterator[None]:
    """Keep OMPL's own messages off the terminal."""
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    try:
        yield
    finally:
        ou.setLogLevel(level)


def run(
    planner: Planner,
    judge: Judge,
    budget: Budget,
    rng: np.random.Generator,
    report: Report,
) -> SearchResult:
    """Search with the OMPL planner that ``planner`` names and sets."""
    meter, decided = budget.start(), judge.mode_decisions
    with silence():
        setup = HybridSetup(judge, rng)
        watch = _Watch(setup, planner, meter, report, decided)
        status, moves = Status.BUDGET, _NO_MOVES
        try:
            if not setup.draws.start_and_goal_possible():
                status = Status.INFEASIBLE
            else:
                status, moves = _search(setup, planner, budget, watch)
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        cost = math.fsum(move.cost for move in moves) if status is Status.SOLVED else None
        watch.note(cost)
        trace = tracer(report)
        if trace is not None and watch.planner is not None:
            tell(setup.explored(), setup.motions, trace)
        return SearchResult(
            status=status,
            moves=moves,
            cost=cost,
            lower_bound=math.inf if status is Status.INFEASIBLE else 0.0,
            statistics=watch.statistics(),
        )


def _search(
    setup: HybridSetup, planner: Planner, budget: Budget, watch: _Watch
) -> tuple[Status, tuple[Move, ...]]:
    setup.use(planner)
    endless = budget.time_limit is None and budget.max_iterations is None and budget.stop is None
    if endless:
        setup.stop_at_first_plan()
    watch.planner = setup.getPlanner()
    setup.run(watch, watch.meter.spent)
    states = setup.solution()
    if states is None:
        return Status.BUDGET, _NO_MOVES
    try:
        return Status.SOLVED, judged_anew(setup.judge.problem, states)
    except PathError:
        watch.refuted += 1
        return Status.BUDGET, _NO_MOVES


@final
class _Watch:
    """Counts a run's iterations and tells when to stop; OMPL asks it once per iteration."""

    def __init__(
        self, setup: HybridSetup, asked: Planner, meter: Meter, report: Report, decided: int
    ) -> None:
        self.meter, self.planner = meter, None
        self.iterations = self.refuted = 0
        self._anytime, self._report = asked.specs.optimal, report
        self._motions, self._judge, self._decided = setup.motions, setup.judge, decided
        self._best: float | None = None
        self._history: list[list[float | None]] = []

    def __call__(self) -> bool:
        """Count an iteration; whether the run is over."""
        over = self.meter.spent(self.iterations)
        self.iterations += 1
        if self._anytime:
            self.note(_best_cost(self.planner))
        if self.iterations % REPORT_EVERY == 1:
            self._progress()
        return over

    def note(self, cost: float | None) -> None:
        """Note the cost of the best plan known, where it has become smaller."""
        if cost is not None and (self._best is None or cost < self._best):
            self._best = cost
            self._history.append([self.meter.elapsed(), cost, 0.0])

    def _progress(self) -> None:
        self._report(
            Progress(
                time=self.meter.elapsed(),
                expanded=self.iterations,
                open=0,
                mode_decisions=self._judge.mode_decisions - self._decided,
                cost=self._best,
                lower_bound=0.0,
            )
        )

    def statistics(self) -> dict[str, Any]:
        """Return what the run did."""
        elapsed = self.meter.elapsed()
        return {
            "time_s": elapsed,
            "expanded": self.iterations,
            "generated": self._motions.asked,
            "valid_motions": self._motions.valid,
            "mode_decisions": self._judge.mode_decisions - self._decided,
            "refuted_paths": self.refuted,
            "history": self._history or [[elapsed, None, 0.0]],
        }


def _best_cost(planner: Any) -> float | None:
    """Return the cost that an improving planner claims for its best path, or None."""
    cost = float(planner.bestCost().value())
    return cost if math.isfinite(cost) else None
