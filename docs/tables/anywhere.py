"""``python -m docs.tables.anywhere [PAGE]``: finer grids against continuous placements.

Writes the tables into PAGE (its own) and the picture beside it (images/continuous.svg). Takes about
twenty minutes on one core.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gm_ompl.viz.canvas import COLUMN, new_figure, save, styled

from docs.tables.pages import growing, write_tables
from gm_ompl import api
from gm_ompl.asking import judge_of
from gm_ompl.planners.lane_parts import FEW_SETS, set_count
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Regrasp
from gm_ompl.study.report import number

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
GRIDS = (7, 13, 21, 51, 101)
GAPS = ("1%", "0.1%")
MARGIN = 0.5
LIMIT = 120.0  # wall time per search [s]

GROWING = ("paper/tumble", "paper/regrasp")
FINER = (3, 5, 7, 9, 13, 21, 51)
FINGERS = (2, 3, 4)
SAMPLER = "HybridRRTConnect"
SEEDS = 3

ANY_MOTION = {
    **dict.fromkeys(SCENARIOS, MARGIN),
    "planar/turn": 0.3,
    "planar/corner": 0.5,
    "free/stairs": 0.25,
    "tasks/flip-cube": 0.1,
    "tasks/ledge": 0.02,
}
"""Margins."""
DRAWS = 3  # seeds
SECONDS = 10.0  # CPU time

SAMPLED = (
    "scenario",
    "margin",
    "first plan: CPU s",
    "cost",
    f"HybridRRTstar, {SECONDS:g} CPU s: cost",
    "regrasps",
    "lower bound (astar)",
)
HEAD = ("scenario", "placements", "ends", "cost", "lower bound", "CPU s")
TIMES = (
    "scenario",
    "grid",
    "fingers",
    "sets of placements",
    "exact by",
    "CPU s",
    "sampling, CPU s",
)


@dataclass(frozen=True)
class Timed:
    """One search: its plan and CPU time [s]."""

    plan: Any
    seconds: float


def timed(scenario: str, planner: str, changes: Mapping[str, Any], seed: int = 0) -> Timed:
    """Search twice; the second time counts."""
    loaded = api.load(scenario, dict(changes))
    for _ in range(2):
        started = time.process_time()
        plan = api.plan(loaded, planner, time_limit=LIMIT, seed=seed)
        seconds = time.process_time() - started
    return Timed(plan, seconds)


def converging(
    scenarios: Sequence[str], grids: Sequence[int], gaps: Sequence[str]
) -> Iterator[Any]:
    """Yield a row per scenario and grid, then one per gap on continuous placements."""
    for scenario in scenarios:
        for m in grids:
            grid = {"fingers.placements.grid": [m, m], "fingers.placements.margin": MARGIN}
            yield _row(scenario, f"{m} x {m}", timed(scenario, "astar", grid))
        for gap in gaps:
            said = {"fingers.placements.continuous": {"margin": MARGIN, "gap": gap}}
            yield _row(scenario, f"continuous, gap {gap}", timed(scenario, "astar", said))


def _row(scenario: str, where: str, found: Timed) -> tuple[str, ...]:
    plan = found.plan
    ends = "proven optimal" if plan.optimal else plan.status
    numbers = (number(plan.cost, 6), number(plan.lower_bound, 6), number(found.seconds, 3))
    return f"`{scenario}`", where, ends, *numbers


def against(
    cases: Sequence[tuple[str, int, int]], known: dict[str, list[tuple[float, float]]]
) -> Iterator[Any]:
    """Yield a row per case of scenario, grid and fingers; ``known`` gets sets and CPU times."""
    for scenario, m, n in cases:
        changes = {"fingers.placements.grid": [m, m], "fingers.count": n}
        sets = set_count(api.load(scenario, changes).problem)
        exact, by = timed(scenario, "astar", changes), "lanes" if sets <= FEW_SETS else "cells"
        sampled = [timed(scenario, SAMPLER, changes, seed) for seed in range(SEEDS)]
        middle = statistics.median(each.seconds for each in sampled)
        if exact.plan.optimal:
            known.setdefault(f"{scenario}, {by}", []).append((float(sets), exact.seconds))
        if all(each.plan.cost is not None for each in sampled):
            known.setdefault(f"{scenario}, sampling", []).append((float(sets), middle))
        ends = number(exact.seconds, 3) + ("" if exact.plan.optimal else ", not proven")
        yield f"`{scenario}`", f"{m} x {m}", n, number(float(sets), 3), by, ends, number(middle, 3)


def sampled(margins: Mapping[str, float], seeds: int, seconds: float) -> Iterator[Any]:
    """Yield a row per scenario: medians of first plans and of what more time makes of them."""
    for scenario, margin in margins.items():
        said = {"fingers.placements.continuous": {"margin": margin, "gap": GAPS[-1]}}
        first = [timed(scenario, SAMPLER, said, seed) for seed in range(seeds)]
        best = [best_within(scenario, said, seed, seconds) for seed in range(seeds)]
        on_path = api.load(scenario, said).problem.motion.dimension == 1
        bound = number(timed(scenario, "astar", said).plan.lower_bound, 6) if on_path else "-"
        yield (
            f"`{scenario}`",
            f"{margin:g}",
            number(statistics.median(each.seconds for each in first), 3),
            number(statistics.median(each.plan.cost for each in first), 6),
            number(statistics.median(cost for cost, _ in best), 6),
            f"{statistics.median(regrasps for _, regrasps in best):g}",
            bound,
        )


def best_within(
    scenario: str, changes: Mapping[str, Any], seed: int, seconds: float
) -> tuple[float, int]:
    """Return what HybridRRTstar's best plan costs after so much CPU time, and its regrasps."""
    problem, started = api.load(scenario, dict(changes)).problem, time.process_time()
    budget = Budget(stop=lambda: time.process_time() - started > seconds, time_limit=math.inf)
    planner, rng = make_planner("HybridRRTstar"), np.random.default_rng(seed)
    found = planner.solve(problem, judge_of(problem), budget, rng)
    regrasps = sum(isinstance(move, Regrasp) for move in found.moves)
    return math.inf if found.cost is None else found.cost, regrasps


