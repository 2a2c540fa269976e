"""``python -m docs.tables.planners``: every planner over time, for docs/planners.md.

Makes the runs of all planners on the paper's problems, writes their table into the page and draws
success and cost over time beside it (images/planners.svg). Runs are those of ``comparison``,
kept in the same store: what one has made the other takes from it. Half an hour on two cores.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gm_ompl.viz.canvas import save, styled

from docs.tables.comparison import Comparison, produce
from docs.tables.pages import write_tables
from docs.tables.pictures import progress_figure
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.study.report import COLOURS, TIMES, cost_quantiles, figure, success_curve, table
from gm_ompl.study.store import RunRecord
from gm_ompl.study.summary import first_times, grouped, ratios

DESIGN = Comparison(
    single=("paper/slide", "paper/push", "paper/tumble", "paper/regrasp"),
    families=(),
    planners=tuple(name for name in PLANNERS if name != "dijkstra"),
)
PICTURE = Path("images/planners.svg")
"""Beside the page."""
EARLIEST_S = 0.01
"""Where the curves' axis of time begins [s]."""


def rates(shown: Sequence[RunRecord], best: Mapping[str, float]) -> str:
    """Return the table: success, time to the first plan, cost and regrasps at the end."""
    lines = []
    for scenario, planners in grouped(shown).items():
        for planner, runs in planners.items():
            times, costs = first_times(runs), ratios(runs, best)
            solved = [run for run in runs if run.regrasps is not None]
            half = np.sort(times)[len(times) // 2]
            lines.append((
                scenario, planner, f"{len(solved)} of {len(runs)}",
                figure(float(half) if np.isfinite(half) else None),
                figure(float(times[np.isfinite(times)].max()) if solved else None),
                figure(float(np.median(costs)) if costs.size else None),
                figure(float(costs.max()) if costs.size else None),
                figure(float(np.mean([run.regrasps for run in solved])) if solved else None),
            ))  # fmt: skip
    head = ("scenario", "planner", "with a plan", "first plan, median s", "worst s",
            "cost / optimum, median", "worst", "regrasps, mean")  # fmt: skip
    return table(head, lines)


def curves(
    shown: Sequence[RunRecord], best: Mapping[str, float], end: float
) -> dict[str, dict[str, dict[str, Any]]]:
    """Return by scenario and planner what ``progress_figure`` draws, up to time ``end`` [s]."""
    times = np.geomspace(EARLIEST_S, end, TIMES)
    return {
        scenario: {
            planner: {
                "success": success_curve(runs, end),
                "ratio": (times.tolist(), _over_optimum(runs, best, times)),
            }
            for planner, runs in planners.items()
        }
        for scenario, planners in grouped(shown).items()
    }


def _over_optimum(
    runs: Sequence[RunRecord],
    best: Mapping[str, float],
    times: np.ndarray[Any, np.dtype[np.float64]],
) -> list[float | None]:
    """Return the median cost so far over the optimum; None while half the runs have no plan."""
    optimum = best.get(runs[0].scenario_key)
    median = cost_quantiles(runs, times)[1]
    return [None if optimum is None or cost is None else cost / optimum for cost in median]


def draw(panels: Mapping[str, Mapping[str, Mapping[str, Any]]], end: float, picture: Path) -> None:
    """Write the picture of what ``curves`` returns."""
    picture.parent.mkdir(exist_ok=True)
    with styled():
        save(progress_figure(panels, end, COLOURS), picture)


def write(
    design: Comparison, page: Path, shown: Sequence[RunRecord], best: Mapping[str, float]
) -> None:
    """Write the table into the page, and the picture beside it."""
    write_tables(page, {"rates": rates(shown, best)})
    draw(curves(shown, best, design.time_limit), design.time_limit, page.parent / PICTURE)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make what is missing, write the table, draw the picture."""
    return produce("planners", DESIGN, arguments, write)


if __name__ == "__main__":
    sys.exit(main())
