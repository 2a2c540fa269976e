"""``python -m docs.tables.cells [PAGE]``: optimal costs and times on ever finer grids.

Each row is a search in a new process, made twice; the second counts. Takes about five minutes on
one core.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from docs.tables.measure import Measured, measure
from docs.tables.pages import growing, write_page
from gm_ompl import api
from gm_ompl.planners.lane_parts import FEW_SETS, set_count
from gm_ompl.study.report import number

GRIDS = (7, 13, 21, 51, 101)
SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
FINGERS = (2, 3, 4)
LIMIT = 60.0  # wall time per search [s]

HEAD = (
    "scenario", "grid", "fingers", "sets of placements", "searched by", "ends", "cost", "regrasps",
    "expanded", "CPU s", "MiB",
)  # fmt: skip


def rows(
    scenarios: Sequence[str], grids: Sequence[int], fingers: Sequence[int],
    known: dict[str, list[tuple[int, float]]] | None = None,
) -> Iterator[tuple[str, ...]]:  # fmt: skip
    """Yield a row per search; ``known`` gets sets and CPU times of those over cells."""
    for scenario in scenarios:
        for m in grids:
            for n in fingers:
                changes = (f"fingers.placements.grid=[{m}, {m}]", f"fingers.count={n}")
                sets = set_count(api.load(scenario, changes).problem)
                found = measure(scenario, overrides=changes, time_limit=LIMIT)
                yield _row(scenario, m, n, sets, found)
                if known is not None and sets > FEW_SETS and found.optimal:
                    known.setdefault(scenario, []).append((sets, found.seconds))


def _row(scenario: str, m: int, n: int, sets: int, found: Measured) -> tuple[str, ...]:
    regrasps = "-" if found.regrasps is None else str(found.regrasps)
    ends, cost, expanded, seconds, megabytes = found.cells(
        "ends", "cost", "expanded", "seconds", "megabytes"
    )
    by = "lanes" if sets <= FEW_SETS else "cells"
    where = (f"`{scenario}`", f"{m} x {m}", str(n), number(float(sets), 3), by)
    return (*where, ends, cost, regrasps, expanded, seconds, megabytes)


def exponents(known: Mapping[str, Sequence[tuple[int, float]]]) -> Iterator[tuple[str, str]]:
    """Yield per scenario the slope of log CPU time over log sets (least squares)."""
    for scenario, points in known.items():
        x = [math.log(sets) for sets, _ in points]
        y = [math.log(seconds) for _, seconds in points]
        a, b = math.fsum(x) / len(x), math.fsum(y) / len(y)
        square = math.fsum((u - a) ** 2 for u in x)
        slope = math.fsum((u - a) * (v - b) for u, v in zip(x, y, strict=True)) / square
        yield f"`{scenario}`", number(slope, 2)


def main() -> None:
    """Measure and write the page."""
    known: dict[str, list[tuple[int, float]]] = {}
    write_page("cells", {
        "grids": growing(HEAD, rows(SCENARIOS, GRIDS, (2,), known)),
        "exponents": growing(("scenario", "exponent"), exponents(known)),
        "fingers": growing(HEAD, rows(("paper/tumble", "paper/regrasp"), (9,), FINGERS)),
    })  # fmt: skip


if __name__ == "__main__":
    main()
