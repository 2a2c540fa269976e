"""The options of the verbs that measure planners and the project: compare, tune, bench."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from gm_ompl.app.options import AsJson, Executor, Overrides, Scenarios


@dataclass(frozen=True)
class CompareVerb:
    """Compare planners on scenarios; a second call goes on where the first was stopped.

    Every run has a process of its own. Writes runs.sqlite, runs.parquet, report.html, and OMPL's
    benchmark logs and database. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: Scenarios
    planners: Annotated[
        str, typer.Option(metavar="A,B,...", help="Planners; the others are set against the first.")
    ]
    seeds: Annotated[
        int, typer.Option(metavar="N", min=1, help="Runs per scenario and randomised planner.")
    ] = 20
    time_limit: Annotated[float, typer.Option(metavar="S", help="Of each run, in seconds.")] = 5.0
    memory_limit: Annotated[
        float | None, typer.Option(metavar="MB", help="Of each run's process.")
    ] = None
    max_iterations: Annotated[int | None, typer.Option(metavar="M", help="Of each run.")] = None
    executor: Executor = "local"
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of runs and reports.")
    ] = Path("comparison")


@dataclass(frozen=True)
class TuneVerb:
    """Tune a planner's parameters; a second call goes on where the first was stopped.

    The winner is scored against the defaults on scenarios held out. Beside PARAMS a folder named
    after it keeps runs, trials and report.html. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: Scenarios
    planner: Annotated[str, typer.Option(metavar="NAME", help="The planner to tune.")]
    trials: Annotated[int, typer.Option(metavar="N", min=1, help="Trials in all.")]
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SCENARIO", help="Score the winner on this; repeat. Default: every third."
        ),
    ] = None
    objective: Annotated[
        str,
        typer.Option(
            metavar="WHAT",
            help="Make small: decisions (mode decisions to the first plan), time (to it), cost, "
            "or both (decisions and cost).",
        ),
    ] = "decisions"
    seeds: Annotated[int, typer.Option(metavar="N", min=1, help="Runs per scenario and trial.")] = 3
    max_iterations: Annotated[int | None, typer.Option(metavar="M", help="Of each run.")] = 2000
    time_limit: Annotated[
        float | None, typer.Option(metavar="S", help="Of each run, in seconds.")
    ] = None
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Of the search.")] = 0
    executor: Executor = "local"
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="PARAMS", help="File for plan --params.")
    ] = Path("tuned.json")


@dataclass(frozen=True)
class BenchVerb:
    """Measure the project's own speed, as ratios in one run (about two minutes)."""

    scenario: Annotated[
        list[str] | None,
        typer.Option(metavar="SCENARIO", help="Measure this one; may be repeated."),
    ] = None
    repeat: Annotated[int, typer.Option(metavar="N", help="Repetitions of what is short.")] = 5
    highs: Annotated[
        int, typer.Option(metavar="N", help="Decisions per search that HiGHS makes, too.")
    ] = 20
    search_limit: Annotated[
        float, typer.Option(metavar="S", help="Wall time of each search measured.")
    ] = 10.0
    overrides: Overrides = None
    as_json: AsJson = False
