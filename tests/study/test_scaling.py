"""The scaling study: what it measures is what the planners say, and the page holds all of it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import gm_ompl
from docs.tables import scaling
from docs.tables.scaling import AXES, Growing

PAGES = Path(__file__).resolve().parents[2] / "docs" / "results"
SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
TINY = {
    "placements": (Growing("slide", 1, "paper/slide", SMALL),),
    "fingers": (
        Growing("slide", 1, "paper/slide", (*SMALL, "fingers.count=1")),
        Growing("slide", 1, "paper/slide", SMALL),
    ),
}


def test_a_small_study(tmp_path: Path) -> None:
    """One row per case with the optimum and the number of runs that solved; a picture beside."""
    page = tmp_path / "page.md"
    page.write_text("".join(f"<!-- begin {axis} -->\n<!-- end {axis} -->\n" for axis in TINY))
    scaling.study(page, TINY, seeds=2, limit=300.0)
    lines = [line for line in page.read_text().splitlines() if line.startswith("| 1 |")]
    assert len(lines) == 3
    plan = gm_ompl.plan(gm_ompl.load("paper/slide", SMALL))
    assert plan.cost is not None
    assert f"| proven optimal | {plan.cost:.5g} |" in lines[0]
    assert "| 2 of 2 |" in lines[0]
    assert "| proven infeasible | - |" in lines[1]
    assert "| not tried | - |" in lines[1]
    root = ET.parse(tmp_path / "images" / "scaling.svg").getroot()
    words = {"".join(element.itertext()).strip() for element in root.iter()}
    assert {"placements", "fingers", "CPU time [s]"} <= words


def test_the_page_has_a_row_per_case() -> None:
    """Every case of every axis stands in docs/results/scaling.md, the sampling columns filled."""
    page = (PAGES / "scaling.md").read_text(encoding="utf-8")
    for axis, cases in AXES.items():
        part = page.split(f"<!-- begin {axis} -->")[1].split(f"<!-- end {axis} -->")[0]
        for case in cases:
            changes = " ".join(f"`{change}`" for change in case.changes)
            (line,) = [
                line for line in part.splitlines() if f"| `{case.scenario}` | {changes} |" in line
            ]
            assert f"of {scaling.SEEDS} |" in line or "| not tried |" in line
    assert (PAGES / "images" / "scaling.svg").exists()
