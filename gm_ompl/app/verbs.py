"""What every verb takes: its options and its help, in the order of ``--help``.

A dataclass per verb, which ``commands.command`` makes a command of.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from gm_ompl.app.commands import argument, option

_as_json = partial(option, False, "Print one JSON object and nothing else.", None, "--json")
_scenario = partial(argument, "A shipped name, or a file.", "SCENARIO")
_scenarios = partial(argument, "Shipped names, or files.", "SCENARIO...")
_changes = partial(
    option, None, "Replace a value of the scenario; may be repeated.", "KEY=VALUE", "--set"
)
_executor = partial(option, "local", "Where runs are made: local, or dask://HOST:PORT.", "WHERE")
_speed = partial(option, 0.3, "The fastest vertex's speed, object sizes per s.", "V")
_plan_file = partial(argument, "A plan, as plan -o writes it.", "PLAN.json")


def _output(default: Any, text: str, metavar: str) -> Any:
    return option(default, text, metavar, "--output", "-o")


@dataclass(frozen=True)
class ListVerb:
    """List the shipped scenarios."""

    as_json: bool = _as_json()


@dataclass(frozen=True)
class PlanVerb:
    """Plan a scenario.

    Exit codes: 0 solved, 2 bad input, 3 proven infeasible on the scenario's lattice, 4 budget
    spent without a plan, 130 interrupted.
    """

    scenario: str = _scenario()
    planner: str = option("astar", "The planner's name.")
    time_limit: float | None = option(None, "Stop after this many seconds.", "S")
    max_iterations: int | None = option(
        None, "Stop after this many iterations (node expansions).", "N"
    )
    memory_limit: float | None = option(None, "Stop when the process uses this much memory.", "MB")
    seed: int = option(0, "Seed of randomised planners.", "N")
    params: Path | None = option(None, "The planner's parameters, JSON or YAML.", "FILE")
    overrides: list[str] | None = _changes()
    output: Path | None = _output(None, "Write the plan there.", "PLAN.json")
    html: Path | None = option(None, "Write a page there that shows the plan.", "VIEW.html")
    trace: Path | None = option(None, "Keep there what the search did, for pictures.", "FILE")
    as_json: bool = _as_json()


@dataclass(frozen=True)
class ExplainVerb:
    """Say why there is no plan on the lattice, or none through there.

    What is suggested has been judged again. Of many sets of placements some are drawn at random.
    """

    scenario: str = _scenario()
    at: str | None = option(None, "Only there: 0 to 1 along a path, or X,Y,YAW.", "S")
    placements: str | None = option(
        None, "Only these, one per finger; CELL is i.j or [i,j].", "FACE:CELL,..."
    )
    samples: int | None = option(None, "Sets of placements judged at most.", "N", min=1)
    seed: int = option(0, "Seed of the sampling.", "N", min=0)
    time_limit: float = option(30.0, "For all of it; 0: without any search.", "S", min=0)
    memory_limit: float | None = option(
        None, "Stop when the process uses this much memory.", "MB", min=1
    )
    overrides: list[str] | None = _changes()
    as_json: bool = _as_json()


@dataclass(frozen=True)
class CheckVerb:
    """Judge a saved plan anew.

    Only the scenario inside the file is trusted. Exit codes: 0 it holds, 2 bad input, 5 it does
    not hold.
    """

    plan_file: Path = _plan_file()
    as_json: bool = _as_json()


@dataclass(frozen=True)
class ViewVerb:
    """Show a plan in the browser, in meshcat's viewer.

    The address it says can be reached from this machine alone; Ctrl-C ends.
    """

    plan_file: Path = _plan_file()
    html: Path | None = option(None, "Write one stand-alone page instead of serving it.", "FILE")
    port: int = option(0, "Port; 0 takes any free one.", "N", min=0, max=65535)


@dataclass(frozen=True)
class PlotVerb:
    """Draw a plan: its forces, its decisive moments, or its search."""

    plan_file: Path = _plan_file()
    output: Path = _output(..., "Where: .png, .svg or .pdf.", "FILE")
    show: str = option("forces", "forces (with modes, z and travel), snapshots, or search.", "WHAT")
    trace: Path | None = option(None, "What plan --trace kept, for --show search.", "FILE")


@dataclass(frozen=True)
class ExportVerb:
    """Write timed poses, control modes and commanded forces for a controller."""

    plan_file: Path = _plan_file()
    output: Path = _output(..., "Where to write it.", "FILE.csv")
    speed: float = _speed()
    rate: float = option(100.0, "Rows per second.", "HZ")


@dataclass(frozen=True)
class ExecuteVerb:
    """Play a plan back in a physics simulation.

    Exit codes: 0 it holds, 2 bad input or MuJoCo missing, 5 it does not hold, or fewer than 95% of
    the trials do.
    """

    plan_file: Path = _plan_file()
    seed: int = option(0, "Seed of all trials.", "N", min=0)
    probe: int = option(5, "Pulses where and in the direction in which z is weakest.", "N", min=0)
    disturb: float | None = option(
        None, "Put pulses of this fraction of z on it as well.", "FRACTION"
    )
    largest: int | None = option(None, "Find the largest pulse withstood at N times.", "N", min=1)
    vary: float | None = option(None, "Execute it in worlds that are off by this, too.", "PERCENT")
    trials: int = option(20, "Pulses of --disturb, or worlds of --vary.", "N", min=1)
    speed: float = _speed()
    lean: bool = option(
        True,
        "Whether fingers lean on the object with the forces of a balance, or hold positions "
        "and commanded normal forces alone.",
    )
    video: Path | None = option(None, "Write a film: .mp4 or .gif.", "FILE")
    plot: Path | None = option(
        None, "Draw measured and planned forces: .png, .svg or .pdf.", "FILE"
    )
    as_json: bool = _as_json()


@dataclass(frozen=True)
class CompareVerb:
    """Compare planners on scenarios; a second call goes on where the first was stopped.

    Every run has a process of its own. Writes runs.sqlite, runs.parquet, report.html, and OMPL's
    benchmark logs and database. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: list[str] = _scenarios()
    planners: str = option(..., "Planners; the others are set against the first.", "A,B,...")
    seeds: int = option(20, "Runs per scenario and randomised planner.", "N", min=1)
    time_limit: float = option(5.0, "Of each run, in seconds.", "S")
    memory_limit: float | None = option(None, "Of each run's process.", "MB")
    max_iterations: int | None = option(None, "Of each run.", "M")
    executor: str = _executor()
    output: Path = _output(Path("comparison"), "Folder of runs and reports.", "DIR")


