"""Pictures of a search: bound and cost over time, and what it expanded or grew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from gm_ompl.errors import InputError
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.planners.trace_file import Told

from .animation import Animation
from .canvas import COLUMN, new_figure, title

MARKERS: Final = ("o", "x", "^", "s", "+", "v", "d", "*")
"""One per reason of an expansion; reasons beyond the last share it."""


def search_figure(animation: Animation, trace: Told | None) -> Any:
    """Return the figure of the search that found ``animation.plan``.

    Args:
        animation: the plan.
        trace: of the same search; without one, bound and cost come from the plan's statistics.

    Raises:
        InputError: neither knows anything of the search.
    """
    told = trace or Told({"planner": animation.plan.planner}, ())
    history = told.history or animation.plan.statistics.history
    extra = bool(told.expansions) + bool(told.vertices)
    if not history and not extra:
        raise InputError("the plan keeps no history of its search; plan it again with --trace FILE")
    figure = new_figure(COLUMN, 0.4 + 1.7 + 2.3 * extra)
    axes = list(
        figure.subplots(1 + extra, 1, squeeze=False, height_ratios=[1.6] + [2.2] * extra)[:, 0]
    )
    name = f"{animation.name} \u2013 {told.header.get('planner', animation.plan.planner)}"
    figure.suptitle(title(name, 48), fontsize=8, parse_math=False)
    _bounds(axes.pop(0), history)
    if told.expansions:
        _expansions(axes.pop(0), animation, told)
    if told.vertices:
        _tree(axes.pop(0), animation, told.vertices)
    return figure


def _bounds(ax: Any, history: tuple[tuple[float, float | None, float | None], ...]) -> None:
    """Draw the best cost and the lower bound over time."""
    looks = ((1, "best cost", "#d55e00", "-"), (2, "lower bound", "#0072b2", "--"))
    end = max((row[0] for row in history), default=0.0)
    for column, label, colour, line in looks:
        points = [(row[0], row[column]) for row in history if row[column] is not None]
        if points:
            x, y = zip(*points, strict=True)
            ax.step([*x, end], [*y, y[-1]], where="post", color=colour, linestyle=line, label=label)
            if column == 1:  # a first plan that ends the search would be a line of no length
                ax.scatter(x[:1], y[:1], s=9.0, color=colour, clip_on=False)
    ax.set_xlim(0.0, 1.02 * end or 1.0)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("cost")
    if ax.lines:
        ax.legend(frameon=False)


def _expansions(ax: Any, animation: Animation, trace: Told) -> None:
    """Draw what was expanded: where, at which bound, when (shade) and why (marker)."""
    rows = trace.expansions
    q = np.array([row["q"][0] for row in rows])
    keys = np.array([np.nan if row["bound"] is None else row["bound"] for row in rows], float)
    reasons = list(dict.fromkeys(str(row["why"]) for row in rows))
    order = np.linspace(0.0, 1.0, len(rows))
    for k, why in enumerate(reasons):
        chosen = np.array([row["why"] == why for row in rows])
        ax.scatter(
            q[chosen], keys[chosen], c=order[chosen], vmin=0.0, vmax=1.0, cmap="viridis_r", s=7,
            marker=MARKERS[min(k, len(MARKERS) - 1)], linewidths=0.6, label=title(why, 24),
            rasterized=len(rows) > 5000,
        )  # fmt: skip
    cost = animation.plan.cost
    if cost is not None:
        ax.axhline(cost, color="0.3", linewidth=0.7, linestyle=":", label="cost of plan")
    ax.set_xlabel(f"{animation.problem.motion.names[0]} (light: early, dark: late)")
    ax.set_ylabel("bound when expanded")
    for handle in _legend_above(ax).legend_handles:
        if hasattr(handle, "set_array"):  # the reasons differ by marker, not by shade
            handle.set_array(None)
            handle.set_color("0.2")


class _Sets:
    """Numbers sets of placements as they are met; interchangeable fingers are not told apart."""

    def __init__(self, animation: Animation) -> None:
        self._hand = animation.problem.fingers
        self._canonical = PlacementSets(self._hand.groups()).canonical
        self._rows: dict[tuple[int, ...], int] = {}

    def row(self, placements: tuple[int, ...]) -> float:
        """Return the number of a set given as rows of the placement table."""
        known = self._canonical(placements) if len(placements) == self._hand.count else placements
        return float(self._rows.setdefault(known, len(self._rows)))

    def row_of(self, places: Sequence[Any]) -> float:
        """Return the number of a set as a plan's step names it."""
        rows = (place.row(self._hand.placements) for place in places)
        return self.row(tuple(-1 if row is None else row for row in rows))


def _tree(ax: Any, animation: Animation, vertices: Mapping[int, Mapping[str, Any]]) -> None:
    """Draw the trees over the object's coordinates: x and y, or s and sets of placements."""
    flat = len(animation.problem.motion.names) > 1
    sets = _Sets(animation)
    place = {
        number: (row["q"][0], row["q"][1] if flat else sets.row(row["placements"]))
        for number, row in vertices.items()
    }
    _edges(ax, vertices, place)
    points = np.array(list(place.values()))
    ax.scatter(points[:, 0], points[:, 1], s=1.0, color="0.2", rasterized=len(points) > 5000)
    regrasps = [place[n] for n, row in vertices.items() if row["kind"] == "regrasp"]
    if regrasps:  # where the object rests, such an edge has no length to be seen
        ax.scatter(
            *zip(*regrasps, strict=True), s=9.0, facecolors="none", edgecolors="#d55e00",
            linewidths=0.6, label="after a regrasp",
        )  # fmt: skip
    steps = [step for step in animation.plan.steps if step.kind == "displacement"]
    if steps:
        ends = [(q, step.placements) for step in steps for q in (step.from_, step.to)]
        way = np.array([(q[0], q[1] if flat else sets.row_of(places)) for q, places in ends])
        ax.plot(way[:, 0], way[:, 1], color="0.75", linewidth=3.0, zorder=0.5, label="plan")
    names = animation.problem.motion.names
    ax.set_xlabel(names[0])
    ax.set_ylabel(names[1] if flat else "set of placements, as met")
    if not flat:
        ax.yaxis.get_major_locator().set_params(integer=True)
    ax.autoscale_view()
    _legend_above(ax)


def _edges(
    ax: Any, vertices: Mapping[int, Mapping[str, Any]], place: Mapping[int, tuple[float, float]]
) -> None:
    """Draw the trees' edges, by kind and tree."""
    from matplotlib.collections import LineCollection

    looks = {
        ("displacement", "start"): ("#0072b2", "-"), ("regrasp", "start"): ("#d55e00", ":"),
        ("displacement", "goal"): ("#009e73", "-"), ("regrasp", "goal"): ("#cc79a7", ":"),
    }  # fmt: skip
    for (kind, tree), (colour, line) in looks.items():
        lines = [
            (place[row["parent"]], place[number])
            for number, row in vertices.items()
            if row["parent"] in place and (row["kind"], row["tree"]) == (kind, tree)
        ]
        if lines:
            label = kind if tree == "start" else f"{kind}, goal's tree"
            look: dict[str, Any] = {
                "colors": colour,
                "linestyles": line,
                "linewidths": 0.5,
                "label": label,
            }
            ax.add_collection(LineCollection(lines, **look))


def _legend_above(ax: Any) -> Any:
    """Put the legend where no data can be; return it."""
    return ax.legend(
        loc="lower left", bbox_to_anchor=(-0.1, 1.0), ncols=2, frameon=False, columnspacing=1.0
    )
