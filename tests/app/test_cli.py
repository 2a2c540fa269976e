"""The command line's contract: exit codes, and what goes to stdout, stderr and files."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner, Result

import gm_ompl
from gm_ompl import api, asking
from gm_ompl.app.main import app, program
from gm_ompl.planfile.model import Plan

SMALL = [
    "--set", "lattice.segments=3", "--set", "fingers.placements.grid=[2, 2]",
]  # fmt: skip
"""Makes the paper's slide small enough to be planned in a moment."""


def invoke(*arguments: str | Path | int) -> Result:
    """Run the command in this process; stdout and stderr apart."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_list_names_each_shipped_scenario_on_a_line() -> None:
    """``list`` prints one line per scenario: name, what it shows, source."""
    result = invoke("list")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    names = [line.split()[0] for line in lines]
    assert {"paper/slide", "paper/push"} <= set(names)
    assert names == sorted(names)
    assert all("Maeda" in line for line in lines if line.startswith("paper/"))
    assert [
        row["name"] for row in json.loads(invoke("list", "--json").stdout)["scenarios"]
    ] == names


def test_every_listed_scenario_loads_under_its_name() -> None:
    """What ``list`` names, ``plan`` finds."""
    for row in json.loads(invoke("list", "--json").stdout)["scenarios"]:
        assert api.load(row["name"]).name == row["name"]


@pytest.fixture(scope="module")
def small_plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of a small slide, written by the command."""
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    result = invoke("plan", "paper/slide", *SMALL, "-o", path)
    assert result.exit_code == 0, result.output
    return path


def test_a_plan_that_was_found_holds(small_plan: Path) -> None:
    """Plan ends with 0 and writes the file; check confirms it with 0."""
    result = invoke("check", small_plan)
    assert result.exit_code == 0, result.output
    report = invoke("check", small_plan, "--json")
    assert json.loads(report.stdout)["holds"] is True


def test_a_tampered_plan_is_refused_with_5(small_plan: Path, tmp_path: Path) -> None:
    """Check ends with 5 and names the step."""
    plan = json.loads(small_plan.read_text())
    plan["steps"][1]["segments"][0]["z"] *= 1.01
    tampered = tmp_path / "tampered.json"
    tampered.write_text(json.dumps(plan))
    result = invoke("check", tampered)
    assert result.exit_code == 5
    assert "step 1" in result.stdout
    assert json.loads(invoke("check", tampered, "--json").stdout)["holds"] is False


def test_json_is_one_object_and_nothing_else(small_plan: Path, tmp_path: Path) -> None:
    """``plan --json`` prints the plan; the file holds the same plan, timings apart."""
    path = tmp_path / "plan.json"
    result = invoke("plan", "paper/slide", *SMALL, "--json", "-o", path)
    printed, written = json.loads(result.stdout), json.loads(path.read_text())
    assert printed == written
    before = json.loads(small_plan.read_text())
    for plan in (before, written):
        del plan["statistics"]
    assert before == written


def test_infeasible_ends_with_3_and_writes_the_file(tmp_path: Path) -> None:
    """A proof that no plan exists is a result: exit code 3, the file says so."""
    path = tmp_path / "plan.json"
    result = invoke("plan", "paper/slide", *SMALL, "--set", "mechanics.z_min=1000", "-o", path)
    assert result.exit_code == 3, result.output
    plan = json.loads(path.read_text())
    assert (plan["status"], plan["cost"], plan["steps"]) == ("infeasible", None, [])


def test_what_is_proven_is_proven_on_the_lattice(tmp_path: Path) -> None:
    """Every verb that says "optimal" or "infeasible" says where: plan, check, explain, view."""
    path, page = tmp_path / "plan.json", tmp_path / "page.html"
    bad = ("--set", "mechanics.z_min=1000")
    said = [
        invoke("plan", "paper/slide", *SMALL, "-o", path, "--html", page).output,
        invoke("check", path).output,
        page.read_text(encoding="utf-8").replace("meshcat", ""),
    ]
    said += [
        invoke("plan", "paper/slide", *SMALL, *bad, "-o", path).output,
        invoke("check", path).output,
        invoke("explain", "paper/slide", *SMALL, *bad, "--time-limit", 2).output,
    ]
    for text in said:
        assert re.search(
            r"(optimal|infeasible|exists|none exists) on the (scenario's )?lattice", text
        )


