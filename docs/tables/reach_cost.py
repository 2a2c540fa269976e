"""``python -m docs.tables.reach_cost [PAGE]``: what ways through the air cost.

Every scenario is planned with ways through the air and without (``fingers.transit: false``), by
turns in one process, several times, and the CPU time of ``plan`` compared; what is shown is the
median of the ratios of neighbours. Takes a quarter of an hour on one core.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from statistics import median
from typing import NamedTuple

import gm_ompl
from docs.tables.pages import growing, write_page
from gm_ompl.scenario.families import FAMILIES
from gm_ompl.scenario.load import shipped
from gm_ompl.study.report import number

SEEDS = range(3)  # of each random family
FIRST, BEST = "HybridRRT", "astar"
MOST = {FIRST: 1.10, BEST: 1.25}
"""What is asked of the median over the scenarios."""

TURNS = {FIRST: 9, BEST: 5}
LIMIT = 20.0
"""Searches that do not end within this [s] are not compared."""

HEAD = ("scenario", "planner", "without [s]", "with [s]", "ratio")


class ReachCost(NamedTuple):
    """CPU times of one scenario [s], and the median of their ratios."""

    without: float
    through: float
    ratio: float


def scenarios() -> Iterator[str]:
    """Yield names: the shipped scenarios that prescribe a way or a plane, and of the families."""
    yield from (name for name in shipped() if not name.startswith(("free/", "tasks/")))
    plain = (family for family in FAMILIES if not family.startswith("free"))
    yield from (f"random/{family}/{seed}" for family in plain for seed in SEEDS)


def seconds(scenario: gm_ompl.Scenario, planner: str, seed: int) -> float | None:
    """Return the CPU time of one plan [s]; None where the search does not end."""
    started = time.process_time()
    plan = gm_ompl.plan(scenario, planner, time_limit=LIMIT, seed=seed)
    spent = time.process_time() - started
    return None if plan.status == "budget" or not (plan.optimal or planner == FIRST) else spent


def compared(name: str, planner: str) -> ReachCost | None:
    """Return what one scenario costs; None where there is nothing to compare."""
    loaded = gm_ompl.load(name)
    both = [loaded.with_({"fingers.transit": transit}) for transit in (False, True)]
    if None in [seconds(scenario, planner, 0) for scenario in both]:  # and all is compiled
        return None
    pairs = []
    for seed in range(TURNS[planner]):
        without, through = (seconds(scenario, planner, seed) for scenario in both)
        if without is not None and through is not None:
            pairs.append((without, through))
    if not pairs:
        return None
    without, through = (median(times) for times in zip(*pairs, strict=True))
    return ReachCost(without, through, median(b / a for a, b in pairs))


def rows(names: Sequence[str]) -> Iterator[tuple[object, ...]]:
    """Yield the rows of the table, the medians over all scenarios last."""
    ratios: dict[str, list[float]] = {planner: [] for planner in MOST}
    for name in names:
        for planner in MOST:
            cost = compared(name, planner)
            if cost is not None:
                ratios[planner].append(cost.ratio)
                yield name, planner, *map(number, cost)
    for planner, found in ratios.items():
        if found:
            asked = f"{number(median(found))} (at most {MOST[planner]:g} is asked)"
            yield f"median of {len(found)}", planner, "", "", asked


def main() -> None:
    """Measure and write the page."""
    write_page("reach", {"cost": growing(HEAD, rows(list(scenarios())))})


if __name__ == "__main__":
    main()
