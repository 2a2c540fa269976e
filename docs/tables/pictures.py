"""Pictures of the pages in ``docs/``: how planning time grows, and planners over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from gm_ompl.viz.canvas import COLUMN, new_figure

LATTICE: Final = "#1f77b4"
SAMPLING: Final = "#d62728"

LINES: Final = ("-", "--", ":")
"""A colour alone does not tell a dozen planners apart for everybody."""


def scaling_figure(panels: Mapping[str, Sequence[Mapping[str, Any]]], limit: float) -> Any:
    """Draw one panel per quantity that was varied; inside ``styled`` alone.

    Args:
        panels: by the varied quantity's name, its measurements. Each has "series" (a name), "x",
            "lattice" [s], "proven" (whether the search ended), "sampling" [s] or None, "lo", "hi"
            (the fastest and slowest run).
        limit: where searches were stopped [s]; drawn as a line.
    """
    figure = new_figure(2.1 * COLUMN, 0.85 * COLUMN)
    axes = figure.subplots(1, len(panels), sharey=True)
    for ax, (name, rows) in zip(axes, panels.items(), strict=True):
        names = list(dict.fromkeys(row["series"] for row in rows))
        for series, line in zip(names, ("-", "--", ":", "-.")[: len(names)], strict=True):
            own = [row for row in rows if row["series"] == series]
            _lattice(ax, own, line)
            _sampling(ax, own, line)
            ax.plot([], [], line, color="0.3", label=series)
        ax.axhline(limit, color="0.6", linewidth=0.6)
        ax.set_xscale("linear" if name == "fingers" else "log")
        ax.set_yscale("log")
        ax.set_xlabel(name)
        ax.legend(frameon=False, loc="best", handlelength=2.2)
    axes[0].set_ylabel("CPU time [s]")
    figure.legend(
        handles=[
            axes[0].plot([], [], "o-", color=LATTICE, markersize=3.5, label="astar")[0],
            axes[0].plot(
                [], [], "o", color=LATTICE, markerfacecolor="white", markersize=3.5,
                label="astar, not ended within its limit",
            )[0],
            axes[0].plot(
                [], [], "s-", color=SAMPLING, markersize=2.5, label="HybridRRTConnect, first plan"
            )[0],
        ],
        loc="outside lower center", ncols=3, frameon=False,
    )  # fmt: skip
    return figure


def _lattice(ax: Any, rows: Sequence[Mapping[str, Any]], line: str) -> None:
    x, y = [row["x"] for row in rows], [row["lattice"] for row in rows]
    ax.plot(x, y, line, color=LATTICE)
    for row in rows:
        face = LATTICE if row["proven"] else "white"
        ax.plot(row["x"], row["lattice"], "o", color=LATTICE, markerfacecolor=face, markersize=3.5)


def _sampling(ax: Any, rows: Sequence[Mapping[str, Any]], line: str) -> None:
    known = [row for row in rows if row["sampling"] is not None]
    x, y = [row["x"] for row in known], [row["sampling"] for row in known]
    below = [row["sampling"] - row["lo"] for row in known]
    above = [row["hi"] - row["sampling"] for row in known]
    ax.errorbar(
        x, y, yerr=(below, above), fmt=line, marker="s", markersize=2.5, color=SAMPLING,
        elinewidth=0.6, capsize=1.5,
    )  # fmt: skip


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
