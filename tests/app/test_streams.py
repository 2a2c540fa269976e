"""Standard streams: what comes in, what goes out; tables are whole; shells complete."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Sequence

import pytest
from typer.testing import CliRunner, Result

from gm_ompl.app.completing import motions, planners, scenarios
from gm_ompl.app.main import app
from gm_ompl.app.studying import show_table
from gm_ompl.app.verbs import GROUPS, VERBS
from gm_ompl.study.report import Table

SMALL = ["--set", "lattice.segments=3", "--set", "fingers.placements.grid=[2, 2]"]


def gm_ompl(*arguments: str, given: str = "") -> Result:
    """Run the command in this process, ``given`` at its standard input."""
    return CliRunner().invoke(app, list(arguments), input=given)


@pytest.fixture(scope="module")
def plan() -> str:
    """A plan of a new scenario, both passed on through pipes."""
    scenario = gm_ompl("new", "--yes")
    made = gm_ompl("plan", "-", *SMALL, "-o", "-", given=scenario.stdout)
    assert made.exit_code == 0, made.stderr
    assert "cost" in made.stderr
    return made.stdout


def test_a_scenario_and_a_plan_come_in_by_stdin(plan: str) -> None:
    """``new | plan - -o - | check -``: each reads what the one before wrote."""
    assert json.loads(plan)["status"] == "solved"
    checked = gm_ompl("check", "-", given=plan)
    assert (checked.exit_code, checked.stdout.splitlines()[-1]) == (0, "the plan holds")


def test_mistakes_at_stdin_are_told_with_line_and_key() -> None:
    """What comes in is "-" in messages; nothing at all is no scenario."""
    wrong = gm_ompl("plan", "-", given="format: gm-ompl-scenario/1\nnaem: x\n")
    assert wrong.exit_code == 2
    assert "-:2:1: naem: unknown key; did you mean 'name'" in wrong.stderr
    assert gm_ompl("plan", "-").exit_code == 2
    assert gm_ompl("check", "-").exit_code == 2


def test_files_go_to_stdout(plan: str) -> None:
    """``-o -`` gives the file and nothing else: a picture, a table, a page."""
    assert gm_ompl("plot", "-", "-o", "-", given=plan).stdout.startswith("<?xml")
    lines = gm_ompl("export", "-", "-o", "-", given=plan).stdout.splitlines()
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    assert rows[0][0] == "time"
    assert len({len(row) for row in rows}) == 1
    assert gm_ompl("view", "-", "--html", "-", given=plan).stdout.startswith("<!DOCTYPE html>")


def test_what_is_several_files_needs_a_name() -> None:
    """A comparison's folder and a study's are no streams: exit code 2."""
    for verb in (["compare", "paper/slide", "--planners", "astar"],
                 ["tune", "paper/slide", "paper/push", "paper/cork", "--planner", "HybridRRT",
                  "--trials", "1"]):  # fmt: skip
        refused = gm_ompl(*verb, "-o", "-")
        assert refused.exit_code == 2
        assert "-o -" in refused.stderr


def test_wide_tables_are_whole_in_a_pipe(capsys: pytest.CaptureFixture[str]) -> None:
    """A row is a line and no number is cut, however narrow a terminal is said to be."""
    numbers = tuple(f"{1000000 + k}.25" for k in range(40))
    head = ("scenario", "planner", *(f"column {k}" for k in range(40)))
    show_table(Table("t", head, (("s" * 60, "p", *numbers),)))
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "sss" in line]
    assert tuple(row.split()[2:]) == numbers


def completed(words: str) -> Sequence[str]:
    """Return what bash would offer for the last of these words."""
    asked = {"_GM_OMPL_COMPLETE": "complete_bash", "COMP_WORDS": words,
             "COMP_CWORD": str(len(words.split(" ")) - 1)}  # fmt: skip
    code = "from gm_ompl.app.main import run; run()"
    return subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True, timeout=60,
        env={**os.environ, **asked},
    ).stdout.split()  # fmt: skip


def test_shells_complete_verbs_scenarios_and_planners() -> None:
    """What was begun is completed by what there is."""
    assert {"paper/push", "paper/slide"} <= set(completed("gm-ompl plan paper/"))
    assert scenarios("paper/r") == ["paper/regrasp"]
    assert {"HybridRRT", "HybridRRTstar"} <= set(planners("Hybrid"))
    assert motions("t") == ["tumble"]


def test_every_verb_stands_under_one_heading() -> None:
    """``--help`` lists each verb once, its first sentence whole."""
    assert sorted(verb for verbs in GROUPS.values() for verb in verbs) == sorted(VERBS)
    shown = CliRunner().invoke(app, ["--help"], env={"COLUMNS": "80"}).stdout
    assert all(f"{heading}:" in shown for heading in GROUPS)
    assert "..." not in shown.split("Begin:")[1]
