"""What a comparison says: medians and success rates, and differences with their confidence."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from gm_ompl.study.store import RunRecord

RESAMPLES = 2000
CONFIDENCE = 0.95
SEED = 0  # of the resampling: the same runs give the same intervals

FAMILY = re.compile(r"(random/[^/]+)/\d+")
"""Scenarios drawn at random are taken together: each is one draw from its family."""

Samples: TypeAlias = npt.NDArray[np.float64]
Statistic: TypeAlias = Callable[[Samples], Samples]


@dataclass(frozen=True)
class Summary:
    """One planner on one scenario, or on the scenarios of a random family."""

    scenario: str  # its name, or the family's
    planner: str  # its name
    runs: int  # how many
    success: float  # share of the runs with a plan
    # median time to the first plan [s], runs without one counted as infinite; None where no more
    # than half have one
    first_plan_s: float | None
    cost: float | None  # median cost of the plans; None without plans
    # median of cost over the proven optimum, of the plans; None where that is unknown
    ratio: float | None
    regrasps: float | None  # median number, of the plans
    least_z: float | None  # median of the smallest stability margins, of the plans
    tolerance: float | None  # median of how far all ranges may be widened, of the plans, if known
    peak_mb: float  # median peak memory [MiB]
    decisions: float | None  # median number of mode decisions
    # runs per status other than solved or budget ("infeasible", "crash", ...)
    others: Mapping[str, int]


@dataclass(frozen=True)
class Difference:
    """A planner's figure minus the first planner's on the same scenario, with its interval."""

    scenario: str  # its name
    planner: str  # the planner
    against: str  # the first planner
    what: str  # "success", "first plan [s]", "cost / optimum", "least z" or "tolerance"
    value: float | None  # the difference; None where it is not finite
    # lower end of the 95% bootstrap interval, perhaps -inf; None where nothing is known
    low: float | None
    high: float | None  # upper end, perhaps +inf

    @property
    def supported(self) -> bool:
        """Whether the interval leaves out zero."""
        return self.low is not None and self.high is not None and not self.low <= 0.0 <= self.high


ORDINARY = ("solved", "budget")

Groups: TypeAlias = dict[str, dict[str, list[RunRecord]]]


def family(scenario: str) -> str:
    """Return a random scenario's family; the name of any other."""
    found = FAMILY.fullmatch(scenario)
    return found[1] if found else scenario


def grouped(records: Sequence[RunRecord], group: Callable[[str], str] = family) -> Groups:
    """Return the runs by group of scenarios and planner, in the order of first runs."""
    groups: Groups = {}
    for record in records:
        groups.setdefault(group(record.scenario), {}).setdefault(record.planner, []).append(record)
    return groups


def first_times(records: Sequence[RunRecord]) -> Samples:
    """Return the times to the first plan [s], +inf without one, shape (runs,)."""
    times = (record.first_plan_s for record in records)
    return np.array([math.inf if time is None else time for time in times])


def ratios(records: Sequence[RunRecord], optima: Mapping[str, float]) -> Samples:
    """Return cost over the optimum for the runs that have a plan and a known optimum."""
    return np.array([
        record.cost / optima[record.scenario_key]
        for record in records
        if record.cost is not None and optima.get(record.scenario_key, 0.0) > 0.0
    ])  # fmt: skip


def _values(name: str) -> Callable[[Sequence[RunRecord]], Samples]:
    """Return what gives a number of the runs that have one."""

    def values(records: Sequence[RunRecord]) -> Samples:
        found = (getattr(run, name) for run in records)
        return np.array([value for value in found if value is not None], dtype=np.float64)

    return values


def summarise(records: Sequence[RunRecord], optima: Mapping[str, float]) -> tuple[Summary, ...]:
    """Return a summary per scenario and planner."""
    return tuple(
        _summary(scenario, planner, runs, optima)
        for scenario, planners in grouped(records).items()
        for planner, runs in planners.items()
    )


