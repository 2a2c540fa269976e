"""Builds the gallery: ``python -m docs.tables.gallery docs`` writes gallery.md and its images.

By the commands that the page shows.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from gm_ompl.app.main import app
from gm_ompl.app.planning import summary
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.load import load, shipped
from gm_ompl.writing import write_text

TIME_LIMIT: Final = 120.0  # a scenario that is not solved within this time is left out [s]
SEARCH_OF: Final = "paper/regrasp"  # the scenario whose searches are shown

SEARCHES: Final = {
    "astar": "what was expanded, where, when and why; the bound rises until it meets the cost",
    "HybridRRTConnect": "the two trees, a row per set of placements",
}
"""Planners whose searches are shown, and what there is to see."""

_HEAD: Final = """# Gallery

<!-- this page is written by a program -->

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
    (folder / "images").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        plan, trace = Path(scratch) / "plan.json", Path(scratch) / "trace.jsonl"
        parts = ["\n".join(_section(name, folder / "images", plan, trace)) for name in shipped()]
    write_text(folder / "gallery.md", "\n".join([_HEAD, *filter(None, parts)]))


def _called(*words: object) -> None:
    """Call ``gm-ompl``; what it says of a plan that it did not find is no error here."""
    try:
        app([str(word) for word in words])
    except SystemExit as ended:
        if ended.code not in (0, 3, 4):
            raise


def _section(name: str, images: Path, plan: Path, trace: Path) -> Iterator[str]:
    """Yield the lines of one scenario's section, none without a plan; writes its images."""
    stem = name.replace("/", "-")
    scenario = load(name)
    # Over a hand's reach exact search takes minutes; where no optimum is known it did not end.
    sampled = scenario.problem.hand is not None or scenario.model.expect.status is None
    by = ("--planner", "HybridRRTConnect") if sampled else ()
    _called("plan", name, *by, "--time-limit", TIME_LIMIT, "-o", plan)
    found = Plan.load(plan)
    if not found.steps:
        return
    _called("plot", plan, "--show", "snapshots", "-o", images / f"{stem}.svg")
    _called("plot", plan, "-o", images / f"{stem}-forces.svg")
    yield f"## {name}\n"
    yield f"{found.scenario.get('description', '')}\n"
    yield " ".join(("    gm-ompl plan", name, *by, "-o plan.json"))
    yield "    gm-ompl plot plan.json --show snapshots -o snapshots.svg"
    yield "    gm-ompl plot plan.json -o forces.svg\n"
    yield f"![{name}: start, regrasps and goal](images/{stem}.svg)\n"
    lines = [line.strip() for line in summary(found, scenario.problem)]
    told = [line for line in lines if not line.startswith(("search", name))]
    yield "".join(f"* {line}\n" for line in told)
    yield f"![{name}: forces, modes, z and travel](images/{stem}-forces.svg)\n"
    for planner, seen in SEARCHES.items() if name == SEARCH_OF else ():
        picture = f"{stem}-search-{planner}.svg"
        search = ("--planner", planner, "--trace", trace)
        _called("plan", name, "--time-limit", TIME_LIMIT, *search, "-o", plan)
        _called("plot", plan, "--show", "search", "--trace", trace, "-o", images / picture)
        yield f"    gm-ompl plan {name} --planner {planner} --trace trace.jsonl -o plan.json"
        yield "    gm-ompl plot plan.json --show search --trace trace.jsonl -o search.svg\n"
        yield f"![{name}, the search by {planner}](images/{picture})\n"
        yield f"*{planner}: {seen}.*\n"


if __name__ == "__main__":
    build(Path(sys.argv[1]))
