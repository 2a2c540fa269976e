"""From what a lattice search knows, on its way and at its end, to Progress and SearchResult."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from gm_ompl.feasibility.judge import Judge
from gm_ompl.moves import Move
from gm_ompl.planners.planner import Meter, Progress, Report, SearchResult, Status

PROVEN = 1e-6
"""A plan is optimal where its cost is at most the lower bound times 1 + PROVEN."""


class Watched(Protocol):
    """What a running search shows of itself; costs are +inf where there is no plan."""

    @property
    def expanded(self) -> int:
        """Number of nodes or lanes expanded."""

    @property
    def cost(self) -> float:
        """Of the best plan known."""

    @property
    def bound(self) -> float:
        """No plan is cheaper."""

    @property
    def waiting(self) -> int:
        """Length of the open list."""


class Finished(Protocol):
    """What a finished search tells of its work."""

    @property
    def expanded(self) -> int:
        """Number of nodes or lanes expanded."""

    @property
    def generated(self) -> int:
        """Number of entries put on the open list."""

    @property
    def history(self) -> Sequence[tuple[float, float | None, float]]:
        """(time, cost or None, bound) now and then."""


def observer(meter: Meter, judge: Judge, report: Report) -> Callable[[Watched], None]:
    """Return what turns a search's state into Progress events, counting from now."""
    decided = judge.mode_decisions

    def observe(search: Watched) -> None:
        report(
            Progress(
                time=meter.elapsed(),
                expanded=search.expanded,
                open=search.waiting,
                mode_decisions=judge.mode_decisions - decided,
                cost=search.cost if search.cost < math.inf else None,
                lower_bound=search.bound,
            )
        )

    return observe


def statistics_of(
    search: Finished, meter: Meter, decisions: int, placement_sets: int
) -> dict[str, Any]:
    """Return a finished search's statistics, see ``SearchResult``."""
    return {
        "time_s": meter.elapsed(),
        "expanded": search.expanded,
        "generated": search.generated,
        "mode_decisions": decisions,
        "placement_sets": placement_sets,
        "history": [list(row) for row in search.history],
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


def without_search(status: Status, bound: float, meter: Meter) -> SearchResult:
    """Return the result where nothing was searched."""
    elapsed = meter.elapsed()
    statistics = {
        "time_s": elapsed,
        "expanded": 0,
        "generated": 0,
        "mode_decisions": 0,
        "placement_sets": 0,
        "history": [[elapsed, None, bound]],
    }
    return SearchResult(status=status, lower_bound=bound, statistics=statistics)
