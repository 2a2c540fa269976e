"""``gm-ompl compare``, ``tune`` and ``bench``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console, JustifyMethod
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table as RichTable
from rich.text import Text

import gm_ompl
from gm_ompl.app.commands import Exit, require_positive
from gm_ompl.app.output import made_folder, note, say, say_json, writable
from gm_ompl.app.study_verbs import BenchVerb, CompareVerb, TuneVerb
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.forks import RunLimits
from gm_ompl.study.bench import SCENARIOS, bench
from gm_ompl.study.cluster import make_executor
from gm_ompl.study.compare import compare, make_tasks, optima
from gm_ompl.study.ompl_log import write_benchmark
from gm_ompl.study.report import Table, gain_lines, number, report_html, table, tables, tuning_html
from gm_ompl.study.store import RunRecord, Store, write_parquet
from gm_ompl.study.task import Task
from gm_ompl.study.tuning import OBJECTIVES, Design, Tuned, tune
from gm_ompl.study.workers import Executor
from gm_ompl.writing import write_text

EVERY = 3  # where no scenario is held out by name, every third is


@contextmanager
def _spared(name: str) -> Iterator[None]:
    """Say what is not written for want of an optional library; the rest is."""
    try:
        yield
    except MissingExtraError as error:
        note(f"no {name}: {error}")


def compare_command(request: CompareVerb) -> Exit:
    """Make the runs that are missing, write everything, show the tables."""
    tasks = _tasks(request)
    with closing(make_executor(request.executor)) as executor:
        folder = made_folder(request.output)
        with Store(folder / "runs.sqlite") as store:
            records = _compare(tasks, store, executor)
            best = optima(store.all())
    for shown in tables(records, best):
        show_table(shown)
    write_benchmark(records, best, folder / "ompl")
    with _spared("runs.parquet"):
        write_parquet(records, folder / "runs.parquet")
    with _spared("report.html"):
        write_text(folder / "report.html", report_html(records, best))
    note(f"written to {request.output}")
    return Exit.OK


def _tasks(request: CompareVerb) -> tuple[Task, ...]:
    require_positive(
        time_limit=request.time_limit,
        memory_limit=request.memory_limit,
        max_iterations=request.max_iterations,
    )
    planners = [name.strip() for name in request.planners.split(",") if name.strip()]
    limits = RunLimits(request.time_limit, request.memory_limit, request.max_iterations)
    scenarios = [gm_ompl.load(name) for name in request.scenarios]
    return make_tasks(scenarios, planners, request.seeds, limits, tolerance=request.tolerance)


def _compare(tasks: Sequence[Task], store: Store, executor: Executor) -> tuple[RunRecord, ...]:
    """Make the runs; how many are done is shown on stderr."""
    columns = (TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task("runs", total=len(tasks))
        return compare(tasks, store, executor, lambda done, _: progress.update(bar, completed=done))


WIDEST = 10_000
"""A line's characters where no terminal limits them: no table is as wide."""


def show_table(table: Table) -> None:
    """Write a table to stdout; all is plain text: a name may look like rich's markup.

    On a terminal cells are folded to its width; in a pipe or a file a row is a line.
    """
    console = Console() if sys.stdout.isatty() else Console(width=WIDEST)
    shown = RichTable(title=Text(table.title), box=box.SIMPLE_HEAD, title_justify="left")
    for k, name in enumerate(table.head):
        side: JustifyMethod = "left" if k < 2 else "right"
        shown.add_column(Text(name), justify=side, no_wrap=k == 1, overflow="fold")
    for row in table.rows:
        shown.add_row(*map(Text, row))
    console.print(shown)


def tune_command(request: TuneVerb) -> Exit:
    """Make the trials that are missing, score the winner, write it."""
    design = _design(request)
    if str(request.output) == "-":
        raise InputError("-o -: a folder for the trials is made beside the file; name a file")
    output = writable(request.output)
    assert output is not None
    folder = output.with_name(f"{output.stem}-study")
    with closing(make_executor(request.executor)) as executor:
        made_folder(folder)
        with Store(folder / "runs.sqlite") as store:
            tuned = tune(
                design, store, executor, folder / "journal.log",
                lambda done, wanted: note(f"trial {done} of {wanted}"),
            )  # fmt: skip
    _write(request, output, folder, tuned)
    return Exit.OK


def _write(request: TuneVerb, output: Path, folder: Path, tuned: Tuned) -> None:
    best, measures = tuned.trials[tuned.best], OBJECTIVES[request.objective]
    write_text(output, json.dumps(best.parameters, indent=2) + "\n")
    for name, first, value in zip(measures, tuned.trials[0].values, best.values, strict=True):
        say(f"training, {name}: {first:.4g} with the defaults, {value:.4g} in trial {tuned.best}")
    for line in gain_lines(tuned):
        say(line)
    if tuned.best == 0:
        say("no trial beat the defaults")
    with _spared("report.html"):
        title = f"{request.planner} tuned for {request.objective}"
        write_text(folder / "report.html", tuning_html(tuned, measures, title))
    note(f"written to {request.output} and {folder.name}/")


def _design(request: TuneVerb) -> Design:
    if request.objective not in OBJECTIVES:
        raise InputError(f"--objective {request.objective}: must be one of {', '.join(OBJECTIVES)}")
    require_positive(time_limit=request.time_limit, max_iterations=request.max_iterations)
    names, held = list(request.scenarios), list(request.hold_out or ())
    if not held:
        held = names[EVERY - 1 :: EVERY]
        names = [name for name in names if name not in held]
    if not held:
        raise InputError(
            f"SCENARIO: {len(names)} given: name {EVERY} or more, every {EVERY}. is held out, or "
            "name others with --hold-out"
        )
    return Design(
        planner=request.planner,
        training=[gm_ompl.load(name) for name in names],
        held_out=[gm_ompl.load(name) for name in held],
        seeds=request.seeds,
        limits=RunLimits(time_s=request.time_limit, max_iterations=request.max_iterations),
        objective=request.objective,
        trials=request.trials,
        seed=request.seed,
    )


def bench_command(request: BenchVerb) -> Exit:
    """Measure, show the result."""
    limits = {key: getattr(request, key) for key in ("repeat", "highs", "search_limit")}
    require_positive(**limits)
    found = bench(request.scenario or SCENARIOS, request.overrides or (), note, **limits)
    if request.as_json:
        say_json(found)
    else:
        for line in lines(found):
            say(line)
    return Exit.OK


def lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield what was measured for people: Markdown, each column as ``bench`` calls it."""
    yield "Choices of control modes (Sec. 3.4), memo off; whole: in HiGHS as the paper reads."
    yield _markdown(found["decisions"])
    yield "Plans: A*, and the plain search: its decisions, counted, times HiGHS's measured mean."
    yield _markdown([{k: v for k, v in row.items() if k != "profile"} for row in found["plans"]])
    yield "Shares of A*'s time."
    yield _markdown([{"scenario": row["scenario"], **row["profile"]} for row in found["plans"]])
    yield ", ".join(f"{k} {v:.2f}" for k, v in found["start"].items() if k != "scenario")
    yield ", ".join(f"{k} {v}" for k, v in found["machine"].items())


def _markdown(rows: Sequence[dict[str, Any]]) -> str:
    def shown(value: Any) -> str:
        return str(value) if isinstance(value, str | bool) else number(value)

    return "\n" + table(list(rows[0]), [[shown(value) for value in row.values()] for row in rows])
