"""The verbs that show and play a saved plan: view, plot, export, execute.

What a verb needs is imported inside it, so that ``--help`` answers at once.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gm_ompl.app.exits import Exit, guarded
from gm_ompl.app.options import AsJson


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


@guarded
def execute(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to execute.")],
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of all trials.")] = 0,
    probe: Annotated[
        int,
        typer.Option(metavar="N", help="Pulses where and in the direction in which z is weakest."),
    ] = 5,
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
        probe=probe,
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
