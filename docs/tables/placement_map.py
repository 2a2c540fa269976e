"""``python -m docs.tables.placement_map``: how long a map of placements takes."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

import gm_ompl
from docs.tables.pages import growing, write_page
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.report import number

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
GRIDS = {7: 5, 21: 3, 51: 1}
"""Placements along a face's side, and repetitions."""

HEAD = ("scenario", "grid", "placements", "wall [s]", "processor [s]")


def seconds(scenario: Scenario, repeat: int) -> tuple[float, float]:
    """Return medians of wall and processor time of a map, after one that is not counted."""
    walls, cpus = [], []
    for _ in range(repeat + 1):
        wall, cpu = time.perf_counter(), time.process_time()
        gm_ompl.placement_map(scenario, [0.4], [1.0])
        walls.append(time.perf_counter() - wall)
        cpus.append(time.process_time() - cpu)
    return statistics.median(walls[1:]), statistics.median(cpus[1:])


def rows() -> Iterator[tuple[object, ...]]:
    """Yield the rows of the table."""
    for name in SCENARIOS:
        for grid, repeat in GRIDS.items():
            scenario = gm_ompl.load(name, {"fingers.placements.grid": [grid, grid]})
            count = len(scenario.problem.fingers.placements)
            yield name, f"{grid} x {grid}", f"{count:,}", *map(number, seconds(scenario, repeat))


def main() -> None:
    """Measure and write the page."""
    write_page("placement-map", {"times": growing(HEAD, rows())})


if __name__ == "__main__":
    main()
