"""``python -m docs.tables.planners``: every planner over time, for docs/results/planners.md.

Makes the runs of all planners on the paper's problems, writes their table into the page and draws
success and cost over time beside it (images/planners.svg). Runs are those of ``comparison``,
kept in the same store: what one has made the other takes from it. Half an hour on two cores.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from gm_ompl.viz.canvas import COLUMN, new_figure, save, styled

from docs.tables.comparison import Comparison, produce
from docs.tables.pages import write_tables
from gm_ompl.planners.registry import PLANNERS
from gm_ompl.study.report import COLOURS, TIMES, cost_quantiles, figure, success_curve, table
from gm_ompl.study.store import RunRecord
from gm_ompl.study.summary import first_times, grouped, ratios

DESIGN = Comparison(
    single=("paper/slide", "paper/push", "paper/tumble", "paper/regrasp"),
    families=(),
    planners=tuple(name for name in PLANNERS if name != "dijkstra"),
)
PICTURE = Path("images/planners.svg")  # beside the page
LINES = ("-", "--", ":")  # a colour alone does not tell a dozen planners apart for everybody
EARLIEST_S = 0.01  # where the curves' axis of time begins [s]


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


Panels: TypeAlias = dict[str, dict[str, dict[str, Any]]]
"""By scenario and planner "success" (times, shares of the runs) and "ratio" (times, median cost
over the optimum; None while half the runs have no plan), times in s."""


def curves(shown: Sequence[RunRecord], best: Mapping[str, float], end: float) -> Panels:
    """Return what is drawn, up to time ``end`` [s]."""
    times = np.geomspace(EARLIEST_S, end, TIMES)
    panels: Panels = {}
    for scenario, planners in grouped(shown).items():
        panels[scenario] = {}
        for planner, runs in planners.items():
            optimum = best.get(runs[0].scenario_key)
            costs = cost_quantiles(runs, times)[1]
            ratio = [None if optimum is None or c is None else c / optimum for c in costs]
            panels[scenario][planner] = {
                "success": success_curve(runs, end), "ratio": (times.tolist(), ratio)
            }  # fmt: skip
    return panels


def draw(panels: Panels, end: float, picture: Path) -> None:
    """Write the picture of what ``curves`` returns."""
    picture.parent.mkdir(exist_ok=True)
    with styled():
        save(_figure(panels, end), picture)


def _figure(panels: Panels, end: float) -> Any:
    """Draw a column per scenario: success above, cost below."""
    figure = new_figure(2.1 * COLUMN, 1.35 * COLUMN)
    axes = figure.subplots(2, len(panels), sharex=True, sharey="row", squeeze=False)
    for column, (scenario, planners) in enumerate(panels.items()):
        above, below = axes[0][column], axes[1][column]
        above.set_title(scenario)
        for number, (name, curve) in enumerate(planners.items()):
            style = {
                "color": COLOURS[number % len(COLOURS)],
                "linestyle": LINES[number % len(LINES)],
                "drawstyle": "steps-post",
            }
            above.plot(*curve["success"], label=name, **style)
            times, ratios = curve["ratio"]
            below.plot(times, [float("nan") if r is None else r for r in ratios], **style)
        below.axhline(1.0, color="0.6", linewidth=0.6)
        below.set_xscale("log")
        below.set_yscale("log")
        below.set_xlabel("time [s]")
        below.set_xlim(right=end)
    axes[0][0].set_ylabel("share of runs with a plan")
    axes[1][0].set_ylabel("cost over the lattice's optimum (median)")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6, frameon=False)
    return figure


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
