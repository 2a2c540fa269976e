"""``gm-ompl map``: numbers, images, pages, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import gm_ompl
from gm_ompl.app.main import app
from gm_ompl.feasibility.verdict import Finding

GRID = ("--set", "fingers.placements.grid=[2, 2]")


def run(*arguments: str) -> tuple[int, str, str]:
    """Return a command's exit code, and what it wrote to stdout and to stderr."""
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, result.stdout, result.stderr


def test_numbers_are_those_of_judge() -> None:
    """A placement's margin is that of its best set, judged by itself."""
    code, out, _ = run("map", "paper/slide", "--at", "0.4", *GRID, "--json")
    assert code == 0
    told = json.loads(out)
    scenario = gm_ompl.load("paper/slide", {"fingers.placements.grid": [2, 2]})
    (kind,) = told["fingers"]
    assert kind["fingers"] == [0, 1]
    holding = [one for one in kind["placements"] if one["finding"] == "holds"]
    assert holding
    for one in holding[::3]:
        rows = [(at["face"], at["cell"]) for at in one["partners"]]
        verdict = gm_ompl.judge(scenario, [0.4], [1.0], rows)
        assert verdict.holds and verdict.decision is not None
        assert verdict.decision.z == pytest.approx(one["z"], rel=1e-6)


def test_what_blocks_is_told() -> None:
    """A fingertip under the object is in the floor; with next to no force nothing holds."""
    found = gm_ompl.placement_map(gm_ompl.load("paper/tumble", {"fingers.placements.grid": [2, 2]}))
    table = found.problem.fingers.placements
    below = table.face == table.labels.index("-z")
    assert {found.finding(0, row) for row in below.nonzero()[0]} == {Finding.GEOMETRY}
    weak = gm_ompl.placement_map("paper/tumble", [0.5], [1.0])
    assert Finding.HOLDS in weak.counts(0)
    weak = gm_ompl.placement_map(
        gm_ompl.load("paper/tumble", {"fingers.max_normal_force": 0.01}), [0.5], [1.0]
    )
    assert Finding.HOLDS not in weak.counts(0)
    assert Finding.NO_EQUILIBRIUM in weak.counts(0)


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf", ".html", ".json"])
def test_written_files(tmp_path: Path, suffix: str) -> None:
    """The suffix names the form."""
    path = tmp_path / f"map{suffix}"
    code, _, err = run("map", "paper/push", "--at", "0.5", *GRID, "-o", str(path))
    assert code == 0 and "written to" in err
    assert path.stat().st_size > 500


def test_a_plans_step(tmp_path: Path) -> None:
    """At a plan's step its own set holds, so every placement in it is at least as good."""
    plan = gm_ompl.plan(gm_ompl.load("paper/regrasp", {"fingers.placements.grid": [3, 3]}))
    path = tmp_path / "plan.json"
    plan.save(path)
    for number, step in enumerate(plan.steps):
        code, out, _ = run("map", str(path), "--step", str(number), "--json")
        assert code == 0
        if step.kind == "displacement":
            rows = json.loads(out)["fingers"][0]["placements"]
            least = min(segment.z for segment in step.segments)
            for place in step.placements:
                here = (place.face, list(place.cell or ()))
                z = next(row["z"] for row in rows if (row["face"], row["cell"]) == here)
                assert z >= least * (1.0 - 1e-6)
    code, _, err = run("map", str(path), "--step", "99")
    assert code == 2 and "counted from 0" in err


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["paper/slide", "--at", "2"], "from 0 to 1"),
        (["paper/slide", "--at", "x"], "--at"),
        (["paper/slide", "--direction", "1", "--rest"], "--rest"),
        (["paper/slide", "--finger", "7"], "--finger"),
        (["paper/slide", "--set", "fingers.count=0"], "fingers.count"),
        (["paper/slide", "-o", "map.txt"], ".png"),
        (["paper/slide", "--step", "0"], "paper/slide"),
        (["paper/nothing"], "paper/nothing"),
        (["paper/slide", "--step", "0", "--at", "0.5"], "--at"),
    ],
)
def test_bad_requests(options: list[str], word: str) -> None:
    """Each ends with 2 and names what is wrong."""
    code, _, err = run("map", *options)
    assert code == 2
    assert word in err


def test_limits_hold() -> None:
    """A map that is too much for the time ends with 4."""
    grid = ("--set", "fingers.placements.grid=[51, 51]")
    code, _, err = run("map", "paper/slide", *grid, "--time-limit", "0.2")
    assert code == 4 and "time" in err
