"""Comparisons and tunings as HTML pages that need no network: the only import of plotly."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from gm_ompl.errors import MissingExtraError
from gm_ompl.study.store import RunRecord
from gm_ompl.study.summary import (
    Difference,
    Samples,
    Summary,
    differences,
    first_times,
    grouped,
    ratios,
    summarise,
)
from gm_ompl.study.tuning import Tuned, charts

COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933",
    "#882255", "#44aa99",
)  # fmt: skip
"""Told apart by readers with any kind of colour vision."""

TIMES = 200  # points in time at which curves of cost are drawn

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 1em 0 } caption { text-align: left; font-weight: bold }
th, td { padding: .2em .7em; border-bottom: 1px solid #ccc; text-align: right }
th:nth-child(-n+2), td:nth-child(-n+2) { text-align: left }
"""


def report_html(records: Sequence[RunRecord], optima: Mapping[str, float]) -> str:
    """Return the page of the runs; ``optima`` are proven optimal costs by scenario key.

    Raises:
        MissingExtraError: plotly is not installed.
    """
    go = plotly()
    parts: list[Any] = [part.html() for part in tables(records, optima)]
    for scenario, planners in grouped(records).items():
        parts += [f"<h2>{html.escape(scenario)}</h2>", *_charts(go, planners, optima)]
    return _page("Comparison of planners", [*parts, *_scaling(go, records)])


def _page(title: str, parts: Iterable[Any]) -> str:
    """Return a page of HTML and charts; it holds plotly once, before its first chart."""
    library, body = True, []
    for part in parts:
        if not isinstance(part, str):
            part, library = part.to_html(full_html=False, include_plotlyjs=library), False
        body.append(part)
    name = html.escape(title)
    head = f"<head><meta charset='utf-8'><title>{name}</title><style>{_STYLE}</style></head>"
    top = f"<!doctype html><html lang='en'>{head}<body><h1>{name}</h1>"
    return "\n".join([top, *body, "</body></html>\n"])


def plotly(extra: str = "plot") -> ModuleType:
    """Return plotly's module of charts.

    Raises:
        MissingExtraError: it is not installed; the message names the ``extra``.
    """
    try:
        import plotly.graph_objects as go
    except ImportError:
        raise MissingExtraError("plotly", extra) from None
    module: ModuleType = go
    return module


def _charts(
    go: ModuleType, planners: Mapping[str, Sequence[RunRecord]], optima: Mapping[str, float]
) -> Iterator[Any]:
    """Yield a scenario's charts: success over time, cost over time, cost ratio."""
    success, cost, ratio = (go.Figure() for _ in range(3))
    end = max((t for runs in planners.values() for run in runs for t, _, _ in run.history),
              default=1.0) or 1.0  # fmt: skip
    for index, (planner, runs) in enumerate(planners.items()):
        name, colour = html.escape(planner), COLOURS[index % len(COLOURS)]
        line = {"color": colour, "shape": "hv"}
        times, share = success_curve(runs, end)
        success.add_scatter(x=times, y=share, name=name, mode="lines", line=line)
        grid = np.geomspace(end / 1000.0, end, TIMES)
        low, middle, high = cost_quantiles(runs, grid)
        shared = {"x": grid.tolist(), "legendgroup": name, "mode": "lines"}
        thin = {"color": colour, "shape": "hv", "width": 0.5, "dash": "dot"}
        for values in (low, high):
            cost.add_scatter(y=values, name=name, showlegend=False, line=thin, **shared)
        cost.add_scatter(y=middle, name=name, line=line, **shared)
        ratio.add_box(y=ratios(runs, optima).tolist(), name=name, marker_color=colour)
    cost.update_xaxes(type="log")
    for figure, title, x, y in (
        (success, "Share of runs with a plan", "time [s]", "share"),
        (cost, "Cost of the best plan: median and quartiles of the runs", "time [s]", "cost"),
        (ratio, "Cost over the optimum proven on the lattice", "", "ratio"),
    ):
        figure.update_layout(title=title, xaxis_title=x, yaxis_title=y, height=380)
        yield figure


def _scaling(go: ModuleType, records: Sequence[RunRecord]) -> Iterator[Any]:
    """Yield, where sizes differ, charts of what first plans took over the lattice's states."""
    solved = [run for run in records if run.solved and run.states is not None]
    if len({run.states for run in solved}) < 2:
        return
    for what, title in (
        ("first_plan_s", "time to the first plan [s]"),
        ("first_plan_decisions", "mode decisions to the first plan"),
    ):
        figure = go.Figure()
        for index, planner in enumerate(dict.fromkeys(run.planner for run in records)):
            runs = [run for run in solved if run.planner == planner]
            figure.add_scatter(
                x=[run.states for run in runs],
                y=[getattr(run, what) for run in runs],
                text=[html.escape(run.scenario) for run in runs],
                name=html.escape(planner),
                mode="markers",
                marker={"color": COLOURS[index % len(COLOURS)], "size": 5},
            )
        figure.update_xaxes(type="log", title="states of the lattice")
        figure.update_yaxes(type="log", title=title)
        figure.update_layout(title=f"Scaling: {title}, a point per run with a plan", height=480)
        yield figure


def success_curve(runs: Sequence[RunRecord], end: float) -> tuple[list[float], list[float]]:
    """Return the steps of the share of runs that have a plan, from time 0 to ``end``."""
    found = np.sort(first_times(runs))
    found = found[np.isfinite(found)]
    share = [(k + 1) / len(runs) for k in range(found.size)]
    last = share[-1] if share else 0.0
    return [0.0, *found.tolist(), max(end, found.max(initial=0.0))], [0.0, *share, last]


