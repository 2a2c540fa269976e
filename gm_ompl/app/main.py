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
        typer.Option(metavar="FILE", help="The planner's parameters, a JSON object."),
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
        as_json=as_json,
    )
    return plan_command(request)


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
