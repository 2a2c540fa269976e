"""``python -m docs.tables.placement_map``: how long a map of placements takes.

``--picture FILE.gif`` draws maps while a box is tumbled instead.
"""

from __future__ import annotations

import io
import statistics
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from gm_ompl.viz.canvas import styled
from gm_ompl.viz.placements import placements_figure
from PIL import Image

import gm_ompl
from docs.tables.pages import growing, write_page
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.report import number

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
GRIDS = {7: 5, 21: 3, 51: 1}
"""Placements along a face's side, and repetitions."""

FRAMES = 16  # of the picture

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


def picture(file: Path) -> None:
    """Draw the map again and again while the box of paper/tumble is tumbled."""
    frames: list[Image.Image] = []
    with styled():
        for s in np.linspace(0.02, 0.98, FRAMES).tolist():
            drawn = io.BytesIO()
            figure = placements_figure(gm_ompl.placement_map("paper/tumble", [s], [1.0]))
            figure.suptitle(f"paper/tumble, s = {s:.2f}", fontsize=8)
            figure.savefig(drawn, format="png", dpi=130)
            frames.append(Image.open(drawn).convert("RGB").quantize(96))
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=400, loop=0)


def main() -> None:
    """Draw the picture, or measure and write the page."""
    if sys.argv[1:2] == ["--picture"]:
        picture(Path(sys.argv[2]))
    else:
        write_page("placement-map", {"times": growing(HEAD, rows())})


if __name__ == "__main__":
    main()