def cost_quantiles(
    runs: Sequence[RunRecord], times: Samples
) -> tuple[list[float | None], list[float | None], list[float | None]]:
    """Return the quartiles of the best cost so far over all runs; None where it is infinite.

    Runs without a plan count as infinitely costly, so that a planner gains nothing by solving
    the easy runs alone.
    """
    costs = np.full((len(runs), len(times)), math.inf)
    for row, run in zip(costs, runs, strict=True):
        for time, cost, _ in run.history:
            if cost is not None:
                row[times >= time] = cost
    quartiles = np.quantile(costs, (0.25, 0.5, 0.75), axis=0, method="higher")
    low, middle, high = (
        [value if math.isfinite(value) else None for value in row] for row in quartiles.tolist()
    )
    return low, middle, high


@dataclass(frozen=True)
class Table:
    """What a comparison says in rows: for terminals, pages and the documentation."""

    title: str  # what it shows
    head: tuple[str, ...]  # names of the columns; the first two say which runs a row is about
    rows: tuple[tuple[str, ...], ...]  # text

    def html(self) -> str:
        """Return the table as HTML."""
        lines = [
            "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
            for tag, cells in (("th", self.head), *(("td", row) for row in self.rows))
        ]
        body = "\n".join(f"<tr>{line}</tr>" for line in lines)
        return f"<table><caption>{html.escape(self.title)}</caption>\n{body}</table>"


def tables(records: Sequence[RunRecord], optima: Mapping[str, float]) -> tuple[Table, Table]:
    """Return the summaries, and how planners differ from the first one, a column per figure."""
    head: tuple[str, ...] = ("scenario", "planner", "runs", "with a plan", "first plan [s]", "cost",
            "cost / optimum", "regrasps", "least z", "decisions", "peak [MiB]",
            "other ends")  # fmt: skip
    summaries = summarise(records, optima)
    rows: tuple[tuple[str, ...], ...] = tuple(
        (row.scenario, row.planner, *figures(row)) for row in summaries
    )
    if any(row.tolerance is not None for row in summaries):
        head = (*head, "tolerance")
        rows = tuple(
            (*row, figure(summary.tolerance)) for row, summary in zip(rows, summaries, strict=True)
        )
    lines: dict[tuple[str, str], list[str]] = {}
    heads: dict[str, None] = {}
    for row in differences(records, optima):
        lines.setdefault((row.scenario, row.planner), []).append(_difference(row))
        heads[f"{row.what}, minus {row.against}'s"] = None
    return Table("Runs: medians", head, rows), Table(
        "Differences, with 95% intervals (* leaves out 0)", ("scenario", "planner", *heads),
        tuple((*names, *cells) for names, cells in lines.items()),
    )  # fmt: skip


def figures(row: Summary) -> tuple[str, ...]:
    """Return a summary's figures as text, from the number of runs to how else they ended."""
    numbers = (row.first_plan_s, row.cost, row.ratio, row.regrasps, row.least_z, row.decisions)
    others = ", ".join(f"{count} {status}" for status, count in row.others.items()) or "-"
    return (
        f"{row.runs}",
        f"{row.success:.0%}",
        *map(figure, numbers),
        f"{row.peak_mb:.0f}",
        others,
    )


def _difference(row: Difference) -> str:
    """Return a difference and its interval, marked where that leaves out zero."""
    if row.value is None and row.low is None and row.high is None:
        return "-"
    if row.low is None and row.high is None:
        return f"{figure(row.value)} (-)"
    mark = " *" if row.supported else ""
    return f"{figure(row.value)} ({figure(row.low)} to {figure(row.high)}{mark})"


def figure(value: float | None) -> str:
    """Return a number with few digits; a dash for none."""
    return "-" if value is None else f"{value:.4g}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with few digits and thousands separated; a dash for None."""
    if value is None:
        return "-"
    if isinstance(value, int) or abs(value) >= 10**digits:
        return f"{value:,.0f}"
    return f"{value:.{digits}g}"


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [list(head), ["---"] * len(head), *[[str(cell) for cell in row] for row in rows]]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def tuning_html(tuned: Tuned, measures: tuple[str, ...], title: str) -> str:
    """Return the page: history of the trials, importance of the parameters, and the gains.

    Raises:
        MissingExtraError: plotly is not installed.
    """
    lines = [f"<p>{html.escape(line)}</p>" for line in gain_lines(tuned)]
    shares = tuned.importances
    bars = plotly("tune").Figure()
    bars.add_bar(x=list(shares.values()), y=list(shares), orientation="h")
    what = f"Importance: share of the differences in {measures[0]} that each explains alone"
    bars.update_layout(title=what, xaxis_range=[0, 1])
    return _page(title, [*lines, *charts(tuned.study, measures), bars])


def gain_lines(tuned: Tuned) -> Iterator[str]:
    """Yield what the winner gains on the held-out scenarios, a line per measure."""
    for name, gain in tuned.gains.items():
        verdict = "better" if gain.supported else "worse" if gain.high < 1.0 else "not told apart"
        yield (
            f"held out, {name}: {gain.factor:.3g} times less than with the defaults "
            f"(95% interval {gain.low:.3g} to {gain.high:.3g}: {verdict}); "
            f"with a plan {gain.solved[0]:.0%} before, {gain.solved[1]:.0%} tuned"
        )
