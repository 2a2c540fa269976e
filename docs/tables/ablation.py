"""``python -m docs.tables.ablation [PAGE]``: what the search owes to what.

Measures the paper's scenarios without heuristic, with the paper's and with the search over lanes,
time and memory of the latter against segments, grid and fingers, and time per node on random
scenarios. Takes a quarter of an hour on one core.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import TypeAlias

import numpy as np

from docs.tables.measure import Measured, measure
from docs.tables.pages import growing, write_page
from gm_ompl.study.report import number

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/cork", "paper/regrasp")
HEURISTICS = (("none", "none"), ("travel", "(11)"), ("lanes", "lanes"))
LIMIT = 3600.0  # wall time per search [s]

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
HELD_OUT_LIMIT = 60.0  # wall time per search [s]
ALLOWED = {"tumble": 1.0 / 1_335_201, "regrasp": 5.0 / 1_335_201}
"""What a node of the paper's problem may cost [s]."""

WORK = ("expanded", "decisions", "seconds")  # what a search took, and the heads of its columns
WORK_HEAD = ("expanded", "mode decisions", "CPU s")


Rows: TypeAlias = Iterator[tuple[object, ...]]


def heuristics() -> Rows:
    """Yield the rows of the three searches."""
    for scenario, (heuristic, name) in product(SCENARIOS, HEURISTICS):
        repeat = heuristic == "lanes"
        found = measure(scenario, heuristic=heuristic, time_limit=LIMIT, repeat=repeat)
        yield scenario, name, *found.cells("ends", "cost", *WORK, "megabytes")


def scaling() -> Rows:
    """Yield the rows of time and memory, with exponents from straight lines in log-log."""
    for scenario, (axis, steps) in product(SCALED, AXES.items()):
        points = [
            (x, measure(scenario, overrides=changes, time_limit=LIMIT)) for x, changes in steps
        ]
        for x, found in points:
            cells, each = found.cells("nodes", "ends", *WORK), found.seconds / found.nodes
            yield scenario, axis, x, *cells, number(1e6 * each), *found.cells("megabytes")
        nodes, *others, memory = (
            f"{slope(points, what):.2f}" for what in ("nodes", *WORK, "megabytes")
        )
        yield scenario, f"{axis}: exponent", "", nodes, "", *others, "", memory


def held_out() -> Rows:
    """Yield the rows of random scenarios, whose nodes may cost twice what the paper's may."""
    for (family, seed), m in product(HELD_OUT, HELD_OUT_GRIDS):
        name = f"random/{family}/{seed}"
        changes = (f"fingers.placements.grid=[{m}, {m}]", "lattice.segments=30")
        found = measure(name, overrides=changes, time_limit=HELD_OUT_LIMIT)
        each = found.seconds / found.nodes
        yield (
            name, f"{m} x {m}", *found.cells("nodes", "ends", *WORK),
            number(1e6 * each), number(each / ALLOWED[family]), *found.cells("megabytes"),
        )  # fmt: skip


def slope(points: Sequence[tuple[int, Measured]], what: str) -> float:
    """Return the exponent p of ``what`` ~ x^p, least squares in logarithms."""
    x = np.log([float(value) for value, _ in points])
    y = np.log([max(float(getattr(found, what)), 1e-9) for _, found in points])
    return float(np.polyfit(x, y, 1)[0])


if __name__ == "__main__":
    node = (*WORK_HEAD, "us a node")
    write_page("ablation", {
        "scaling": growing(
            ("scenario", "varied", "value", "nodes", "ends", *node, "MiB"), scaling()
        ),
        "held_out": growing(
            ("scenario", "grid", "nodes", "ends", *node, "of the paper's", "MiB"), held_out()
        ),
        "heuristics": growing(
            ("scenario", "heuristic", "ends", "cost", *WORK_HEAD, "MiB"), heuristics()
        ),
    })  # fmt: skip
