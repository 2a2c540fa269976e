"""``python -m docs.tables.scaling [PAGE]``: where exactness ends and what sampling costs beyond.

Measures ``astar`` and ``HybridRRTConnect`` against degrees of freedom (nodes of the object's
lattice), placements and fingers; writes the tables into PAGE (its own) and the picture
beside it (images/scaling.svg). Takes about ten minutes on one core.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gm_ompl.viz.canvas import COLUMN, new_figure, save, styled

from docs.tables.measure import measured
from docs.tables.pages import write_tables
from gm_ompl import api
from gm_ompl.study.report import number, table

LIMIT = 30.0  # wall time per search and per run [s]

SEEDS = 10
SAMPLER = "HybridRRTConnect"


@dataclass(frozen=True)
class Growing:
    """One scenario on an axis."""

    series: str  # what the axis varies of it
    freedom: int  # the object's degrees of freedom
    scenario: str  # a shipped name
    changes: tuple[str, ...]  # "KEY=VALUE" overrides


def _steps(length: str, yaw: str) -> str:
    return f"lattice.steps={{x: {length}, y: {length}, yaw: {yaw} deg}}"


GRIDS = (2, 3, 5, 7, 9, 13, 19)
PLANAR_STEPS = (("1", "30"), ("1", "15"), ("0.5", "15"), ("0.5", "5"), ("0.25", "2.5"))
PLANAR_GRIDS = ((3, 1), (5, 2), (9, 4), (15, 6))
AXES: dict[str, tuple[Growing, ...]] = {
    "object nodes": (
        *(
            Growing("path (1)", 1, "paper/tumble",
                 ("fingers.placements.grid=[3, 3]", f"lattice.segments={n}"))
            for n in (15, 60, 240)
        ),
        *(
            Growing("planar (3)", 3, "planar/turn", (_steps(length, yaw),))
            for length, yaw in PLANAR_STEPS
        ),
    ),
    "placements": (
        *(
            Growing("paper/regrasp", 1, "paper/regrasp",
                 (f"fingers.placements.grid=[{m}, {m}]",))
            for m in GRIDS
        ),
        *(
            Growing("planar/turn", 3, "planar/turn", (f"fingers.placements.grid=[{a}, {b}]",))
            for a, b in PLANAR_GRIDS
        ),
    ),
    "fingers": tuple(
        Growing(series, freedom, scenario, (f"fingers.count={n}", *coarse))
        for series, freedom, scenario, coarse in (
            ("paper/tumble", 1, "paper/tumble",
             ("fingers.placements.grid=[3, 3]", "lattice.segments=15")),
            ("planar/turn", 3, "planar/turn", ("fingers.placements.grid=[5, 2]",)),
        )
        for n in (1, 2, 3, 4, 5)
    ),
}  # fmt: skip

HEAD = (
    "degrees of freedom", "scenario", "changed", "fingers", "placements", "object nodes",
    "`astar` ends", "cost", "expanded", "CPU s", "sampling: solved", "CPU s, median",
    "slowest", "cost, median",
)  # fmt: skip


def sampled(case: Growing, seeds: int, limit: float) -> tuple[list[float], list[float]]:
    """Return CPU times [s] and costs of the sampling planner's plans, with seeds 0, 1, ..."""
    scenario = api.load(case.scenario, case.changes)
    seconds, costs = [], []
    for seed in range(seeds):
        started = time.process_time()
        plan = api.plan(scenario, SAMPLER, time_limit=limit, seed=seed)
        if plan.cost is not None:
            seconds.append(time.process_time() - started)
            costs.append(plan.cost)
    return seconds, costs


def measurements(
    axis: str, cases: Sequence[Growing], seeds: int = SEEDS, limit: float = LIMIT
) -> Iterator[tuple[tuple[object, ...], dict[str, Any]]]:
    """Yield each case's line of the table, and its point as the picture draws it."""
    for case in cases:
        problem = api.load(case.scenario, case.changes).problem
        lattice = measured(case.scenario, overrides=case.changes, time_limit=limit, repeat=False)
        # Sampling proves nothing: where the lattice has no plan it mostly waits for its limit.
        tried = 0 if lattice.status == "infeasible" else seeds
        seconds, costs = sampled(case, tried, limit)
        placements, nodes = len(problem.fingers.placements), problem.lattice.size
        middle, slowest = (f(seconds) if seconds else None for f in (statistics.median, max))
        ends = {"solved": "plan, not proven", "infeasible": "proven infeasible"}
        yield (
            case.freedom, f"`{case.scenario}`", " ".join(f"`{change}`" for change in case.changes),
            problem.fingers.count, placements, number(nodes),
            "proven optimal" if lattice.optimal else ends.get(lattice.status, "budget spent"),
            number(lattice.cost, 5), *lattice.cells("expanded", "seconds"),
            f"{len(seconds)} of {tried}" if tried else "not tried",
            number(middle), number(slowest), number(statistics.median(costs) if costs else None, 5),
        ), {
            "series": case.series,
            "x": {"object nodes": nodes, "placements": placements}.get(axis, problem.fingers.count),
            "lattice": lattice.seconds,
            "proven": lattice.optimal or lattice.status == "infeasible",
            "sampling": middle,
            "lo": min(seconds, default=None),
            "hi": slowest,
        }  # fmt: skip


