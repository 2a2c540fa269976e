"""``python -m gm_ompl.study.ablation [PAGE]``: what the search owes to what.

Measures the paper's scenarios without heuristic, with the paper's and with the search over lanes,
time and memory of the latter against segments, grid and fingers, and time per node on random
scenarios; writes the tables into PAGE (docs/ablation.md). Takes a quarter of an hour on one core.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from gm_ompl.study.measure import Measurement, measure
from gm_ompl.study.pages import number, table, write_tables

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/cork", "paper/regrasp")
HEURISTICS = (("none", "none"), ("travel", "(11)"), ("lanes", "lanes"))
LIMIT = 3600.0
"""Wall time per search [s]."""

SEGMENTS = (15, 30, 60, 120, 240)
GRIDS = (3, 5, 7, 9, 13)
FINGERS = (1, 2, 3)
AXES: dict[str, list[tuple[int, tuple[str, ...]]]] = {
    "segments": [(n, (f"lattice.segments={n}",)) for n in SEGMENTS],
    "grid": [(m, (f"fingers.placements.grid=[{m}, {m}]",)) for m in GRIDS],
    "fingers": [(n, (f"fingers.count={n}", "fingers.placements.grid=[3, 3]")) for n in FINGERS],
}
SCALED = ("paper/tumble", "paper/regrasp")

HELD_OUT = [(family, seed) for family in ("tumble", "regrasp") for seed in range(6)]
"""Random scenarios, of other sizes, masses, frictions, limits and walls, two or three fingers."""
HELD_OUT_GRIDS = (7, 9)
HELD_OUT_LIMIT = 60.0
"""Wall time per search [s]."""
ALLOWED = {"tumble": 1.0 / 1_335_201, "regrasp": 5.0 / 1_335_201}
"""What a node of the paper's problem may cost [s]."""


def heuristics() -> Iterator[str]:
    """Yield the table of the three searches, longer and longer."""
    head = ("scenario", "heuristic", "ends", "cost", "expanded", "mode decisions", "CPU s", "MiB")
    rows = []
    for scenario in SCENARIOS:
        for heuristic, name in HEURISTICS:
            found = measure(scenario, heuristic, time_limit=LIMIT, repeat=heuristic == "lanes")
            rows.append((
                scenario, name, ending(found), number(found.cost, 6), number(found.expanded),
                number(found.decisions), number(found.seconds), number(found.megabytes),
            ))  # fmt: skip
            yield table(head, rows)


def scaling() -> Iterator[str]:
    """Yield the table of time and memory, with exponents from straight lines in log-log."""
    head = (
        "scenario", "varied", "value", "nodes", "ends", "expanded", "mode decisions", "CPU s",
        "us a node", "MiB",
    )  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for scenario in SCALED:
        for axis, steps in AXES.items():
            points = [(x, measure(scenario, "lanes", changes, LIMIT)) for x, changes in steps]
            rows += [
                (
                    scenario, axis, x, number(found.nodes), ending(found), number(found.expanded),
                    number(found.decisions), number(found.seconds),
                    number(1e6 * found.seconds / found.nodes), number(found.megabytes),
                )
                for x, found in points
            ]  # fmt: skip
            exponents = {
                what: f"{slope(points, what):.2f}"
                for what in ("nodes", "expanded", "decisions", "seconds", "megabytes")
            }
            nodes, *others, memory = exponents.values()
            rows.append((scenario, f"{axis}: exponent", "", nodes, "", *others, "", memory))
            yield table(head, rows)


def held_out() -> Iterator[str]:
    """Yield the table of random scenarios, whose nodes may cost twice what the paper's may."""
    head = (
        "scenario", "grid", "nodes", "ends", "expanded", "mode decisions", "CPU s", "us a node",
        "of the paper's", "MiB",
    )  # fmt: skip
    rows = []
    for family, seed in HELD_OUT:
        for m in HELD_OUT_GRIDS:
            name = f"random/{family}/{seed}"
            changes = (f"fingers.placements.grid=[{m}, {m}]", "lattice.segments=30")
            found = measure(name, "lanes", changes, HELD_OUT_LIMIT)
            each = found.seconds / found.nodes
            rows.append((
                name, f"{m} x {m}", number(found.nodes), ending(found), number(found.expanded),
                number(found.decisions), number(found.seconds), number(1e6 * each),
                number(each / ALLOWED[family]), number(found.megabytes),
            ))  # fmt: skip
            yield table(head, rows)


def ending(found: Measurement) -> str:
    """Return how a search ended, in two words."""
    return "proven optimal" if found.optimal else found.status


def slope(points: Sequence[tuple[int, Measurement]], what: str) -> float:
    """Return the exponent p of ``what`` ~ x^p, least squares in logarithms."""
    x = np.log([float(value) for value, _ in points])
    y = np.log([max(float(getattr(found, what)), 1e-9) for _, found in points])
    return float(np.polyfit(x, y, 1)[0])


def main(arguments: Sequence[str]) -> None:
    """Measure everything and write the page."""
    page = Path(arguments[0] if arguments else "docs/ablation.md")
    for name, growing in (
        ("scaling", scaling()),
        ("held_out", held_out()),
        ("heuristics", heuristics()),
    ):
        # Written as it grows: a run that is stopped leaves what it has measured.
        for content in growing:
            write_tables(page, {name: content})


if __name__ == "__main__":
    main(sys.argv[1:])
