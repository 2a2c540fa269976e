"""From what a lattice search knows, on its way and at its end, to Progress and SearchResult."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol, final

from gm_ompl.errors import LimitError
from gm_ompl.planners.planner import Meter, Progress, Report, SearchResult, Status, silent
from gm_ompl.problem import Move

PROVEN = 1e-6
"""A plan is optimal where its cost is at most the lower bound times 1 + PROVEN."""


class Deciding(Protocol):
    """Whoever makes mode decisions."""

    @property
    def mode_decisions(self) -> int:
        """How many so far."""


@final
class Log:
    """What a search tells on its way, ever more rarely, and what it has done at its end.

    Args:
        meter: the running budget.
        judge: whose decisions are counted, from now on; None counts nothing.
        report: told of the progress.

    Attributes:
        meter: likewise.
        history: [time, cost or None, bound] of every event.
    """

    def __init__(
        self, meter: Meter, judge: Deciding | None = None, report: Report = silent
    ) -> None:
        self.meter, self.history = meter, list[list[float | None]]()
        self._judge, self._report, self._next_event = judge, report, 0.0
        self._before = 0 if judge is None else judge.mode_decisions
        self._cost, self._bound = math.inf, 0.0

    @property
    def decisions(self) -> int:
        """Mode decisions made since the start."""
        return 0 if self._judge is None else self._judge.mode_decisions - self._before

    def due(self) -> bool:
        """Whether it is time for an event."""
        return self.meter.elapsed() >= self._next_event

    def event(self, cost: float, bound: float, expanded: int, waiting: int) -> None:
        """Tell how far the search has come.

        Args:
            cost: of the best plan, or +inf.
            bound: no plan is cheaper.
            expanded: nodes or lanes expanded, or iterations.
            waiting: length of the open list.

        Searches that take turns know of different plans and bounds: the best of each is told.
        """
        self._cost, self._bound = min(cost, self._cost), max(bound, self._bound)
        cost, bound = self._cost, min(self._bound, self._cost)
        now = self.meter.elapsed()
        # Ever rarer: a day's search tells its story in a few hundred events.
        self._next_event = now + max(0.1, 0.02 * now)
        best = cost if cost < math.inf else None
        self.history.append([now, best, bound])
        self._report(Progress(now, expanded, waiting, self.decisions, best, bound))

    def statistics(self, expanded: int, generated: int, **more: int) -> dict[str, Any]:
        """Return the finished search's statistics, see ``SearchResult``."""
        return {
            "time_s": self.meter.elapsed(),
            "expanded": expanded,
            "generated": generated,
            "mode_decisions": self.decisions,
            **more,
            "history": self.history,
        }


def result_of(
    status: Status, best: float, bound: float, moves: Sequence[Move], statistics: dict[str, Any]
) -> SearchResult:
    """Return the result of a search.

    Args:
        status: how it ended.
        best: cost of the best plan, or +inf.
        bound: no plan is cheaper.
        moves: the best plan.
        statistics: see ``SearchResult``.
    """
    cost = math.fsum(move.cost for move in moves) if best < math.inf else None
    bound = bound if cost is None else min(bound, cost)
    return SearchResult(
        status=status,
        moves=tuple(moves),
        cost=cost,
        lower_bound=bound,
        optimal=cost is not None and cost <= bound * (1.0 + PROVEN),
        statistics=statistics,
    )


def without_search(status: Status, bound: float, meter: Meter, ended_by: str = "") -> SearchResult:
    """Return the result where nothing was searched; ``ended_by`` says which limit was reached."""
    log = Log(meter)
    log.event(math.inf, bound, 0, 0)
    statistics = log.statistics(0, 0, placement_sets=0)
    if ended_by:
        statistics["ended_by"] = ended_by
    return SearchResult(status=status, lower_bound=bound, statistics=statistics)


def status_of(run: Callable[[], Status], planned: Callable[[], bool]) -> Status:
    """Run a search; what ends it from outside becomes its status.

    Args:
        run: the search.
        planned: whether a plan is known, which is then what a spent budget leaves.
    """
    try:
        status = run()
    except LimitError:
        status = Status.BUDGET
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    return Status.SOLVED if status is Status.BUDGET and planned() else status