def _summary(
    scenario: str, planner: str, runs: Sequence[RunRecord], optima: Mapping[str, float]
) -> Summary:
    others = Counter(run.status for run in runs if run.status not in ORDINARY)
    return Summary(
        scenario=scenario,
        planner=planner,
        runs=len(runs),
        success=float(np.mean([run.solved for run in runs])),
        first_plan_s=_median(first_times(runs)),
        ratio=_median(ratios(runs, optima)),
        **{
            name: _median([getattr(run, name) for run in runs])
            for name in ("cost", "regrasps", "least_z", "tolerance")
        },
        peak_mb=float(np.median([run.peak_mb for run in runs])),
        decisions=_median([run.mode_decisions for run in runs]),
        others=dict(others),
    )


def _median(values: Samples | Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return _finite(float(_medians(np.array(known)))) if known else None


def differences(
    records: Sequence[RunRecord], optima: Mapping[str, float]
) -> tuple[Difference, ...]:
    """Return how each planner differs from the first one, scenario by scenario.

    In a random family the scenarios, not the runs, are drawn anew, for both planners the same; cost
    is compared on those that both have planned. Margins are compared where tolerances are known.
    """
    found = []
    robust = any(run.tolerance is not None for run in records)
    for scenario, planners in grouped(records).items():
        (first, base), *others = planners.items()
        for planner, runs in others:
            for what, sample, statistic in (
                ("success", lambda runs: np.array([float(run.solved) for run in runs]), _means),
                ("first plan [s]", first_times, _medians),
                ("cost / optimum", lambda runs: ratios(runs, optima), _medians),
                *(
                    (
                        ("least z", _values("least_z"), _medians),
                        ("tolerance", _values("tolerance"), _medians),
                    )
                    if robust
                    else ()
                ),
            ):
                interval = _interval(runs, base, sample, statistic)
                found.append(Difference(scenario, planner, first, what, *interval))
    return tuple(found)


Interval: TypeAlias = tuple[float | None, float | None, float | None]


def _interval(
    runs: Sequence[RunRecord],
    base: Sequence[RunRecord],
    sample: Callable[[Sequence[RunRecord]], Samples],
    statistic: Statistic,
) -> Interval:
    keys = dict.fromkeys(run.scenario_key for run in base)
    if len(keys) == 1:
        return difference(sample(runs), sample(base), statistic)
    pairs = [
        tuple(sample([run for run in side if run.scenario_key == key]) for side in (runs, base))
        for key in keys
    ]
    return paired_difference([(a, b) for a, b in pairs if a.size and b.size], statistic)


def _means(samples: Samples) -> Samples:
    return np.asarray(np.mean(samples, axis=-1))


def _medians(samples: Samples) -> Samples:
    """Return medians along the last axis, of an even number the upper middle value.

    So a median of times is finite only where more than half of them are.
    """
    return np.asarray(np.sort(samples, axis=-1)[..., samples.shape[-1] // 2])


def difference(a: Samples, b: Samples, statistic: Statistic) -> Interval:
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
        return _interval_of(float(statistic(a) - statistic(b)), drawn[0] - drawn[1])


def paired_difference(pairs: Sequence[tuple[Samples, Samples]], statistic: Statistic) -> Interval:
    """Return what ``difference`` does, for samples that come in pairs, one pair per scenario.

    Whole pairs, neither sample empty, are drawn anew: what two planners share is how hard the
    scenarios are.
    """
    if not pairs:
        return None, None, None
    rng = np.random.default_rng(SEED)

    def value(chosen: Sequence[int]) -> float:
        a, b = (np.concatenate([pairs[i][side] for i in chosen]) for side in (0, 1))
        return float(statistic(a) - statistic(b))

    with np.errstate(invalid="ignore"):
        drawn = rng.integers(len(pairs), size=(RESAMPLES, len(pairs)))
        return _interval_of(value(range(len(pairs))), np.array([value(row) for row in drawn]))


def ends(drawn: Samples) -> tuple[float, float]:
    """Return the ends of the interval that holds 95% of what was drawn."""
    tail = (1.0 - CONFIDENCE) / 2.0
    low = np.quantile(drawn, tail, method="inverted_cdf")
    high = np.quantile(drawn, 1.0 - tail, method="inverted_cdf")
    return float(low), float(high)


def _interval_of(value: float, drawn: Samples) -> Interval:
    """Return the value and the ends of what was drawn; None where nothing is known."""
    low, high = (math.nan, math.nan) if np.isnan(drawn).any() else ends(drawn)
    if math.isnan(low) or not (math.isfinite(low) or math.isfinite(high)):
        return _finite(value), None, None
    return _finite(value), low, high


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
