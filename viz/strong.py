"""Both stability margins along a plan, as a figure."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from gm_ompl.tolerance.strong import StrongReport

from . import palette
from .animation import Animation
from .canvas import COLUMN, new_figure, title


def strong_figure(animation: Animation, report: StrongReport) -> Any:
    """Return the figure of z and z_strong over the plan's segments and rests."""
    figure = new_figure(COLUMN, 1.8)
    ax = figure.subplots()
    figure.suptitle(title(animation.name, 48), fontsize=8, parse_math=False)
    counts = Counter(site.step for site in report.sites)
    inner = [step + k / count for step, count in counts.items() for k in range(count)]
    edges = np.array([*inner, report.sites[-1].step + 1.0])
    z, held = ([getattr(site, name) for site in report.sites] for name in ("z", "z_strong"))
    color = palette.css(palette.MARGIN)
    ax.stairs(z, edges, color=color, label="z")
    ax.stairs(held, edges, fill=True, alpha=0.4, color=color, label="z_strong")
    ax.set_xlabel("step")
    ax.set_ylabel("margin")
    ax.set_ylim(bottom=0.0)
    ax.legend(fontsize=6)
    return figure
