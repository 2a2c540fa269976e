"""Comparisons and tunings as HTML pages that need no network: the only import of plotly."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
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
from gm_ompl.study.tuning import Tuned

COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933",
    "#882255", "#44aa99",
)  # fmt: skip
"""Told apart by readers with any kind of colour vision."""

TIMES = 200
"""Points in time at which curves of cost are drawn."""

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 1em 0 } caption { text-align: left; font-weight: bold }
th, td { padding: .2em .7em; border-bottom: 1px solid #ccc; text-align: right }
th:nth-child(-n+2), td:nth-child(-n+2) { text-align: left }
"""


def report_html(records: Sequence[RunRecord], optima: Mapping[str, float]) -> str:
    """Return the page.

    Args:
        records: the runs.
        optima: proven optimal costs by scenario key.

    Raises:
        MissingExtraError: plotly is not installed.
    """
    go = plotly()
    parts: list[Any] = [
        _summary_table(summarise(records, optima)),
        _difference_table(differences(records, optima)),
    ]
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


def _summary_table(rows: Sequence[Summary]) -> str:
    head = ("scenario", "planner", "runs", "with a plan", "first plan [s], median", "cost, median",
            "cost / optimum", "regrasps", "least z", "mode decisions", "peak [MiB]",
            "other ends")  # fmt: skip
    return _table("Runs", head, [(row.scenario, row.planner, *figures(row)) for row in rows])


def figures(row: Summary) -> tuple[str, ...]:
    """Return a summary's figures as text, from the number of runs to how else they ended."""
    numbers = (row.first_plan_s, row.cost, row.ratio, row.regrasps, row.least_z, row.decisions)
    others = ", ".join(f"{count} {status}" for status, count in row.others.items())
    success, peak = f"{row.success:.0%}", f"{row.peak_mb:.0f}"
    return (str(row.runs), success, *map(figure, numbers), peak, others or "-")


def _difference_table(rows: Sequence[Difference]) -> str:
    head = ("scenario", "planner", "against", "figure", "difference", "95% interval")
    cells = [
        (row.scenario, row.planner, row.against, row.what, figure(row.value), interval(row))
        for row in rows
    ]
    return _table("Differences from the first planner (bootstrap intervals)", head, cells)


def _table(caption: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    def line(tag: str, cells: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "\n".join(line("td", row) for row in rows)
    return f"<table><caption>{html.escape(caption)}</caption>\n{line('th', head)}\n{body}</table>"


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


def interval(difference: Difference) -> str:
    """Return the interval of a difference; marked where it leaves out zero."""
    if difference.low is None and difference.high is None:
        return "-"
    mark = " *" if difference.supported else ""
    return f"{figure(difference.low)} to {figure(difference.high)}{mark}"


def tuning_html(tuned: Tuned, measures: tuple[str, ...], title: str) -> str:
    """Return the page: history of the trials, importance of the parameters, and the gains.

    Args:
        tuned: what was found.
        measures: of the objective, in the order of the trials' values.
        title: of the page.

    Raises:
        MissingExtraError: plotly is not installed.
    """
    lines = [f"<p>{html.escape(line)}</p>" for line in gain_lines(tuned)]
    return _page(title, [*lines, *_figures(plotly("tune"), tuned, measures)])


def gain_lines(tuned: Tuned) -> Iterator[str]:
    """Yield what the winner gains on the held-out scenarios, a line per measure."""
    for name, gain in tuned.gains.items():
        verdict = "better" if gain.supported else "worse" if gain.high < 1.0 else "not told apart"
        yield (
            f"held out, {name}: {gain.factor:.3g} times less than with the defaults "
            f"(95% interval {gain.low:.3g} to {gain.high:.3g}: {verdict}); "
            f"with a plan {gain.solved[0]:.0%} before, {gain.solved[1]:.0%} tuned"
        )


def _figures(go: ModuleType, tuned: Tuned, measures: tuple[str, ...]) -> Iterator[Any]:
    values = np.array([trial.values for trial in tuned.trials])
    texts = [html.escape(str(trial.parameters)) for trial in tuned.trials]
    for column, measure in enumerate(measures):
        history = go.Figure()
        history.add_scatter(y=values[:, column].tolist(), mode="markers", name="trial", text=texts)
        best = np.minimum.accumulate(values[:, column]).tolist()
        history.add_scatter(y=best, mode="lines", name="best so far")
        history.update_layout(title=f"History: {measure} (geometric mean), trial 0 has the "
                              "defaults", xaxis_title="trial", yaxis_title=measure)  # fmt: skip
        yield history
    if len(measures) == 2:
        front = go.Figure()
        front.add_scatter(x=values[:, 0].tolist(), y=values[:, 1].tolist(), mode="markers",
                          name="trial", text=texts)  # fmt: skip
        chosen = values[list(tuned.front)]
        front.add_scatter(x=chosen[:, 0].tolist(), y=chosen[:, 1].tolist(), mode="markers",
                          name="beaten by none")  # fmt: skip
        front.update_layout(title="Both measures", xaxis_title=measures[0],
                            yaxis_title=measures[1])  # fmt: skip
        yield front
    shares = tuned.importances
    bars = go.Figure(go.Bar(x=list(shares.values()), y=list(shares), orientation="h"))
    bars.update_layout(title=f"Importance: share of the differences in {measures[0]} that each "
                       "parameter explains alone", xaxis_range=[0, 1])  # fmt: skip
    yield bars
