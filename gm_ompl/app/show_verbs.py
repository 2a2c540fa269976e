"""The options of the verbs that show: view, plot, export, execute a plan; inspect a shape."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from gm_ompl.app.options import AsJson, Overrides, Speed


@dataclass(frozen=True)
class ViewVerb:
    """Show a plan in the browser, in meshcat's viewer.

    The address it says can be reached from this machine alone; Ctrl-C ends.
    """

    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to show.")]
    html: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write one stand-alone page instead of serving it."),
    ] = None
    port: Annotated[
        int, typer.Option(metavar="N", min=0, max=65535, help="Port; 0 takes any free one.")
    ] = 0


@dataclass(frozen=True)
class PlotVerb:
    """Draw a plan: its forces, its decisive moments, or its search."""

    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to draw.")]
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="Where: .png, .svg or .pdf."),
    ]
    show: Annotated[
        str,
        typer.Option(
            metavar="WHAT",
            help="forces (with modes, z and travel), snapshots, or search.",
        ),
    ] = "forces"
    trace: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What plan --trace kept, for --show search."),
    ] = None


@dataclass(frozen=True)
class ExportVerb:
    """Write timed poses, control modes and commanded forces for a controller."""

    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to export.")]
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE.csv", help="Where to write it.")
    ]
    speed: Speed = 0.3
    rate: Annotated[float, typer.Option(metavar="HZ", help="Rows per second.")] = 100.0


@dataclass(frozen=True)
class ExecuteVerb:
    """Play a plan back in a physics simulation.

    Exit codes: 0 it holds, 2 bad input or MuJoCo missing, 5 it does not hold, or fewer than 95% of
    the trials do.
    """

    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to execute.")]
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of all trials.")] = 0
    probe: Annotated[
        int,
        typer.Option(metavar="N", help="Pulses where and in the direction in which z is weakest."),
    ] = 5
    disturb: Annotated[
        float | None,
        typer.Option(metavar="FRACTION", help="Put pulses of this fraction of z on it as well."),
    ] = None
    largest: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Find the largest pulse withstood at N times."),
    ] = None
    vary: Annotated[
        float | None,
        typer.Option(metavar="PERCENT", help="Execute it in worlds that are off by this, too."),
    ] = None
    trials: Annotated[
        int, typer.Option(metavar="N", help="Pulses of --disturb, or worlds of --vary.")
    ] = 20
    speed: Speed = 0.3
    lean: Annotated[
        bool,
        typer.Option(
            help="Whether fingers lean on the object with the forces of a balance, or hold "
            "positions and commanded normal forces alone."
        ),
    ] = True
    video: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a film: .mp4 or .gif.")
    ] = None
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw measured and planned forces: .png, .svg or .pdf."),
    ] = None
    as_json: AsJson = False


@dataclass(frozen=True)
class InspectVerb:
    """Show a mesh, or a scenario's object: size, mass, how it can lie, pieces, faces.

    For a mesh, --set takes the keys that stand beside mesh: in a scenario, as in
    --set scale=0.001 --set convex=hull. Mass properties are those of uniform density; a mesh has
    mass 1.
    """

    mesh: Annotated[str, typer.Argument(metavar="MESH", help="A mesh file, or a scenario.")]
    overrides: Overrides = None
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a stand-alone page that shows it.")
    ] = None
    as_json: AsJson = False
