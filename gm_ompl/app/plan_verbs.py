"""The options of the verbs that plan and judge: list, plan, explain, check."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from gm_ompl.app.options import AsJson, Overrides, Scenario


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
    planner: Annotated[str, typer.Option(help="The planner's name.")] = "astar"
    time_limit: Annotated[
        float | None,
        typer.Option(metavar="S", help="Stop after this many seconds."),
    ] = None
    max_iterations: Annotated[
        int | None,
        typer.Option(metavar="N", help="Stop after this many iterations (node expansions)."),
    ] = None
    memory_limit: Annotated[
        float | None,
        typer.Option(metavar="MB", help="Stop when the process uses this much memory."),
    ] = None
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of randomised planners.")] = 0
    params: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The planner's parameters, JSON or YAML."),
    ] = None
    overrides: Overrides = None
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PLAN.json", help="Write the plan there."),
    ] = None
    html: Annotated[
        Path | None,
        typer.Option(metavar="VIEW.html", help="Write a page there that shows the plan."),
    ] = None
    trace: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep there what the search did, for pictures."),
    ] = None
    as_json: AsJson = False


@dataclass(frozen=True)
class ExplainVerb:
    """Say why there is no plan on the lattice, or none through there.

    What is suggested has been judged again. Of many sets of placements some are drawn at random.
    """

    scenario: Scenario
    at: Annotated[
        str | None,
        typer.Option(metavar="S", help="Only there: 0 to 1 along a path, or X,Y,YAW."),
    ] = None
    placements: Annotated[
        str | None,
        typer.Option(
            metavar="FACE:CELL,...", help="Only these, one per finger; CELL is i.j or [i,j]."
        ),
    ] = None
    samples: Annotated[
        int | None, typer.Option(metavar="N", help="Sets of placements judged at most.", min=1)
    ] = None
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the sampling.", min=0)] = 0
    time_limit: Annotated[
        float,
        typer.Option(metavar="S", help="For all of it; 0: without any search.", min=0),
    ] = 30.0
    overrides: Overrides = None
    as_json: AsJson = False


@dataclass(frozen=True)
class CheckVerb:
    """Judge a saved plan anew.

    Only the scenario inside the file is trusted. Exit codes: 0 it holds, 2 bad input, 5 it does
    not hold.
    """

    plan_file: Annotated[Path, typer.Argument(metavar="PLAN.json", help="The plan to judge.")]
    as_json: AsJson = False
