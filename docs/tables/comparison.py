"""``python -m docs.tables.comparison``: makes the runs of its page and its tables.

Without options: all of them, which takes an hour or two on two cores. Every finished run is stored,
so that a second call goes on where the first was stopped; ``--tables-only`` takes what is stored.
What the page says in words stands between the tables and is left alone.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from docs.tables.pages import write_tables
from gm_ompl import api
from gm_ompl.errors import GmOmplError, InputError
from gm_ompl.forks import RunLimits
from gm_ompl.study.compare import EXACT, compare, make_tasks, optima
from gm_ompl.study.report import table, tables
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Task
from gm_ompl.study.workers import LocalExecutor

SINGLE = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "paper/cork")
FAMILIES = ("random/tumble", "random/regrasp", "random/planar")
PLANNERS = (EXACT, "HybridRRT", "HybridRRTConnect", "HybridRRTstar",
            "RRT", "RRTConnect", "RRTstar", "KPIECE1")  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """What is compared."""

    single: Sequence[str] = SINGLE  # scenarios planned once per seed
    # random families; the k-th seed plans the family's k-th scenario
    families: Sequence[str] = FAMILIES
    planners: Sequence[str] = PLANNERS  # names, the exact one first
    seeds: int = 20  # how many
    time_limit: float = 5.0  # of each run [s]
    reference_limit: float = 120.0  # of the exact planner's run that costs are compared with [s]


def runs(design: Comparison) -> tuple[Task, ...]:
    """Return the runs that the tables show, a seed at a time.

    Raises:
        InputError: a name or a number is wrong.
    """
    limits = RunLimits(design.time_limit)
    single = make_tasks(list(map(api.load, design.single)), design.planners, design.seeds, limits)
    drawn = [
        replace(task, seed=seed)
        for family in design.families
        for seed in range(design.seeds)
        for task in make_tasks([api.load(f"{family}/{seed}")], design.planners, 1, limits)
    ]
    return tuple(sorted((*single, *drawn), key=lambda task: task.seed))


def references(design: Comparison, tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return a longer run of the exact planner on every scenario of the tasks."""
    limits = RunLimits(design.reference_limit)
    exact = {task.scenario_key: task for task in tasks if task.planner == EXACT}
    return tuple(replace(task, seed=0, limits=limits) for task in exact.values())


def marked(shown: Sequence[RunRecord], best: Mapping[str, float]) -> dict[str, str]:
    """Return the tables of the runs by the name of their marks; ``best`` is by scenario key."""
    found = (table(one.head, one.rows) for one in tables(shown, best))
    return dict(zip(("runs", "differences"), found, strict=True))


def main(arguments: Sequence[str] | None = None) -> int:
    """Make what is missing and write the tables into the page."""
    return produce("comparison", Comparison(), arguments, lambda _design, page, shown, best:
                   write_tables(page, marked(shown, best)))  # fmt: skip


Write: TypeAlias = Callable[[Comparison, Path, Sequence[RunRecord], Mapping[str, float]], None]
"""Writes a page from its runs and the proven optima by scenario key."""


def produce(name: str, design: Comparison, arguments: Sequence[str] | None, write: Write) -> int:
    """Make the runs of a page that are missing and have it written; return the exit code.

    What the arguments of the command line do not say is as in ``design``.
    """
    parser = argparse.ArgumentParser(prog=f"python -m docs.tables.{name}")
    parser.add_argument("--store", type=Path, default=Path("build/comparison/runs.sqlite"))
    parser.add_argument("--page", type=Path, default=Path(f"docs/results/{name}.md"))
    parser.add_argument("--tables-only", action="store_true", help="make no runs")
    for option, value in vars(design).items():
        many: dict[str, Any] = {"nargs": "*"} if isinstance(value, tuple) else {"type": type(value)}
        parser.add_argument(f"--{option.replace('_', '-')}", default=value, **many)
    options = vars(parser.parse_args(arguments))
    path, page, stored_only = (options.pop(key) for key in ("store", "page", "tables_only"))
    asked = Comparison(**options)
    try:
        if not page.is_file():  # said before hours of runs, not after
            raise InputError(
                f"--page {page}: no such file; copy docs/results/{page.name} with its marks"
            )
        write(asked, page, *_runs(asked, path, stored_only))
    except GmOmplError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def _runs(
    design: Comparison, path: Path, stored_only: bool
) -> tuple[tuple[RunRecord, ...], dict[str, float]]:
    """Return the runs that a page shows and the proven optima by scenario key."""
    path.parent.mkdir(parents=True, exist_ok=True)
    tasks = runs(design)
    with Store(path) as store:
        if stored_only:
            shown = tuple(store.get(task.key() for task in tasks).values())
        else:
            with closing(LocalExecutor()) as executor:
                wanted = (*tasks, *references(design, tasks))
                shown = compare(wanted, store, executor, _watch)[: len(tasks)]
            sys.stderr.write("\n")
        if not shown:
            raise InputError(f"{path}: holds none of these runs; make them without --tables-only")
        return shown, optima(store.all())


def _watch(done: int, wanted: int) -> None:
    sys.stderr.write(f"\r{done} of {wanted} runs ")


if __name__ == "__main__":
    sys.exit(main())
