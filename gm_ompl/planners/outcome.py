"""From what a lattice search knows at its end to a SearchResult."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from gm_ompl.moves import Move
from gm_ompl.planners.planner import Meter, SearchResult, Status

PROVEN = 1e-6
"""A plan is optimal where its cost is at most the lower bound times 1 + PROVEN."""


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
