"""``gm-ompl``: the verbs and their options.

Only the standard library and typer are imported here: what a verb needs is imported inside it, so
that ``--help`` answers at once.
"""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from gm_ompl import __version__
from gm_ompl.app.exits import TRACEBACK_VARIABLE, Exit, Switches, guarded
from gm_ompl.app.output import show_log

app = typer.Typer(
    name="gm-ompl",
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,  # one plain message for a usage error, and a quicker start
    pretty_exceptions_enable=False,  # exceptions are dealt with in exits.py
    help="Plans graspless manipulation by multifingered robot hands, and checks plans.",
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"gm-ompl {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show the version."),
    ] = False,
    traceback: Annotated[
        bool,
        typer.Option(
            "--traceback", envvar=TRACEBACK_VARIABLE, help="Show where an error came from."
        ),
    ] = False,
) -> None:
    """Options that stand before the verb."""
    del version  # dealt with by its callback
    Switches.show_traceback = traceback
    show_log()


AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


@app.command("list")
@guarded
def list_scenarios(as_json: AsJson = False) -> Exit:
    """List the shipped scenarios."""
    from gm_ompl.app.listing import list_command

    return list_command(as_json)


@app.command("plan")
@guarded
def plan(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A shipped name, or a file.")],
    planner: Annotated[str, typer.Option(help="The planner's name.")] = "astar",
    time_limit: Annotated[
        float | None,
        typer.Option(metavar="S", help="Stop after this many seconds."),
    ] = None,
    max_iterations: Annotated[
        int | None,
        typer.Option(metavar="N", help="Stop after this many iterations (node expansions)."),
    ] = None,
    memory_limit: Annotated[
        float | None,
        typer.Option(metavar="MB", help="Stop when the process uses this much memory."),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of randomised planners.")] = 0,
    params: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The planner's parameters, JSON or YAML."),
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Replace a value of the scenario; may be repeated."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PLAN.json", help="Write the plan there."),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(metavar="VIEW.html", help="Write a page there that shows the plan."),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep there what the search did, for pictures."),
    ] = None,
    as_json: AsJson = False,
) -> Exit:
    """Plan a scenario.

    Exit codes: 0 solved, 2 bad input, 3 proven infeasible, 4 budget spent without a plan,
    130 interrupted.
    """
    from gm_ompl.app.planning import PlanRequest, plan_command

    request = PlanRequest(
        scenario=scenario,
        planner=planner,
        time_limit=time_limit,
        max_iterations=max_iterations,
        memory_limit=memory_limit,
        seed=seed,
        params=params,
        overrides=tuple(overrides or ()),
        output=output,
        html=html,
        trace=trace,
        as_json=as_json,
    )
    return plan_command(request)


@app.command("explain")
@guarded
def explain(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A shipped name, or a file.")],
    at: Annotated[
        str | None,
        typer.Option(metavar="S", help="Only there: 0 to 1 along a path, or X,Y,YAW."),
    ] = None,
    placements: Annotated[
        str | None,
        typer.Option(
            metavar="FACE:CELL,...", help="Only these, one per finger; CELL is i.j or [i,j]."
        ),
    ] = None,
    samples: Annotated[
        int | None, typer.Option(metavar="N", help="Sets of placements judged at most.", min=1)
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the sampling.", min=0)] = 0,
    time_limit: Annotated[
        float,
        typer.Option(metavar="S", help="For the search that says whether there is a plan.", min=0),
    ] = 20.0,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Replace a value of the scenario; may be repeated."
        ),
    ] = None,
    as_json: AsJson = False,
) -> Exit:
    """Say why there is no plan, or none through there.

    What is suggested has been judged again. Of many sets of placements some are drawn at random.
    """
    from gm_ompl.app.explaining import ExplainRequest, explain_command

    request = ExplainRequest(
        scenario=scenario,
        at=at,
        placements=placements,
        samples=samples,
        seed=seed,
        time_limit=time_limit,
        overrides=tuple(overrides or ()),
        as_json=as_json,
    )
    return explain_command(request)


@app.command("check")
@guarded
def check(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to judge.")],
    as_json: AsJson = False,
) -> Exit:
    """Judge a saved plan anew.

    Only the scenario inside the file is trusted. Exit codes: 0 it holds, 2 bad input, 5 it does
    not hold.
    """
    from gm_ompl.app.checking import check_command

    return check_command(plan_file, as_json)


@app.command("view")
@guarded
def view(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to show.")],
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write one stand-alone page instead of serving it."),
    ] = None,
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="Port; 0 takes any free one.")
    ] = 0,
) -> Exit:
    """Show a plan in the browser, in meshcat's viewer.

    The address it says can be reached from this machine alone; Ctrl-C ends.
    """
    from gm_ompl.app.viewing import view_command

    return view_command(plan_file, html, port)


@app.command("plot")
@guarded
def plot(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to draw.")],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="Where: .png, .svg or .pdf."),
    ],
    show: Annotated[
        str,
        typer.Option(
            metavar="WHAT",
            help="forces (with modes, z and travel), snapshots, or search.",
        ),
    ] = "forces",
    trace: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What plan --trace kept, for --show search."),
    ] = None,
) -> Exit:
    """Draw a plan: its forces, its decisive moments, or its search."""
    from gm_ompl.app.plotting import plot_command

    return plot_command(plan_file, output, show, trace)