@dataclass(frozen=True)
class TuneVerb:
    """Tune a planner's parameters; a second call goes on where the first was stopped.

    The winner is scored against the defaults on scenarios held out. Beside PARAMS a folder named
    after it keeps runs, trials and report.html. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: list[str] = _scenarios()
    planner: str = option(..., "The planner to tune.", "NAME")
    trials: int = option(..., "Trials in all.", "N", min=1)
    hold_out: list[str] | None = option(
        None, "Score the winner on this; repeat. Default: every third.", "SCENARIO"
    )
    objective: str = option(
        "decisions",
        "Make small: decisions (mode decisions to the first plan), time (to it), cost, or "
        "both (decisions and cost).",
        "WHAT",
    )
    seeds: int = option(3, "Runs per scenario and trial.", "N", min=1)
    max_iterations: int | None = option(2000, "Of each run.", "M")
    time_limit: float | None = option(None, "Of each run, in seconds.", "S")
    seed: int = option(0, "Of the search.", "N", min=0)
    executor: str = _executor()
    output: Path = _output(Path("tuned.json"), "File for plan --params.", "PARAMS")


@dataclass(frozen=True)
class BenchVerb:
    """Measure the project's own speed, as ratios in one run (about two minutes)."""

    scenario: list[str] | None = option(None, "Measure this one; may be repeated.", "SCENARIO")
    repeat: int = option(5, "Repetitions of what is short.", "N")
    highs: int = option(20, "Decisions per search that HiGHS makes, too.", "N")
    search_limit: float = option(10.0, "Wall time of each search measured.", "S")
    overrides: list[str] | None = _changes()
    as_json: bool = _as_json()


@dataclass(frozen=True)
class InspectVerb:
    """Show a mesh, or a scenario's object: size, mass, how it can lie, pieces, faces.

    For a mesh, --set takes the keys that stand beside mesh: in a scenario, as in
    --set scale=0.001 --set convex=hull. Mass properties are those of uniform density; a mesh has
    mass 1.
    """

    mesh: str = argument("A mesh file, or a scenario.", "MESH")
    overrides: list[str] | None = _changes()
    html: Path | None = option(None, "Write a stand-alone page that shows it.", "FILE")
    time_limit: float | None = option(None, "Stop after this many seconds.", "S", min=0)
    memory_limit: float | None = option(
        None, "Stop when the process uses this much memory.", "MB", min=1
    )
    as_json: bool = _as_json()


VERBS = {
    "list": (ListVerb, ".showing:list_command"),
    "plan": (PlanVerb, ".planning:plan_command"),
    "explain": (ExplainVerb, ".explaining:explain_command"),
    "check": (CheckVerb, ".showing:check_command"),
    "view": (ViewVerb, ".showing:view_command"),
    "plot": (PlotVerb, ".showing:plot_command"),
    "export": (ExportVerb, ".executing:export_command"),
    "inspect": (InspectVerb, ".inspecting:inspect_command"),
    "execute": (ExecuteVerb, ".executing:execute_command"),
    "compare": (CompareVerb, ".studying:compare_command"),
    "tune": (TuneVerb, ".studying:tune_command"),
    "bench": (BenchVerb, ".studying:bench_command"),
}
"""In the order of ``--help``: what a verb takes, and who carries it out."""
