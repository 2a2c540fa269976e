"""``gm-ompl compare``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from itertools import groupby
from pathlib import Path

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from gm_ompl import api
from gm_ompl.app.exits import Exit
from gm_ompl.app.options import require_positive
from gm_ompl.app.output import made_folder, note
from gm_ompl.app.verbs import CompareVerb
from gm_ompl.errors import MissingExtraError
from gm_ompl.study.cluster import make_executor
from gm_ompl.study.compare import compare, make_tasks, optima
from gm_ompl.study.ompl_log import write_benchmark
from gm_ompl.study.parquet import write_parquet
from gm_ompl.study.report import figure, figures, interval, report_html
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.summary import Difference, Summary, differences, summarise
from gm_ompl.study.task import Limits, Task
from gm_ompl.study.workers import Executor
from gm_ompl.writing import write_text


def compare_command(request: CompareVerb) -> Exit:
    """Make the runs that are missing, write everything, show the tables."""
    tasks = _tasks(request)
    with closing(make_executor(request.executor)) as executor:
        folder = made_folder(request.output)
        with Store(folder / "runs.sqlite") as store:
            records = _compare(tasks, store, executor)
            best = optima(store.all())
    summaries, found = summarise(records, best), differences(records, best)
    console = Console()
    for table in (*_summary_tables(summaries), *_difference_tables(found)):
        console.print(table)
    write_benchmark(records, best, folder / "ompl")
    writers: dict[str, Callable[[Path], None]] = {
        "runs.parquet": lambda path: write_parquet(records, path),
        "report.html": lambda path: write_text(path, report_html(records, best)),
    }
    for name, write in writers.items():
        try:
            write(folder / name)
        except MissingExtraError as error:
            note(f"no {name}: {error}")
    note(f"written to {request.output}")
    return Exit.OK


def _tasks(request: CompareVerb) -> tuple[Task, ...]:
    """Return the runs asked for.

    Raises:
        InputError: an option's value is wrong.
    """
    require_positive(
        time_limit=request.time_limit,
        memory_limit=request.memory_limit,
        max_iterations=request.max_iterations,
    )
    planners = [name.strip() for name in request.planners.split(",") if name.strip()]
    limits = Limits(request.time_limit, request.memory_limit, request.max_iterations)
    return make_tasks([api.load(name) for name in request.scenarios], planners, request.seeds,
                      limits)  # fmt: skip


def _compare(tasks: Sequence[Task], store: Store, executor: Executor) -> tuple[RunRecord, ...]:
    """Make the runs; how many are done is shown on stderr."""
    columns = (TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task("runs", total=len(tasks))
        return compare(tasks, store, executor, lambda done, _: progress.update(bar, completed=done))


def _summary_tables(rows: Sequence[Summary]) -> Iterator[Table]:
    """Yield a table per scenario."""
    for scenario, group in groupby(rows, key=lambda row: row.scenario):
        table = _table(scenario, "planner", "runs", "plan", "first [s]", "cost", "ratio",
                       "regrasps", "z", "decisions", "MiB", "other ends")  # fmt: skip
        for row in group:
            _add(table, row.planner, *figures(row))
        yield table


def _difference_tables(rows: Sequence[Difference]) -> Iterator[Table]:
    """Yield a table per scenario."""
    for scenario, group in groupby(rows, key=lambda row: row.scenario):
        title = f"{scenario}: differences from {rows[0].against} (* interval leaves out 0)"
        table = _table(title, "planner", "figure", "difference", "95% interval")
        for row in group:
            _add(table, row.planner, row.what, figure(row.value), interval(row))
        yield table


def _table(title: str, first: str, *others: str) -> Table:
    table = Table(
        title=Text(title), box=box.SIMPLE_HEAD, title_justify="left", padding=(0, 1, 0, 0)
    )
    table.add_column(Text(first), no_wrap=True)
    for name in others:
        table.add_column(Text(name), justify="right")
    return table


def _add(table: Table, *cells: str) -> None:
    table.add_row(*map(Text, cells))  # plain text: a name may look like rich's markup