@app.command("export")
@guarded
def export(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to export.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE.csv", help="Where to write it.")
    ],
    speed: Annotated[
        float, typer.Option(metavar="V", help="The fastest vertex's speed, object sizes per s.")
    ] = 0.3,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Rows per second.")] = 100.0,
) -> Exit:
    """Write timed poses, control modes and commanded forces for a controller."""
    from gm_ompl.app.exporting import export_command

    return export_command(plan_file, output, speed, rate)


@app.command("execute")
@guarded
def execute(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to execute.")],
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of all trials.")] = 0,
    disturb: Annotated[
        float | None,
        typer.Option(metavar="FRACTION", help="Put pulses of this fraction of z on it as well."),
    ] = None,
    largest: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Find the largest pulse withstood at N times."),
    ] = None,
    vary: Annotated[
        float | None,
        typer.Option(metavar="PERCENT", help="Execute it in worlds that are off by this, too."),
    ] = None,
    trials: Annotated[
        int, typer.Option(metavar="N", help="Pulses of --disturb, or worlds of --vary.")
    ] = 20,
    speed: Annotated[
        float, typer.Option(metavar="V", help="The fastest vertex's speed, object sizes per s.")
    ] = 0.3,
    lean: Annotated[
        bool,
        typer.Option(
            help="Whether fingers lean on the object with the forces of a balance, or hold "
            "positions and commanded normal forces alone."
        ),
    ] = True,
    video: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a film: .mp4 or .gif.")
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw measured and planned forces: .png, .svg or .pdf."),
    ] = None,
    as_json: AsJson = False,
) -> Exit:
    """Play a plan back in a physics simulation.

    Exit codes: 0 it holds, 2 bad input or MuJoCo missing, 5 it does not hold, or fewer than 95% of
    the trials do.
    """
    from gm_ompl.app.executing import ExecuteRequest, execute_command

    request = ExecuteRequest(
        plan_file=plan_file,
        seed=seed,
        disturb=disturb,
        largest=largest,
        vary=vary,
        trials=trials,
        speed=speed,
        lean=lean,
        video=video,
        plot=plot,
        as_json=as_json,
    )
    return execute_command(request)


@app.command("compare")
@guarded
def compare(
    scenarios: Annotated[
        list[str], typer.Argument(metavar="SCENARIO...", help="Shipped names, or files.")
    ],
    planners: Annotated[
        str, typer.Option(metavar="A,B,...", help="Planners; the others are set against the first.")
    ],
    seeds: Annotated[
        int, typer.Option(metavar="N", min=1, help="Runs per scenario and randomised planner.")
    ] = 20,
    time_limit: Annotated[float, typer.Option(metavar="S", help="Of each run, in seconds.")] = 5.0,
    memory_limit: Annotated[
        float | None, typer.Option(metavar="MB", help="Of each run's process.")
    ] = None,
    max_iterations: Annotated[int | None, typer.Option(metavar="M", help="Of each run.")] = None,
    executor: Annotated[
        str, typer.Option(metavar="WHERE", help="Where runs are made: local.")
    ] = "local",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of runs and reports.")
    ] = Path("comparison"),
) -> Exit:
    """Compare planners on scenarios; a second call goes on where the first was stopped.

    Every run has a process of its own. Writes runs.sqlite, report.html, and OMPL's benchmark logs
    and database. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """
    from gm_ompl.app.comparing import CompareRequest, compare_command

    request = CompareRequest(
        scenarios=tuple(scenarios),
        planners=planners,
        seeds=seeds,
        time_limit=time_limit,
        memory_limit=memory_limit,
        max_iterations=max_iterations,
        executor=executor,
        output=output,
    )
    return compare_command(request)


@app.command("bench")
@guarded
def bench(
    scenario: Annotated[
        list[str] | None,
        typer.Option(metavar="SCENARIO", help="Measure this one; may be repeated."),
    ] = None,
    repeat: Annotated[int, typer.Option(metavar="N", help="Repetitions of what is short.")] = 5,
    highs: Annotated[
        int, typer.Option(metavar="N", help="Decisions per search that HiGHS makes, too.")
    ] = 12,
    search_limit: Annotated[
        float, typer.Option(metavar="S", help="Wall time of each search measured.")
    ] = 10.0,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Replace a value of every scenario; may be repeated."
        ),
    ] = None,
    as_json: AsJson = False,
) -> Exit:
    """Measure the project's own speed, as ratios in one run (about two minutes)."""
    from gm_ompl.app.benching import BenchRequest, bench_command

    request = BenchRequest(
        scenarios=tuple(scenario or ()),
        repeat=repeat,
        highs=highs,
        search_limit=search_limit,
        overrides=tuple(overrides or ()),
        as_json=as_json,
    )
    return bench_command(request)


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    """Treat a request to terminate like Ctrl-C: what is known is kept."""
    raise KeyboardInterrupt


def run() -> None:
    """Entry point of the command ``gm-ompl``."""
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        app(prog_name="gm-ompl")
    except KeyboardInterrupt:
        sys.exit(int(Exit.INTERRUPTED))
