"""What every verb takes: its options and its help, in the order of ``--help``.

A dataclass per verb, which ``options.command`` makes a command of.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from gm_ompl.app.options import argument, option

AsJson = Annotated[bool, option("Print one JSON object and nothing else.", None, "--json")]
Scenario = Annotated[str, argument("A shipped name, or a file.", "SCENARIO")]
Scenarios = Annotated[list[str], argument("Shipped names, or files.", "SCENARIO...")]
Overrides = Annotated[
    list[str] | None,
    option("Replace a value of the scenario; may be repeated.", "KEY=VALUE", "--set"),
]
Executor = Annotated[str, option("Where runs are made: local, or dask://HOST:PORT.", "WHERE")]
Speed = Annotated[float, option("The fastest vertex's speed, object sizes per s.", "V")]
PlanFile = Annotated[Path, argument("A plan, as plan -o writes it.", "PLAN.json")]


@dataclass(frozen=True)
class ListVerb:
    """List the shipped scenarios."""

    as_json: AsJson = False


@dataclass(frozen=True)
class PlanVerb:
    """Plan a scenario.

    Exit codes: 0 solved, 2 bad input, 3 proven infeasible on the scenario's lattice, 4 budget
    spent without a plan, 130 interrupted.
    """

    scenario: Scenario
    planner: Annotated[str, option("The planner's name.")] = "astar"
    time_limit: Annotated[float | None, option("Stop after this many seconds.", "S")] = None
    max_iterations: Annotated[
        int | None, option("Stop after this many iterations (node expansions).", "N")
    ] = None
    memory_limit: Annotated[
        float | None, option("Stop when the process uses this much memory.", "MB")
    ] = None
    seed: Annotated[int, option("Seed of randomised planners.", "N")] = 0
    params: Annotated[Path | None, option("The planner's parameters, JSON or YAML.", "FILE")] = None
    overrides: Overrides = None
    output: Annotated[
        Path | None, option("Write the plan there.", "PLAN.json", "--output", "-o")
    ] = None
    html: Annotated[Path | None, option("Write a page there that shows the plan.", "VIEW.html")] = (
        None
    )
    trace: Annotated[
        Path | None, option("Keep there what the search did, for pictures.", "FILE")
    ] = None
    as_json: AsJson = False


@dataclass(frozen=True)
class ExplainVerb:
    """Say why there is no plan on the lattice, or none through there.

    What is suggested has been judged again. Of many sets of placements some are drawn at random.
    """

    scenario: Scenario
    at: Annotated[str | None, option("Only there: 0 to 1 along a path, or X,Y,YAW.", "S")] = None
    placements: Annotated[
        str | None, option("Only these, one per finger; CELL is i.j or [i,j].", "FACE:CELL,...")
    ] = None
    samples: Annotated[int | None, option("Sets of placements judged at most.", "N", min=1)] = None
    seed: Annotated[int, option("Seed of the sampling.", "N", min=0)] = 0
    time_limit: Annotated[float, option("For all of it; 0: without any search.", "S", min=0)] = 30.0
    memory_limit: Annotated[
        float | None, option("Stop when the process uses this much memory.", "MB", min=1)
    ] = None
    overrides: Overrides = None
    as_json: AsJson = False


@dataclass(frozen=True)
class CheckVerb:
    """Judge a saved plan anew.

    Only the scenario inside the file is trusted. Exit codes: 0 it holds, 2 bad input, 5 it does
    not hold.
    """

    plan_file: PlanFile
    as_json: AsJson = False


@dataclass(frozen=True)
class ViewVerb:
    """Show a plan in the browser, in meshcat's viewer.

    The address it says can be reached from this machine alone; Ctrl-C ends.
    """

    plan_file: PlanFile
    html: Annotated[
        Path | None, option("Write one stand-alone page instead of serving it.", "FILE")
    ] = None
    port: Annotated[int, option("Port; 0 takes any free one.", "N", min=0, max=65535)] = 0


@dataclass(frozen=True)
class PlotVerb:
    """Draw a plan: its forces, its decisive moments, or its search."""

    plan_file: PlanFile
    output: Annotated[Path, option("Where: .png, .svg or .pdf.", "FILE", "--output", "-o")]
    show: Annotated[
        str, option("forces (with modes, z and travel), snapshots, or search.", "WHAT")
    ] = "forces"
    trace: Annotated[Path | None, option("What plan --trace kept, for --show search.", "FILE")] = (
        None
    )


@dataclass(frozen=True)
class ExportVerb:
    """Write timed poses, control modes and commanded forces for a controller."""

    plan_file: PlanFile
    output: Annotated[Path, option("Where to write it.", "FILE.csv", "--output", "-o")]
    speed: Speed = 0.3
    rate: Annotated[float, option("Rows per second.", "HZ")] = 100.0


@dataclass(frozen=True)
class ExecuteVerb:
    """Play a plan back in a physics simulation.

    Exit codes: 0 it holds, 2 bad input or MuJoCo missing, 5 it does not hold, or fewer than 95% of
    the trials do.
    """

    plan_file: PlanFile
    seed: Annotated[int, option("Seed of all trials.", "N", min=0)] = 0
    probe: Annotated[
        int, option("Pulses where and in the direction in which z is weakest.", "N", min=0)
    ] = 5
    disturb: Annotated[
        float | None, option("Put pulses of this fraction of z on it as well.", "FRACTION")
    ] = None
    largest: Annotated[
        int | None, option("Find the largest pulse withstood at N times.", "N", min=1)
    ] = None
    vary: Annotated[
        float | None, option("Execute it in worlds that are off by this, too.", "PERCENT")
    ] = None
    trials: Annotated[int, option("Pulses of --disturb, or worlds of --vary.", "N", min=1)] = 20
    speed: Speed = 0.3
    lean: Annotated[
        bool,
        option(
            "Whether fingers lean on the object with the forces of a balance, or hold positions "
            "and commanded normal forces alone."
        ),
    ] = True
    video: Annotated[Path | None, option("Write a film: .mp4 or .gif.", "FILE")] = None
    plot: Annotated[
        Path | None, option("Draw measured and planned forces: .png, .svg or .pdf.", "FILE")
    ] = None
    as_json: AsJson = False


@dataclass(frozen=True)
class CompareVerb:
    """Compare planners on scenarios; a second call goes on where the first was stopped.

    Every run has a process of its own. Writes runs.sqlite, runs.parquet, report.html, and OMPL's
    benchmark logs and database. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: Scenarios
    planners: Annotated[str, option("Planners; the others are set against the first.", "A,B,...")]
    seeds: Annotated[int, option("Runs per scenario and randomised planner.", "N", min=1)] = 20
    time_limit: Annotated[float, option("Of each run, in seconds.", "S")] = 5.0
    memory_limit: Annotated[float | None, option("Of each run's process.", "MB")] = None
    max_iterations: Annotated[int | None, option("Of each run.", "M")] = None
    executor: Executor = "local"
    output: Annotated[Path, option("Folder of runs and reports.", "DIR", "--output", "-o")] = Path(
        "comparison"
    )


