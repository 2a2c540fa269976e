"""What every verb takes: its options and its help, in the order of ``--help``.

A dataclass per verb, which ``commands.command`` makes a command of.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gm_ompl.app.commands import argument, option
from gm_ompl.app.completing import motions, planners
from gm_ompl.app.shared_options import (
    as_json_option,
    changes_option,
    output_option,
    plan_file_option,
    scenario_option,
    speed_option,
)
from gm_ompl.app.study_verbs import BenchVerb, CompareVerb, TuneVerb


@dataclass(frozen=True)
class NewVerb:
    """Write a commented scenario to begin with: a box, or the part in a mesh file.

    On a terminal it asks for what no option says; elsewhere, and with --yes, it takes what suits
    the object's size. What comes out can be planned as it is.
    """

    mesh: str | None = argument("A mesh file: STL, OBJ, PLY, OFF or GLB.", "MESH", None)
    size: str | None = option(None, "Of the box, without a mesh; 5,5,10 by default.", "X,Y,Z")
    mass: float | None = option(None, "Of the object, 1 by default.", "M", min=1e-15)
    fingers: int | None = option(None, "How many, 2 by default.", "N", min=1, max=5)
    motion: str | None = option(
        None, "slide (the default), tumble, planar or free.", "KIND", autocompletion=motions
    )
    overrides: list[str] | None = option(
        None, "A key beside mesh: such as scale=0.001; may be repeated.", "KEY=VALUE", "--set"
    )
    yes: bool = option(False, "Ask nothing.", None, "--yes", "-y")
    output: Path | None = output_option(None, "Write it there instead of to stdout.", "FILE.yaml")


@dataclass(frozen=True)
class ListVerb:
    """List the shipped scenarios."""

    as_json: bool = as_json_option()


@dataclass(frozen=True)
class PlanVerb:
    """Plan a scenario.

    Exit codes: 0 solved, 2 bad input, 3 proven infeasible on the scenario's lattice, 4 budget
    spent without a plan, 130 interrupted.
    """

    scenario: str = scenario_option()
    planner: str = option("astar", "The planner's name.", autocompletion=planners)
    time_limit: float | None = option(None, "Stop after this many seconds.", "S")
    max_iterations: int | None = option(
        None, "Stop after this many iterations (node expansions).", "N"
    )
    memory_limit: float | None = option(None, "Stop when the process uses this much memory.", "MB")
    seed: int = option(0, "Seed of randomised planners.", "N")
    params: Path | None = option(None, "The planner's parameters, JSON or YAML.", "FILE")
    overrides: list[str] | None = changes_option()
    output: Path | None = output_option(None, "Write the plan there; - is stdout.", "PLAN.json")
    html: Path | None = option(None, "Write a page there that shows the plan.", "VIEW.html")
    trace: Path | None = option(None, "Keep there what the search did, for pictures.", "FILE")
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class ExplainVerb:
    """Say why there is no plan on the lattice, or none through there.

    What is suggested has been judged again. Of many sets of placements some are drawn at random.
    """

    scenario: str = scenario_option()
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
    overrides: list[str] | None = changes_option()
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class MapVerb:
    """Map where a finger may go: each placement's best z over all partners, or what blocks.

    Of a scenario at its start, the object moving ahead on a path and at rest elsewhere, or where
    --at says; or of a plan's step, at its segment of least z.
    """

    source: str = argument("A shipped name or a file; with --step, a plan.", "SCENARIO")
    at: str | None = option(None, "There: 0 to 1 along a path, or X,Y,YAW.", "S")
    direction: str | None = option(
        None, "Moving so: 1 or -1 along a path, or DX,DY,DYAW. Default: ahead on a path.", "D"
    )
    rest: bool = option(False, "With the object at rest.", None, "--rest")
    step: int | None = option(None, "At this step of the plan, counted from 0.", "K", min=0)
    finger: int = option(0, "Whose placements are shown.", "I", min=0)
    output: Path | None = output_option(None, "Where: .png, .svg, .pdf, .html or .json.", "FILE")
    overrides: list[str] | None = changes_option()
    time_limit: float | None = option(None, "Stop after this many seconds.", "S", min=0)
    memory_limit: float | None = option(
        None, "Stop when the process uses this much memory.", "MB", min=1
    )
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class CheckVerb:
    """Judge a saved plan anew.

    Only the scenario inside the file is trusted. Exit codes: 0 it holds, 2 bad input, 5 it does
    not hold.
    """

    plan_file: Path = plan_file_option()
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class TolerateVerb:
    """Say how far the world may be off before a plan's modes and forces no longer hold.

    Per quantity an interval, the others nominal, and the largest common factor of the ranges of
    uncertainty. Exit codes: 0 done, 2 bad input, 5 the plan does not hold even as modelled.
    """

    plan_file: Path = plan_file_option()
    overrides: list[str] | None = changes_option()
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class StrongVerb:
    """Say how much of a plan's z holds whatever the contacts do: z_strong, step by step.

    z lets contacts find any balancing forces; z_strong asks under which disturbance they may
    open or slide instead, and says which do.
    """

    plan_file: Path = plan_file_option()
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class ViewVerb:
    """Show a plan in the browser, in meshcat's viewer.

    The address it says can be reached from this machine alone; Ctrl-C ends.
    """

    plan_file: Path = plan_file_option()
    html: Path | None = option(None, "Write one stand-alone page instead of serving it.", "FILE")
    tolerance: bool = option(False, "Find and show what the plan tolerates.", None, "--tolerance")
    port: int = option(0, "Port; 0 takes any free one.", "N", min=0, max=65535)


@dataclass(frozen=True)
class PlotVerb:
    """Draw a plan: its forces, decisive moments, what it tolerates, z_strong, or its search."""

    plan_file: Path = plan_file_option()
    output: Path = output_option(
        ..., "Where: .png, .svg, .pdf, or a film's .gif; - is stdout.", "FILE"
    )
    show: str = option(
        "forces",
        "forces (with modes, z and travel), snapshots, tolerance, strong, search or film.",
        "WHAT",
    )
    trace: Path | None = option(None, "What plan --trace kept, for --show search.", "FILE")


@dataclass(frozen=True)
class ExportVerb:
    """Write timed poses, control modes and commanded forces for a controller."""

    plan_file: Path = plan_file_option()
    output: Path = output_option(..., "Where to write it; - is stdout.", "FILE.csv|FOLDER")
    to: str = option("csv", "csv, or ros2: an MCAP rosbag2 in a new folder.", "FORMAT")
    speed: float = speed_option()
    rate: float = option(100.0, "Rows per second.", "HZ")


@dataclass(frozen=True)
class ExecuteVerb:
    """Play a plan back in a physics simulation.

    Exit codes: 0 it holds, 2 bad input or the engine missing, 5 it does not hold, or fewer than
    95% of the trials do.
    """

    plan_file: Path = plan_file_option()
    seed: int = option(0, "Seed of all trials.", "N", min=0)
    probe: int = option(5, "Pulses where and in the direction in which z is weakest.", "N", min=0)
    disturb: float | None = option(
        None, "Put pulses of this fraction of z on it as well.", "FRACTION"
    )
    largest: int | None = option(None, "Find the largest pulse withstood at N times.", "N", min=1)
    vary: float | None = option(None, "Execute it in worlds that are off by this, too.", "PERCENT")
    trials: int = option(20, "Pulses of --disturb, or worlds of --vary.", "N", min=1)
    speed: float = speed_option()
    engine: str = option("mujoco", "Simulator: mujoco (extra sim) or dart (extra sim2).", "NAME")
    lean: bool = option(
        True,
        "Whether fingers lean on the object with the forces of a balance, or hold positions "
        "and commanded normal forces alone.",
    )
    video: Path | None = option(None, "Write a film: .mp4 or .gif.", "FILE")
    plot: Path | None = option(
        None, "Draw measured and planned forces: .png, .svg or .pdf.", "FILE"
    )
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class InspectVerb:
    """Show a mesh, or a scenario's object: size, mass, how it can lie, pieces, faces.

    For a mesh, --set takes the keys that stand beside mesh: in a scenario, as in
    --set scale=0.001 --set convex=hull. Mass properties are those of uniform density; a mesh has
    mass 1.
    """

    mesh: str = argument("A mesh file, or a scenario.", "MESH")
    overrides: list[str] | None = changes_option()
    html: Path | None = option(None, "Write a stand-alone page that shows it.", "FILE")
    time_limit: float | None = option(None, "Stop after this many seconds.", "S", min=0)
    memory_limit: float | None = option(
        None, "Stop when the process uses this much memory.", "MB", min=1
    )
    as_json: bool = as_json_option()


@dataclass(frozen=True)
class ExploreVerb:
    """Turn a scenario's knobs in the browser and see the plan change.

    The address it says holds a token and can be reached from this machine alone; Ctrl-C ends.
    """

    scenario: str = scenario_option()
    port: int = option(0, "Port; 0 takes any free one.", "N", min=0, max=65535)
    time_limit: float = option(10.0, "Of each search.", "S")
    memory_limit: float | None = option(None, "Of each search's process.", "MB")
    overrides: list[str] | None = changes_option()


VERBS = {
    "new": (NewVerb, ".new:new_command"),
    "list": (ListVerb, ".showing:list_command"),
    "plan": (PlanVerb, ".planning:plan_command"),
    "explain": (ExplainVerb, ".explaining:explain_command"),
    "map": (MapVerb, ".mapping:map_command"),
    "check": (CheckVerb, ".showing:check_command"),
    "tolerate": (TolerateVerb, ".showing:tolerate_command"),
    "strong": (StrongVerb, ".showing:strong_command"),
    "view": (ViewVerb, ".showing:view_command"),
    "plot": (PlotVerb, ".showing:plot_command"),
    "export": (ExportVerb, ".executing:export_command"),
    "inspect": (InspectVerb, ".inspecting:inspect_command"),
    "explore": (ExploreVerb, ".exploring:explore_command"),
    "execute": (ExecuteVerb, ".executing:execute_command"),
    "compare": (CompareVerb, ".studying:compare_command"),
    "tune": (TuneVerb, ".studying:tune_command"),
    "bench": (BenchVerb, ".studying:bench_command"),
}
"""In the order of ``--help``: what a verb takes, and who carries it out."""

GROUPS = {
    "Begin": ("new", "list", "inspect"),
    "Plan": ("plan", "explain", "check", "tolerate", "strong"),
    "Look": ("map", "view", "plot", "explore"),
    "Carry out": ("export", "execute"),
    "Study": ("compare", "tune", "bench"),
}
"""The headings of ``--help``, and the verbs under each."""