def test_spent_budget_ends_with_4_and_writes_the_file(tmp_path: Path) -> None:
    """A budget spent without a plan: exit code 4, a bound in the file."""
    path = tmp_path / "plan.json"
    result = invoke("plan", "paper/slide", *SMALL, "--max-iterations", 1, "-o", path)
    assert result.exit_code == 4, result.output
    plan = json.loads(path.read_text())
    assert plan["status"] == "budget"
    assert plan["lower_bound"] >= 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plan"], "SCENARIO"),
        (["plan", "paper/slide", "--bogus"], "--bogus"),
        (["plan", "paper/slide", "--time-limit", "soon"], "--time-limit"),
        (["plan", "paper/slide", "--max-iterations", "1.5"], "--max-iterations"),
        (["plan", "paper/slide", "--time-limit", "-1"], "time limit"),
        (["plan", "paper/slide", "--time-limit", "nan"], "time limit"),
        (["plan", "paper/slide", "--max-iterations", "-1"], "max iterations"),
        (["plan", "paper/slide", "--memory-limit", "0"], "memory limit"),
        (["plan", "paper/slide", "--seed", "-1"], "seed"),
        (["plan", "paper/slid"], "paper/slide"),
        (["plan", "no-such-file.yaml"], "no-such-file.yaml"),
        (["plan", "paper/slide", "--planner", "astra"], "astar"),
        (["plan", "paper/slide", "--set", "fingers"], "KEY=VALUE"),
        (["plan", "paper/slide", "--set", "fingers.cuont=1"], "count"),
        (["plan", "paper/slide", "--params", "no-such-file.json"], "no-such-file.json"),
        (["plan", "paper/slide", "-o", "no-such-folder/plan.json"], "no-such-folder"),
        (["plan", "paper/slide", "-o", "/"], "is a folder"),
        (["check", "no-such-file.json"], "no-such-file.json"),
        (["chekc", "plan.json"], "chekc"),
    ],
)
def test_bad_input_ends_with_2_and_says_what_is_wrong(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bad input: exit code 2, a message on stderr that names the thing, nothing written."""
    monkeypatch.chdir(tmp_path)
    output = [] if "-o" in arguments or arguments[0] != "plan" else ["-o", "plan.json"]
    result = invoke(*arguments, *output)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_a_folder_without_permission_is_refused_before_planning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """-o into a folder that cannot be written: exit code 2 before anything is planned."""
    monkeypatch.setattr(os, "access", lambda path, _: Path(path) != tmp_path)
    monkeypatch.setattr(gm_ompl, "plan", None)
    result = invoke("plan", "paper/slide", "-o", tmp_path / "plan.json")
    assert result.exit_code == 2
    assert "not writable" in result.stderr


@pytest.mark.parametrize(
    ("text", "message"),
    [("[1, 2]", "object"), ("{", "JSON"), ('{"no_such_parameter": 1}', "no_such_parameter")],
)
def test_wrong_parameters_are_refused(text: str, message: str, tmp_path: Path) -> None:
    """--params takes one JSON object of the planner's own parameters."""
    path = tmp_path / "params.json"
    path.write_text(text)
    result = invoke("plan", "paper/slide", "--params", path)
    assert result.exit_code == 2
    assert message in result.stderr


def test_errors_under_json_are_one_object(tmp_path: Path) -> None:
    """With --json an error, too, is one JSON object on stdout, its message also on stderr."""
    result = invoke("check", tmp_path / "missing.json", "--json")
    error = json.loads(result.stdout)
    assert (result.exit_code, error["exit_code"]) == (2, 2)
    assert error["error"] in result.stderr


def test_a_bug_ends_with_1_in_one_line_and_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An unexpected exception: exit code 1, one line that tells how to see more."""

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division\nby zero")

    monkeypatch.setattr(gm_ompl, "plan", broken)
    arguments = ["plan", "paper/slide", "-o", str(tmp_path / "plan.json")]
    result = invoke(*arguments)
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1
    assert "ZeroDivisionError: division by zero" in result.stderr
    assert "--traceback" in result.stderr
    assert list(tmp_path.iterdir()) == []
    assert "in broken" in invoke("--traceback", *arguments).stderr


def test_ctrl_c_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt outside the search ends with 130 and no traceback."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(gm_ompl, "load", interrupted)
    result = invoke("plan", "paper/slide")
    assert result.exit_code == 130
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_search_writes_what_is_known(
    kind: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C, or a request to terminate, during the search: 130, and the file says so."""
    real = api.plan

    def interrupting(*args: Any, **kwargs: Any) -> Plan:
        return real(*args, **{**kwargs, "report": lambda _: signal.raise_signal(kind)})

    monkeypatch.setattr(gm_ompl, "plan", interrupting)
    path = tmp_path / "plan.json"
    monkeypatch.setattr(sys, "argv", ["gm-ompl", "plan", "paper/slide", *SMALL, "-o", str(path)])
    before = signal.getsignal(signal.SIGTERM)
    try:
        code = program()
    finally:
        signal.signal(signal.SIGTERM, before)
    assert code == 130
    assert json.loads(path.read_text())["status"] == "interrupted"


def test_an_interrupt_before_the_search_leaves_a_plan_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the judge is made, or something is compiled: 130, and the file says so."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(asking, "Judge", interrupted)
    path = tmp_path / "plan.json"
    assert invoke("plan", "paper/slide", *SMALL, "-o", str(path)).exit_code == 130
    assert json.loads(path.read_text())["status"] == "interrupted"


def test_version_is_printed() -> None:
    """``--version`` prints the package's version."""
    import gm_ompl

    assert invoke("--version").stdout.strip() == f"gm-ompl {gm_ompl.__version__}"


def test_scenario_in_the_plan_plans_the_same(small_plan: Path, tmp_path: Path) -> None:
    """The scenario stored in a plan, saved as YAML, gives the same plan."""
    plan = json.loads(small_plan.read_text())
    scenario = tmp_path / "again.yaml"
    scenario.write_text(yaml.safe_dump(plan["scenario"]))
    again = json.loads(invoke("plan", scenario, "--json").stdout)
    assert again["steps"] == plan["steps"]
    assert again["scenario"] == plan["scenario"]


def test_module_and_command_are_the_same_program(tmp_path: Path) -> None:
    """``python -m gm_ompl`` is the command; a closed pipe ends it without a traceback."""
    command = [sys.executable, "-P", "-m", "gm_ompl", "list"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=tmp_path)
    assert result.returncode == 0
    assert "paper/slide" in result.stdout
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert "Traceback" not in process.stderr.read()
