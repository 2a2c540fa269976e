"""How good parameters are: measures of runs, and how one setting gains on another.

A measure is a positive number per run, small being good; a run without a plan counts as ten times
what it had spent. Runs are averaged by their logarithms, so that a factor counts alike on easy and
hard scenarios, and scenarios in any unit go together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.study.store import RunRecord
from gm_ompl.study.summary import RESAMPLES, SEED, Samples, ends

PENALTY = 10.0  # a run without a plan counts as this many times what it had spent, or as this cost
LEAST_S = 1e-4  # times below this are noise [s]


@dataclass(frozen=True)
class Gain:
    """One setting against another."""

    factor: float  # geometric mean of the measure with the old setting over that with the new
    low: float  # lower end of its 95% bootstrap interval
    high: float  # upper end
    solved: tuple[float, float]  # shares of runs with a plan, of the old and of the new setting

    @property
    def supported(self) -> bool:
        """Whether the new setting is better with confidence."""
        return self.low > 1.0


Reference = Mapping[str, float]


def _decisions(run: RunRecord, _: Reference) -> float:
    if run.first_plan_decisions is not None:
        return max(1.0, run.first_plan_decisions)
    return PENALTY * max(1.0, run.mode_decisions or 0)


def _time(run: RunRecord, _: Reference) -> float:
    if run.first_plan_s is not None:
        return max(LEAST_S, run.first_plan_s)
    return PENALTY * max(LEAST_S, run.search_s or run.wall_s)


TOLERANCE = "tolerance"

QUALITIES: Mapping[str, Callable[[RunRecord], float | None]] = {
    "cost": lambda run: run.cost,
    "z": lambda run: _inverse(run.least_z),
    TOLERANCE: lambda run: _inverse(run.tolerance),
}
"""What is small of a good plan, where there is one."""


def _inverse(value: float | None) -> float | None:
    return 1.0 / value if value is not None and 0.0 < value < math.inf else None


def _relative(name: str) -> Callable[[RunRecord, Reference], float | None]:
    """Return the measure that is a quality of the plan over the defaults' mean."""

    def measure(run: RunRecord, reference: Reference) -> float | None:
        if run.scenario_key not in reference:
            return None
        value = QUALITIES[name](run)
        return PENALTY if value is None else value / reference[run.scenario_key]

    return measure


MEASURES: Mapping[str, Callable[[RunRecord, Reference], float | None]] = {
    "decisions": _decisions, "time": _time, **{name: _relative(name) for name in QUALITIES},
}  # fmt: skip
"""Mode decisions to the first plan, which no machine changes; time to it [s]; and of the best plan,
over the defaults' mean on scenarios that they have planned: cost, 1 / z (with ranges of uncertainty
z_rob) and 1 / the common factor by which all ranges may be widened."""


def _references(name: str, base: Sequence[RunRecord]) -> dict[str, float]:
    """Return the geometric mean of a plan's quality by scenario, where there is one."""
    found: dict[str, list[float]] = {}
    for run in base:
        value = QUALITIES[name](run) if name in QUALITIES else None
        if value:
            found.setdefault(run.scenario_key, []).append(math.log(value))
    return {key: math.exp(float(np.mean(logs))) for key, logs in found.items()}


def _logs(name: str, runs: Sequence[RunRecord], reference: Reference) -> dict[str, Samples]:
    """Return the logarithms of a measure by scenario."""
    logs: dict[str, list[float]] = {}
    for run in runs:
        value = MEASURES[name](run, reference)
        if value is not None:
            logs.setdefault(run.scenario_key, []).append(math.log(value))
    return {key: np.array(values) for key, values in logs.items()}


def score(name: str, runs: Sequence[RunRecord], base: Sequence[RunRecord]) -> float:
    """Return the geometric mean of a measure over runs.

    What plans are like is relative to ``base``, the same runs with the defaults.
    """
    logs = _logs(name, runs, _references(name, base))
    return math.exp(float(np.mean(np.concatenate(list(logs.values()))))) if logs else 1.0


def gain(name: str, old: Sequence[RunRecord], new: Sequence[RunRecord]) -> Gain:
    """Return how the new setting's runs gain on the old one's, on the same scenarios.

    Scenarios are drawn anew, for both settings the same, then runs within each.
    """
    reference = _references(name, old)
    sides = _logs(name, old, reference), _logs(name, new, reference)
    pairs = [(sides[0][key], sides[1][key]) for key in sides[0] if key in sides[1]]
    solved = tuple(float(np.mean([run.solved for run in side])) for side in (old, new))
    shares = (solved[0], solved[1])
    if not pairs:
        return Gain(1.0, 0.0, math.inf, shares)
    means = np.array([a.mean() - b.mean() for a, b in pairs])
    rng = np.random.default_rng(SEED)
    # (scenarios, resamples): each scenario's difference with its runs drawn anew.
    drawn = np.array([_drawn(rng, a) - _drawn(rng, b) for a, b in pairs])
    chosen = rng.integers(len(pairs), size=(len(pairs), RESAMPLES))
    spread = np.take_along_axis(drawn, chosen, axis=0).mean(axis=0)
    low, high = map(math.exp, ends(spread))
    return Gain(math.exp(float(means.mean())), low, high, shares)


def _drawn(rng: np.random.Generator, sample: Samples) -> Samples:
    return np.asarray(rng.choice(sample, (RESAMPLES, sample.size)).mean(axis=1))