@dataclass(frozen=True)
class TuneVerb:
    """Tune a planner's parameters; a second call goes on where the first was stopped.

    The winner is scored against the defaults on scenarios held out. Beside PARAMS a folder named
    after it keeps runs, trials and report.html. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: Scenarios
    planner: Annotated[str, option("The planner to tune.", "NAME")]
    trials: Annotated[int, option("Trials in all.", "N", min=1)]
    hold_out: Annotated[
        list[str] | None,
        option("Score the winner on this; repeat. Default: every third.", "SCENARIO"),
    ] = None
    objective: Annotated[
        str,
        option(
            "Make small: decisions (mode decisions to the first plan), time (to it), cost, or "
            "both (decisions and cost).",
            "WHAT",
        ),
    ] = "decisions"
    seeds: Annotated[int, option("Runs per scenario and trial.", "N", min=1)] = 3
    max_iterations: Annotated[int | None, option("Of each run.", "M")] = 2000
    time_limit: Annotated[float | None, option("Of each run, in seconds.", "S")] = None
    seed: Annotated[int, option("Of the search.", "N", min=0)] = 0
    executor: Executor = "local"
    output: Annotated[Path, option("File for plan --params.", "PARAMS", "--output", "-o")] = Path(
        "tuned.json"
    )


@dataclass(frozen=True)
class BenchVerb:
    """Measure the project's own speed, as ratios in one run (about two minutes)."""

    scenario: Annotated[
        list[str] | None, option("Measure this one; may be repeated.", "SCENARIO")
    ] = None
    repeat: Annotated[int, option("Repetitions of what is short.", "N")] = 5
    highs: Annotated[int, option("Decisions per search that HiGHS makes, too.", "N")] = 20
    search_limit: Annotated[float, option("Wall time of each search measured.", "S")] = 10.0
    overrides: Overrides = None
    as_json: AsJson = False


@dataclass(frozen=True)
class InspectVerb:
    """Show a mesh, or a scenario's object: size, mass, how it can lie, pieces, faces.

    For a mesh, --set takes the keys that stand beside mesh: in a scenario, as in
    --set scale=0.001 --set convex=hull. Mass properties are those of uniform density; a mesh has
    mass 1.
    """

    mesh: Annotated[str, argument("A mesh file, or a scenario.", "MESH")]
    overrides: Overrides = None
    html: Annotated[Path | None, option("Write a stand-alone page that shows it.", "FILE")] = None
    time_limit: Annotated[float | None, option("Stop after this many seconds.", "S", min=0)] = None
    memory_limit: Annotated[
        float | None, option("Stop when the process uses this much memory.", "MB", min=1)
    ] = None
    as_json: AsJson = False


VERBS = {
    "list": (ListVerb, ".showing:list_command"),
    "plan": (PlanVerb, ".planning:plan_command"),
    "explain": (ExplainVerb, ".explaining:explain_command"),
    "check": (CheckVerb, ".showing:check_command"),
    "view": (ViewVerb, ".showing:view_command"),
    "plot": (PlotVerb, ".showing:plot_command"),
    "export": (ExportVerb, ".showing:export_command"),
    "inspect": (InspectVerb, ".inspecting:inspect_command"),
    "execute": (ExecuteVerb, ".executing:execute_command"),
    "compare": (CompareVerb, ".comparing:compare_command"),
    "tune": (TuneVerb, ".tuning:tune_command"),
    "bench": (BenchVerb, ".benching:bench_command"),
}
"""In the order of ``--help``: what a verb takes, and who carries it out."""
