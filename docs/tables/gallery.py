"""Builds the gallery: ``python -m docs.tables.gallery docs`` writes gallery.md and its images."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from gm_ompl.viz.canvas import save, styled
from gm_ompl.viz.figures import forces_figure
from gm_ompl.viz.search import search_figure
from gm_ompl.viz.snapshots import snapshots_figure
from gm_ompl.viz.story import tell

from gm_ompl import api
from gm_ompl.app.planning import summary
from gm_ompl.plan import files
from gm_ompl.plan.model import Plan
from gm_ompl.planners.planner import silent
from gm_ompl.planners.trace_file import TraceFile, read_trace
from gm_ompl.scenario.load import shipped

TIME_LIMIT: Final = 120.0
"""A scenario that is not solved within this time is left out [s]."""

SEARCH_OF: Final = "paper/regrasp"
"""The scenario whose searches are shown."""

SEARCHES: Final = {
    "astar": "what was expanded, where, when and why; the bound rises until it meets the cost",
    "HybridRRTConnect": "the two trees, a row per set of placements",
}
"""Planners whose searches are shown, and what there is to see."""

_HEAD: Final = """# Gallery

What the shipped scenarios look like when planned. This page and its images are built by
`make gallery`; nothing here is drawn by hand.

A fingertip under position control is blue, in a square; under force control it is vermilion, with
a ring and an arrow for the commanded force f_com. In the plots a commanded force is a line; for a
position-controlled finger, whose force statics leaves open, the shaded range is what equilibrium
without disturbance allows.

Each plan can also be watched: `gm-ompl view PLAN.json` serves it to the browser on this machine,
`gm-ompl view PLAN.json --html FILE` writes one file that needs no network.
"""


def build(folder: Path) -> None:
    """Plan every shipped scenario and write ``gallery.md`` and ``images/`` into ``folder``."""
    images = folder / "images"
    images.mkdir(parents=True, exist_ok=True)
    parts = [_HEAD]
    for name in shipped():
        plan = api.plan(name, time_limit=TIME_LIMIT)
        if plan.steps:
            parts.append("\n".join(_section(name, plan, images)))
    files.write(folder / "gallery.md", "\n".join(parts))


def _section(name: str, plan: Plan, images: Path) -> Iterator[str]:
    """Yield the lines of one scenario's section; writes its images."""
    stem, story = name.replace("/", "-"), tell(plan)
    with styled():
        save(snapshots_figure(story), images / f"{stem}.svg")
        save(forces_figure(story), images / f"{stem}-forces.svg")
    yield f"## {name}\n"
    yield f"{plan.scenario.get('description', '')}\n"
    yield f"    gm-ompl plan {name} -o plan.json"
    yield "    gm-ompl plot plan.json --show snapshots -o snapshots.svg"
    yield "    gm-ompl plot plan.json -o forces.svg\n"
    yield f"![{name}: start, regrasps and goal](images/{stem}.svg)\n"
    lines = [line.strip() for line in summary(plan)]
    found = [line for line in lines if not line.startswith(("search", name))]
    yield "".join(f"* {line}\n" for line in found)
    yield f"![{name}: forces, modes, z and travel](images/{stem}-forces.svg)\n"
    if name == SEARCH_OF:
        for planner, seen in SEARCHES.items():
            picture = f"{stem}-search-{planner}.svg"
            _draw_search(name, planner, images / picture)
            yield f"    gm-ompl plan {name} --planner {planner} --trace trace.jsonl -o plan.json"
            yield "    gm-ompl plot plan.json --show search --trace trace.jsonl -o search.svg\n"
            yield f"![{name}, the search by {planner}](images/{picture})\n"
            yield f"*{planner}: {seen}.*\n"


def _draw_search(name: str, planner: str, picture: Path) -> None:
    """Plan with a trace and draw what the search did."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trace.jsonl"
        problem = api.load(name).problem
        header = {"scenario": name, "planner": planner, "seed": 0,
                  "coordinates": list(problem.motion.names)}  # fmt: skip
        with TraceFile(path, header, silent) as report:
            plan = api.plan(name, planner, time_limit=TIME_LIMIT, report=report)
            report.end(plan)
        with styled():
            save(search_figure(tell(plan), read_trace(path)), picture)


if __name__ == "__main__":
    build(Path(sys.argv[1]))
