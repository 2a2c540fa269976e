"""What the verbs take that compare, tune and measure planners."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gm_ompl.app.commands import option
from gm_ompl.app.shared_options import (
    as_json_option,
    changes_option,
    executor_option,
    output_option,
    scenarios_option,
)


@dataclass(frozen=True)
class CompareVerb:
    """Compare planners on scenarios; a second call goes on where the first was stopped.

    Every run has a process of its own. Writes runs.sqlite, runs.parquet, report.html, and OMPL's
    benchmark logs and database. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: list[str] = scenarios_option()
    planners: str = option(..., "Planners; the others are set against the first.", "A,B,...")
    seeds: int = option(20, "Runs per scenario and randomised planner.", "N", min=1)
    time_limit: float = option(5.0, "Of each run, in seconds.", "S")
    memory_limit: float | None = option(None, "Of each run's process.", "MB")
    max_iterations: int | None = option(None, "Of each run.", "M")
    tolerance: bool = option(
        False, "Find how far ranges of uncertainty may be widened, too.", None, "--tolerance"
    )
    executor: str = executor_option()
    output: Path = output_option(Path("comparison"), "Folder of runs and reports.", "DIR")


@dataclass(frozen=True)
class TuneVerb:
    """Tune a planner's parameters; a second call goes on where the first was stopped.

    The winner is scored against the defaults on scenarios held out. Beside PARAMS a folder named
    after it keeps runs, trials and report.html. Exit codes: 0 done, 2 bad input, 130 interrupted.
    """

    scenarios: list[str] = scenarios_option()
    planner: str = option(..., "The planner to tune.", "NAME")
    trials: int = option(..., "Trials in all.", "N", min=1)
    hold_out: list[str] | None = option(
        None, "Score the winner on this; repeat. Default: every third.", "SCENARIO"
    )
    objective: str = option(
        "decisions",
        "Make small: decisions (mode decisions to the first plan), time (to it), cost, or "
        "both (decisions and cost); make large: z, or tolerance.",
        "WHAT",
    )
    seeds: int = option(3, "Runs per scenario and trial.", "N", min=1)
    max_iterations: int | None = option(2000, "Of each run.", "M")
    time_limit: float | None = option(None, "Of each run, in seconds.", "S")
    seed: int = option(0, "Of the search.", "N", min=0)
    executor: str = executor_option()
    output: Path = output_option(Path("tuned.json"), "File for plan --params.", "PARAMS")


@dataclass(frozen=True)
class BenchVerb:
    """Measure the project's own speed, as ratios in one run (about two minutes)."""

    scenario: list[str] | None = option(None, "Measure this one; may be repeated.", "SCENARIO")
    repeat: int = option(5, "Repetitions of what is short.", "N")
    highs: int = option(20, "Decisions per search that HiGHS makes, too.", "N")
    search_limit: float = option(10.0, "Wall time of each search measured.", "S")
    overrides: list[str] | None = changes_option()
    as_json: bool = as_json_option()
