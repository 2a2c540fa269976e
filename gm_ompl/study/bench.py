"""The project's own speed as ratios in one run: what ``gm-ompl bench`` shows."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from gm_ompl import api
from gm_ompl.study.bench_decisions import Searched, Times, batch_gain, searched, timed
from gm_ompl.study.bench_plans import (
    Solved,
    decisions_per_node,
    profiled,
    solved,
    startup,
)
from gm_ompl.study.measure import measure

Json: TypeAlias = dict[str, Any]
Note: TypeAlias = Callable[[str], None]

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
SEARCHES = ("astar", "dijkstra")


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        repeat: repetitions of what is short.
        decisions: drawn per search for the kernel.
        with_highs: of these, made with HiGHS too.
        search_limit: wall time of a search [s].
    """

    repeat: int = 5
    decisions: int = 1000
    with_highs: int = 12
    search_limit: float = 10.0


@dataclass
class _Pool:
    """Times of all decisions so far, per search."""

    times: dict[str, list[Times]] = field(default_factory=dict)

    def row(self, search: str) -> Json:
        parts = self.times.get(search, [])
        return _decision_row("all", search, None, _joined(parts))


def bench(
    scenarios: Sequence[str] = SCENARIOS,
    effort: Effort | None = None,
    overrides: Sequence[str] = (),
    note: Note = lambda _: None,
) -> Json:
    """Measure; what comes back is plain JSON, times in the unit that a key's end names.

    Args:
        scenarios: shipped names or files of one coordinate.
        effort: how much is measured.
        overrides: "KEY=VALUE" changes of every scenario.
        note: told what is being measured.
    """
    effort = effort or Effort()
    problems = {name: api.load(name, overrides).problem for name in scenarios}
    note("start-up")
    help_s, first_plan_s = startup(scenarios[0], overrides, effort.repeat)
    pool, decisions, plans = _Pool(), [], []
    for name, problem in problems.items():
        note(f"{name}: decisions and plans")
        found = {search: searched(problem, search, effort.search_limit) for search in SEARCHES}
        for search, one in found.items():
            times = timed(one, effort.decisions, effort.with_highs, effort.repeat)
            pool.times.setdefault(search, []).append(times)
            decisions.append(_decision_row(name, search, one, times))
        highs = [t for parts in pool.times.values() for t in parts[-1].highs]
        plan = solved(problem, effort.repeat, effort.search_limit)
        plans.append(_plan_row(name, plan, found["dijkstra"], _mean(highs)))
        plans[-1]["batch_gain"] = batch_gain(found["dijkstra"], effort.decisions, effort.repeat)
        plans[-1]["profile"] = profiled(problem, effort.search_limit)
        plans[-1]["peak_mb"] = measure(name, overrides=overrides, repeat=False).megabytes
    return {
        "machine": _machine(),
        "decisions": [*decisions, *(pool.row(search) for search in SEARCHES)],
        "plans": plans,
        "start": {"help_s": help_s, "first_plan_s": first_plan_s, "scenario": scenarios[0]},
    }


def _joined(parts: Sequence[Times]) -> Times:
    return Times(
        [t for part in parts for t in part.kernel],
        [t for part in parts for t in part.both_force],
        [t for part in parts for t in part.kernel_of_sample],
        [t for part in parts for t in part.highs],
        [t for part in parts for t in part.highs_whole],
    )


def _decision_row(name: str, search: str, found: Searched | None, times: Times) -> Json:
    sample = times.kernel_of_sample
    return {
        "scenario": name,
        "search": search,
        "asked": None if found is None else len(found.asked),
        "drawn": len(times.kernel),
        "kernel_median_ms": _median(times.kernel),
        "kernel_p95_ms": float(np.quantile(times.kernel, 0.95)) if times.kernel else None,
        "both_force": len(times.both_force),
        "both_force_median_ms": _median(times.both_force),
        "highs_drawn": len(sample),
        "highs_median_ms": _median(times.highs),
        "highs_whole_median_ms": _median(times.highs_whole),
        "ratio": _median([h / k for h, k in zip(times.highs, sample, strict=True)]),
        "ratio_whole": _median([h / k for h, k in zip(times.highs_whole, sample, strict=True)]),
    }


def _plan_row(name: str, plan: Solved, plain: Searched, mean_ms: float | None) -> Json:
    """Return a row; the plain search's time is its counted decisions times their measured mean."""
    per_node = decisions_per_node(plain.problem)
    expanded = int(plain.result.statistics["expanded"])
    plain_s = None if mean_ms is None else 1e-3 * mean_ms * per_node * expanded
    return {
        "scenario": name,
        "optimal": plan.optimal,
        "seconds": plan.seconds,
        "expanded": plan.expanded,
        "mode_decisions": plan.decisions,
        "plain_expanded": expanded,
        "plain_is_whole": plain.result.optimal,
        "plain_decisions": per_node * expanded,
        "plain_mean_decision_ms": mean_ms,
        "plain_s": plain_s,
        "ratio": None if plain_s is None else plain_s / plan.seconds,
    }


def _median(values: Sequence[float]) -> float | None:
    return statistics.median(values) if values else None


def _mean(values: Sequence[float]) -> float | None:
    return statistics.fmean(values) if values else None


def _machine() -> Json:
    return {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
    }
