"""``gm-ompl compare``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table as RichTable
from rich.text import Text

import gm_ompl
from gm_ompl.app.exits import Exit
from gm_ompl.app.options import require_positive
from gm_ompl.app.output import made_folder, note
from gm_ompl.app.verbs import CompareVerb
from gm_ompl.errors import MissingExtraError
from gm_ompl.study.cluster import make_executor
from gm_ompl.study.compare import compare, make_tasks, optima
from gm_ompl.study.ompl_log import write_benchmark
from gm_ompl.study.report import Table, report_html, tables
from gm_ompl.study.store import RunRecord, Store, write_parquet
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
    console = Console()
    for table in tables(records, best):
        console.print(_shown(table))
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
    return make_tasks([gm_ompl.load(name) for name in request.scenarios], planners, request.seeds,
                      limits)  # fmt: skip


def _compare(tasks: Sequence[Task], store: Store, executor: Executor) -> tuple[RunRecord, ...]:
    """Make the runs; how many are done is shown on stderr."""
    columns = (TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True)) as progress:
        bar = progress.add_task("runs", total=len(tasks))
        return compare(tasks, store, executor, lambda done, _: progress.update(bar, completed=done))


def _shown(table: Table) -> RichTable:
    """Return a table for the terminal; all is plain text: a name may look like rich's markup."""
    shown = RichTable(title=Text(table.title), box=box.SIMPLE_HEAD, title_justify="left")
    for k, name in enumerate(table.head):
        shown.add_column(Text(name), justify="left" if k < 2 else "right", no_wrap=k == 1)
    for row in table.rows:
        shown.add_row(*map(Text, row))
    return shown