def study(
    page: Path, axes: dict[str, tuple[Growing, ...]], seeds: int = SEEDS, limit: float = LIMIT
) -> None:
    """Measure all axes, and write tables and picture as they grow."""
    panels: dict[str, list[dict[str, Any]]] = {}
    for axis, cases in axes.items():
        rows: list[tuple[object, ...]] = []
        panels[axis] = []
        for line, drawn in measurements(axis, cases, seeds, limit):
            rows.append(line)
            panels[axis].append(drawn)
            write_tables(page, {axis: table(HEAD, rows)})
    picture = page.parent / "images" / "scaling.svg"
    picture.parent.mkdir(exist_ok=True)
    with styled():
        save(scaling_figure(panels, limit), picture)


def scaling_figure(panels: Mapping[str, Sequence[Mapping[str, Any]]], limit: float) -> Any:
    """Draw one panel per quantity that was varied, by its name; inside ``styled`` alone.

    Args:
        panels: by the varied quantity's name, what ``measurements`` says of its picture.
        limit: where searches were stopped [s]; drawn as a line.
    """
    figure = new_figure(2.1 * COLUMN, 0.85 * COLUMN)
    axes = figure.subplots(1, len(panels), sharey=True)
    for ax, (name, rows) in zip(axes, panels.items(), strict=True):
        names = list(dict.fromkeys(row["series"] for row in rows))
        for series, line in zip(names, ("-", "--", ":", "-.")[: len(names)], strict=True):
            _series(ax, [row for row in rows if row["series"] == series], line)
            ax.plot([], [], line, color="0.3", label=series)
        ax.axhline(limit, color="0.6", linewidth=0.6)
        ax.set_xscale("linear" if name == "fingers" else "log")
        ax.set_yscale("log")
        ax.set_xlabel(name)
        ax.legend(frameon=False, loc="best", handlelength=2.2)
    axes[0].set_ylabel("CPU time [s]")
    hollow = {**ENDED, "markerfacecolor": "white"}
    looks = (
        ("o-", ENDED, "astar"), ("o", hollow, "astar, not ended within its limit"),
        ("s-", FOUND, f"{SAMPLER}, first plan"),
    )  # fmt: skip
    handles = [axes[0].plot([], [], form, label=label, **look)[0] for form, look, label in looks]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return figure


ENDED = {"color": "#1f77b4", "markersize": 3.5}
FOUND = {"color": "#d62728", "markersize": 2.5}


def _series(ax: Any, rows: Sequence[Mapping[str, Any]], line: str) -> None:
    """Draw one scenario's times: on the lattice, and by sampling where that found plans."""
    ax.plot(
        [row["x"] for row in rows], [row["lattice"] for row in rows], line, color=ENDED["color"]
    )
    for row in rows:
        face = ENDED["color"] if row["proven"] else "white"
        ax.plot(row["x"], row["lattice"], "o", markerfacecolor=face, **ENDED)
    known = [row for row in rows if row["sampling"] is not None]
    x, y, low, high = (np.array([r[k] for r in known]) for k in ("x", "sampling", "lo", "hi"))
    ax.errorbar(
        x, y, (y - low, high - y), fmt=line, marker="s", elinewidth=0.6, capsize=1.5, **FOUND
    )


def main(arguments: Sequence[str]) -> None:
    """Measure everything and write the page."""
    page = Path(arguments[0] if arguments else "docs/results/scaling.md")
    for name in ("paper/tumble", "planar/turn"):  # machine code loaded, nothing is timed
        api.plan(name, time_limit=LIMIT)
        api.plan(name, SAMPLER, time_limit=LIMIT)
    study(page, AXES)


if __name__ == "__main__":
    main(sys.argv[1:])
