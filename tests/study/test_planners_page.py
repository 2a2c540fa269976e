"""docs/results/planners.md: its table and picture say what the runs say."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from docs.tables import planners, reference
from docs.tables.pages import write_tables
from docs.tables.planners import DESIGN, curves, draw, rates
from gm_ompl.planners.registry import PLANNERS
from tests.study.test_compare_report import EVIL, OPTIMA, RUNS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "results" / "planners.md"


def test_the_table_counts_runs_without_a_plan() -> None:
    """As many lines as planners; medians and worst of cost over the optimum and of times."""
    lines = rates(RUNS, OPTIMA).splitlines()
    assert len(lines) == 2 + 2
    cells = [cell.strip() for cell in lines[-1].removeprefix(f"| {EVIL} |").split("|")][:-1]
    assert cells == ["RRT", "3 of 4", "0.7", "0.7", "1.3", "1.4", "1"]


def test_half_the_runs_must_have_a_plan_before_a_cost_is_drawn() -> None:
    """RRT's second, third and fastest plan come at 0.6, 0.7 and 0.5 s, of four runs."""
    drawn = curves(RUNS, OPTIMA, 5.0)[EVIL]["RRT"]
    times, ratios = drawn["ratio"]
    early = [ratio for time, ratio in zip(times, ratios, strict=True) if time < 0.69]
    assert set(early) == {None}
    late = ratios[-1]
    assert late == pytest.approx(1.4)  # of 1.2, 1.3, 1.4, none: the upper middle
    assert drawn["success"][1][-1] == 0.75


def test_a_picture_shows_every_planner_and_scenario(tmp_path: Path) -> None:
    """Names are text of the picture, whatever they hold."""
    draw(curves(RUNS, OPTIMA, 5.0), 5.0, tmp_path / "planners.svg")
    root = ET.parse(tmp_path / "planners.svg").getroot()
    words = {"".join(element.itertext()).strip() for element in root.iter()}
    assert {"astar", "RRT", "share of runs with a plan", "time [s]"} <= words


def test_the_page_has_room_for_the_table_and_names_all_planners(tmp_path: Path) -> None:
    """Words stay; the planners are the project's and all of OMPL's that are sound."""
    copy = tmp_path / "planners.md"
    copy.write_text(PAGE.read_text())
    write_tables(copy, {"rates": rates(RUNS, OPTIMA)})
    marks = re.compile(r"(<!-- begin rates -->\n).*?(<!-- end rates -->)", re.DOTALL)
    assert marks.sub(r"\1\2", copy.read_text()) == marks.sub(r"\1\2", PAGE.read_text())
    assert {"astar", "HybridRRTstar", "FMT", "KPIECE1", "SORRTstar"} <= set(DESIGN.planners)
    assert "dijkstra" not in DESIGN.planners


def test_no_page_is_said_before_any_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2, and the store is not even made."""
    store = tmp_path / "runs.sqlite"
    code = planners.main(["--page", str(tmp_path / "none.md"), "--store", str(store)])
    assert code == 2 and "--page" in capsys.readouterr().err
    assert not store.exists()


def test_parameters_are_those_that_the_planners_declare() -> None:
    """Name, default and meaning, a row each; no other is named."""
    declared = {
        f"| `{one.name}` | {one.default} | {one.meaning} |"
        for planner in ("HybridRRT", "HybridRRTstar")
        for one in PLANNERS[planner].parameters
    }
    section = reference.planners().split("## Parameters")[1]
    assert declared <= {line for line in section.splitlines() if line.startswith("| `")}
