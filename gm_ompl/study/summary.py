"""What a comparison says: medians and success rates, and differences with their confidence."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from gm_ompl.study.store import Record

RESAMPLES = 2000
CONFIDENCE = 0.95
SEED = 0
"""Of the resampling: the same runs give the same intervals."""

Samples: TypeAlias = npt.NDArray[np.float64]
Statistic: TypeAlias = Callable[[Samples], Samples]


@dataclass(frozen=True)
class Summary:
    """One planner on one scenario.

    Attributes:
        scenario: its name.
        planner: its name.
        runs: how many.
        success: share of the runs with a plan.
        first_plan_s: median time to the first plan [s], runs without one counted as infinite; None
            where no more than half have one.
        cost: median cost of the plans; None without plans.
        ratio: median of cost over the proven optimum, of the plans; None where that is unknown.
        regrasps: median number, of the plans.
        least_z: median of the smallest stability margins, of the plans.
        peak_mb: median peak memory [MiB].
        failures: runs per status other than the planner's own ("crash", "timeout", ...).
    """

    scenario: str
    planner: str
    runs: int
    success: float
    first_plan_s: float | None
    cost: float | None
    ratio: float | None
    regrasps: float | None
    least_z: float | None
    peak_mb: float
    failures: Mapping[str, int]


@dataclass(frozen=True)
class Difference:
    """A planner's figure minus the first planner's on the same scenario, with its interval.

    Attributes:
        scenario: its name.
        planner: the planner.
        against: the first planner.
        what: "success", "first plan [s]" or "cost / optimum".
        value: the difference; None where it is not finite.
        low: lower end of the 95% bootstrap interval, perhaps -inf; None where nothing is known.
        high: upper end, perhaps +inf.
    """

    scenario: str
    planner: str
    against: str
    what: str
    value: float | None
    low: float | None
    high: float | None

    @property
    def supported(self) -> bool:
        """Whether the interval leaves out zero."""
        return self.low is not None and self.high is not None and not self.low <= 0.0 <= self.high


PLANNERS_OWN = ("solved", "infeasible", "budget")


def grouped(records: Sequence[Record]) -> dict[str, dict[str, list[Record]]]:
    """Return the runs by scenario and planner, both in the order of their first run."""
    groups: dict[str, dict[str, list[Record]]] = {}
    for record in records:
        groups.setdefault(record.scenario, {}).setdefault(record.planner, []).append(record)
    return groups


def first_times(records: Sequence[Record]) -> Samples:
    """Return the times to the first plan [s], +inf without one, shape (runs,)."""
    times = (record.first_plan_s for record in records)
    return np.array([math.inf if time is None else time for time in times])


def ratios(records: Sequence[Record], optima: Mapping[str, float]) -> Samples:
    """Return cost over the optimum for the runs that have a plan and a known optimum."""
    return np.array([
        record.cost / optima[record.scenario_key]
        for record in records
        if record.cost is not None and optima.get(record.scenario_key, 0.0) > 0.0
    ])  # fmt: skip


def summarise(records: Sequence[Record], optima: Mapping[str, float]) -> tuple[Summary, ...]:
    """Return a summary per scenario and planner."""
    return tuple(
        _summary(scenario, planner, runs, optima)
        for scenario, planners in grouped(records).items()
        for planner, runs in planners.items()
    )


def _summary(
    scenario: str, planner: str, runs: Sequence[Record], optima: Mapping[str, float]
) -> Summary:
    failures: dict[str, int] = {}
    for run in runs:
        if run.status not in PLANNERS_OWN:
            failures[run.status] = failures.get(run.status, 0) + 1
    return Summary(
        scenario=scenario,
        planner=planner,
        runs=len(runs),
        success=float(np.mean([run.solved for run in runs])),
        first_plan_s=_median(first_times(runs)),
        cost=_median([run.cost for run in runs]),
        ratio=_median(ratios(runs, optima)),
        regrasps=_median([run.regrasps for run in runs]),
        least_z=_median([run.least_z for run in runs]),
        peak_mb=float(np.median([run.peak_mb for run in runs])),
        failures=failures,
    )


def _median(values: Samples | Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return _finite(float(_medians(np.array(known)))) if known else None


def differences(records: Sequence[Record], optima: Mapping[str, float]) -> tuple[Difference, ...]:
    """Return how each planner differs from the first one, scenario by scenario."""
    found = []
    for scenario, planners in grouped(records).items():
        (first, base), *others = planners.items()
        for planner, runs in others:
            for what, sample, statistic in (
                ("success", _successes, _means),
                ("first plan [s]", first_times, _medians),
                ("cost / optimum", lambda runs: ratios(runs, optima), _medians),
            ):
                interval = difference(sample(runs), sample(base), statistic)
                found.append(Difference(scenario, planner, first, what, *interval))
    return tuple(found)


def _successes(records: Sequence[Record]) -> Samples:
    return np.array([float(record.solved) for record in records])


def _means(samples: Samples) -> Samples:
    return np.asarray(np.mean(samples, axis=-1))


def _medians(samples: Samples) -> Samples:
    """Return medians along the last axis, of an even number the upper middle value.

    So a median of times is finite only where more than half of them are.
    """
    return np.asarray(np.sort(samples, axis=-1)[..., samples.shape[-1] // 2])


def difference(
    a: Samples, b: Samples, statistic: Statistic
) -> tuple[float | None, float | None, float | None]:
    """Return statistic(a) - statistic(b) and the ends of its 95% percentile bootstrap interval.

    The two samples are drawn anew independently: runs of different planners with one seed have
    nothing in common.

    Args:
        a: shape (m,), may hold +inf.
        b: shape (n,), may hold +inf.
        statistic: along the last axis.

    Returns:
        The difference, None where it is not finite; and both ends, of which one may be infinite,
        None where nothing is known.
    """
    if not a.size or not b.size:
        return None, None, None
    rng = np.random.default_rng(SEED)
    drawn = [statistic(rng.choice(x, (RESAMPLES, x.size))) for x in (a, b)]
    with np.errstate(invalid="ignore"):
        value = float(statistic(a) - statistic(b))
        spread = np.sort(drawn[0] - drawn[1])
    tail = (1.0 - CONFIDENCE) / 2.0
    low = float(spread[int(tail * RESAMPLES)])
    high = float(spread[int((1.0 - tail) * RESAMPLES) - 1])
    if np.isnan(spread).any() or not (math.isfinite(low) or math.isfinite(high)):
        return _finite(value), None, None
    return _finite(value), low, high


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
