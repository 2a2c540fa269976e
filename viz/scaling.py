"""One picture of how planning time grows: the lattice's search beside sampling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from .canvas import COLUMN, new_figure

LATTICE: Final = "#1f77b4"
SAMPLING: Final = "#d62728"


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
