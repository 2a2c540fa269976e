"""A study of parameters as one HTML page that needs no network."""

from __future__ import annotations

import html
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np

from gm_ompl.study.report import plotly
from gm_ompl.study.tuning import Tuned


def tuning_html(tuned: Tuned, measures: tuple[str, ...], title: str) -> str:
    """Return the page: history of the trials, importance of the parameters, and the gains.

    Args:
        tuned: what was found.
        measures: of the objective, in the order of the trials' values.
        title: of the page.

    Raises:
        MissingExtraError: plotly is not installed.
    """
    go = plotly("tune")
    name = html.escape(title)
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{name}</title></head>",
        f"<body style='font: 15px/1.5 system-ui, sans-serif; margin: 2em'><h1>{name}</h1>",
        *(f"<p>{html.escape(line)}</p>" for line in gain_lines(tuned)),
    ]
    library: bool = True
    for figure in _figures(go, tuned, measures):
        parts.append(figure.to_html(full_html=False, include_plotlyjs=library))
        library = False
    return "\n".join([*parts, "</body></html>\n"])


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