def exponents(known: Mapping[str, Sequence[tuple[float, float]]]) -> Iterator[tuple[str, str]]:
    """Yield per series the slope of log CPU time over log sets (least squares)."""
    for series, points in known.items():
        if len(points) > 1:
            x, y = ([math.log(value) for value in values] for values in zip(*points, strict=True))
            slope = statistics.linear_regression(x, y).slope
            yield series, number(slope, 2)


def picture(known: Mapping[str, Mapping[str, Sequence[tuple[float, float]]]]) -> Any:
    """Draw CPU time over sets of placements, a panel per quantity; inside ``styled`` alone."""
    figure = new_figure(2.1 * COLUMN, 0.9 * COLUMN)
    axes = figure.subplots(1, len(known), sharey=True)
    for ax, (name, series) in zip(axes, known.items(), strict=True):
        for k, (label, points) in enumerate(series.items()):
            ax.plot(*zip(*points, strict=True), "osv^D<"[k % 6] + "-", markersize=3, label=label)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel(f"sets of placements, {name}")
        ax.legend(frameon=False, fontsize="small")
    axes[0].set_ylabel("CPU time [s]")
    return figure


def main(arguments: Sequence[str]) -> None:
    """Measure and write the page."""
    page = Path(arguments[0] if arguments else "docs/results/continuous.md")
    grids: dict[str, list[tuple[float, float]]] = {}
    hands: dict[str, list[tuple[float, float]]] = {}
    finer = [(scenario, m, 2) for scenario in GROWING for m in FINER]
    more = [("paper/tumble", 9, n) for n in FINGERS]
    tables = {
        "converging": growing(HEAD, converging(SCENARIOS, GRIDS, GAPS)),
        "sampled": growing(SAMPLED, sampled(ANY_MOTION, DRAWS, SECONDS)),
        "placements": growing(TIMES, against(finer, grids)),
        "fingers": growing(TIMES, against(more, hands)),
        "exponents": growing(("series", "exponent"), exponents(grids)),
    }
    for mark, grown in tables.items():
        for content in grown:
            write_tables(page, {mark: content})
    image = page.parent / "images" / "continuous.svg"
    with styled():
        save(picture({"finer grids": grids, "more fingers": hands}), image)


if __name__ == "__main__":
    main(sys.argv[1:])
