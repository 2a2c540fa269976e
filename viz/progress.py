"""One picture of planners over time: how many runs have a plan, and how good it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from .canvas import COLUMN, new_figure

LINES: Final = ("-", "--", ":")
"""A colour alone does not tell a dozen planners apart for everybody."""


def progress_figure(
    panels: Mapping[str, Mapping[str, Mapping[str, Any]]], end: float, colours: Sequence[str]
) -> Any:
    """Draw a column per scenario: success above, cost below; inside ``styled`` alone.

    Args:
        panels: by scenario and planner "success" (times, shares of the runs) and "ratio" (times,
            median cost over the optimum or None), times in s.
        end: where runs were stopped [s].
        colours: of the planners, taken again from the first where there are too few.
    """
    figure = new_figure(2.1 * COLUMN, 1.35 * COLUMN)
    axes = figure.subplots(2, len(panels), sharex=True, sharey="row", squeeze=False)
    for column, (scenario, planners) in enumerate(panels.items()):
        above, below = axes[0][column], axes[1][column]
        above.set_title(scenario)
        for number, (name, curve) in enumerate(planners.items()):
            style = {
                "color": colours[number % len(colours)],
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
