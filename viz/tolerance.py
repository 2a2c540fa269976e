"""What a plan tolerates, step by step, as a figure."""

from __future__ import annotations

from typing import Any

import numpy as np

from gm_ompl.tolerance.quantities import Quantity
from gm_ompl.tolerance.report import IntervalEnd, Tolerance

from . import palette
from .animation import Animation
from .canvas import COLUMN, new_figure, title


def tolerance_figure(animation: Animation, tolerance: Tolerance) -> Any:
    """Return the figure of the intervals and of the common factor along a plan's steps.

    A quantity that is tolerated as far as one has looked, in every step, has no plot.
    """
    steps = tolerance.steps
    shown = [
        k
        for k, interval in enumerate(tolerance.intervals)
        if any(end.ending is not IntervalEnd.LIMIT for end in (interval.low, interval.high))
    ]
    rows = len(shown) + (tolerance.together is not None)
    figure = new_figure(COLUMN, 0.7 + 0.75 * max(rows, 1))
    axes = figure.subplots(max(rows, 1), 1, sharex=True, squeeze=False)[:, 0]
    figure.suptitle(title(animation.name, 48), fontsize=8, parse_math=False)
    at = np.arange(len(steps) + 1) - 0.5
    for ax, k in zip(axes, shown, strict=False):
        quantity = tolerance.intervals[k].quantity
        scale, unit = _unit(quantity)
        low, high = (
            np.array([scale * getattr(step.intervals[k], side).x for step in steps])
            for side in ("low", "high")
        )
        ax.stairs(high, at, baseline=low, fill=True, color=palette.css(palette.MARGIN), alpha=0.4)
        ax.axhline(0.0, color="0.3", linewidth=0.7)
        ax.set_ylabel(
            f"{quantity.label}{unit}".replace("_", " "), fontsize=5, rotation=0, ha="right"
        )
    if tolerance.together is not None:
        ax = axes[-1]
        factors = [step.together.x if step.together is not None else 0.0 for step in steps]
        ax.stairs(factors, at, color=palette.css(palette.MARGIN))
        ax.axhline(1.0, color="#b00000", linewidth=0.8, linestyle="--")
        ax.set_ylim(bottom=0.0)
        ax.set_ylabel("all ranges,\ntimes", fontsize=5, rotation=0, ha="right")
    axes[-1].set_xlabel("step")
    return figure


def _unit(quantity: Quantity) -> tuple[float, str]:
    """Return a factor for the numbers of a plot, and their unit."""
    if quantity.name == "tilt":
        return 1.0, "\n[tangent]"
    if quantity.nominal:
        return 100.0 / quantity.nominal, "\n[%]"
    return 1.0, ""
