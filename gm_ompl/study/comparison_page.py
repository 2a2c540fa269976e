"""``python -m gm_ompl.study.comparison_page``: makes the runs of docs/comparison.md and its tables.

Without options: all of them, which takes an hour or two on two cores. Every finished run is stored,
so that a second call goes on where the first was stopped; ``--tables-only`` takes what is stored.
What the page says in words stands between the tables and is left alone.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from gm_ompl import api
from gm_ompl.errors import GmOmplError, InputError
from gm_ompl.study.compare import EXACT, compare, make_tasks, optima
from gm_ompl.study.pages import table, write_tables
from gm_ompl.study.report import figure, interval, other_ends
from gm_ompl.study.store import Record, Store
from gm_ompl.study.summary import Difference, differences, summarise
from gm_ompl.study.task import Limits, Task
from gm_ompl.study.workers import Executor, LocalExecutor

SINGLE = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "paper/cork")
FAMILIES = ("random/tumble", "random/regrasp", "random/planar")
PLANNERS = (EXACT, "HybridRRT", "HybridRRTConnect", "HybridRRTstar",
            "RRT", "RRTConnect", "RRTstar", "KPIECE1")  # fmt: skip


@dataclass(frozen=True)
class Design:
    """What is compared.

    Attributes:
        single: scenarios planned once per seed.
        families: random families; the k-th seed plans the family's k-th scenario.
        planners: names, the exact one first.
        seeds: how many.
        time_limit: of each run [s].
        reference_limit: of the exact planner's run that costs are compared with [s].
    """

    single: Sequence[str] = SINGLE
    families: Sequence[str] = FAMILIES
    planners: Sequence[str] = PLANNERS
    seeds: int = 20
    time_limit: float = 5.0
    reference_limit: float = 120.0


def runs(design: Design) -> tuple[Task, ...]:
    """Return the runs that the tables show, a seed at a time.

    Raises:
        InputError: a name or a number is wrong.
    """
    limits = Limits(design.time_limit)
    single = make_tasks(list(map(api.load, design.single)), design.planners, design.seeds, limits)
    drawn = [
        replace(task, seed=seed)
        for family in design.families
        for seed in range(design.seeds)
        for task in make_tasks([api.load(f"{family}/{seed}")], design.planners, 1, limits)
    ]
    return tuple(sorted((*single, *drawn), key=lambda task: task.seed))


def references(design: Design, tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return a longer run of the exact planner on every scenario of the tasks."""
    limits = Limits(design.reference_limit)
    exact = {task.scenario_key: task for task in tasks if task.planner == EXACT}
    return tuple(replace(task, seed=0, limits=limits) for task in exact.values())


def make(design: Design, store: Store, executor: Executor) -> tuple[Record, ...]:
    """Make the runs that are missing; how many are done is written to stderr.

    Returns:
        The runs that the tables show.
    """
    tasks = runs(design)

    def watch(done: int, wanted: int) -> None:
        sys.stderr.write(f"\r{done} of {wanted} runs ")

    found = compare((*tasks, *references(design, tasks)), store, executor, watch)
    sys.stderr.write("\n")
    return found[: len(tasks)]


def tables(shown: Sequence[Record], best: Mapping[str, float]) -> dict[str, str]:
    """Return the tables of the runs, by the name of their marks.

    Args:
        shown: the runs.
        best: proven optimal costs by scenario key.
    """
    lines = [
        (
            row.scenario, row.planner, row.runs, f"{row.success:.0%}", figure(row.first_plan_s),
            figure(row.cost), figure(row.ratio), figure(row.regrasps), figure(row.least_z),
            figure(row.decisions), f"{row.peak_mb:.0f}", other_ends(row),
        )
        for row in summarise(shown, best)
    ]  # fmt: skip
    head = ("scenario", "planner", "runs", "with a plan", "first plan, s", "cost",
            "cost / optimum", "regrasps", "least z", "decisions", "peak, MiB",
            "other ends")  # fmt: skip
    return {"runs": table(head, lines), "differences": _difference_table(shown, best)}


def _difference_table(shown: Sequence[Record], best: Mapping[str, float]) -> str:
    """Return a line per scenario and planner, a column per figure."""
    lines: dict[tuple[str, str], list[str]] = {}
    heads: dict[str, None] = {}
    for row in differences(shown, best):
        lines.setdefault((row.scenario, row.planner), []).append(_cell(row))
        heads[f"{row.what}, minus {row.against}'s"] = None
    return table(
        ("scenario", "planner", *heads), [(*names, *cells) for names, cells in lines.items()]
    )


def _cell(row: Difference) -> str:
    return "-" if row.value is None and row.low is None and row.high is None else (
        f"{figure(row.value)} ({interval(row)})"
    )  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Make what is missing and write the tables into the page."""
    design = Design()
    parser = page_parser("comparison", __doc__, design)
    parser.add_argument("--families", nargs="*", default=design.families, metavar="random/FAMILY")
    try:
        _, page, shown, best = produced(parser.parse_args(arguments), design)
        write_tables(page, tables(shown, best))
    except GmOmplError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


def page_parser(page: str, description: str | None, design: Design) -> argparse.ArgumentParser:
    """Return a parser of the options that pages made from runs share; ``design`` has defaults."""
    parser = argparse.ArgumentParser(
        prog=f"python -m gm_ompl.study.{page}_page", description=description
    )
    parser.add_argument("--store", type=Path, default=Path("build/comparison/runs.sqlite"))
    parser.add_argument("--page", type=Path, default=Path(f"docs/{page}.md"))
    parser.add_argument("--single", nargs="*", default=design.single, metavar="SCENARIO")
    parser.add_argument("--planners", nargs="+", default=design.planners, metavar="NAME")
    parser.add_argument("--seeds", type=int, default=design.seeds)
    parser.add_argument("--time-limit", type=float, default=design.time_limit, metavar="S")
    parser.add_argument("--reference-limit", type=float, default=design.reference_limit,
                        metavar="S", help="of astar's runs that prove the optima")  # fmt: skip
    parser.add_argument("--tables-only", action="store_true", help="make no runs")
    return parser


def produced(
    given: argparse.Namespace, design: Design
) -> tuple[Design, Path, tuple[Record, ...], dict[str, float]]:
    """Return the design asked for, its page, the runs it shows and the proven optima.

    Raises:
        InputError: see ``produce``.
    """
    options = vars(given)
    path, page, stored = options.pop("store"), options.pop("page"), options.pop("tables_only")
    asked = replace(design, **options)
    return asked, page, *produce(asked, path, page, stored)


def produce(
    design: Design, path: Path, page: Path, stored_only: bool
) -> tuple[tuple[Record, ...], dict[str, float]]:
    """Return the runs that a page shows and the proven optima by scenario key.

    Args:
        design: what is compared.
        path: of the store.
        page: that will show them.
        stored_only: make no runs, take those that are stored.

    Raises:
        InputError: there is no such page, or nothing is stored.
    """
    if not page.is_file():  # said before hours of runs, not after
        raise InputError(
            f"--page {page}: no such file; copy docs/{page.name}, whose marks it needs"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    with Store(path) as store:
        if stored_only:
            shown = tuple(store.get(task.key() for task in runs(design)).values())
        else:
            with closing(LocalExecutor()) as executor:
                shown = make(design, store, executor)
        if not shown:
            raise InputError(f"{path}: holds none of these runs; make them without --tables-only")
        return shown, optima(store.all())


if __name__ == "__main__":
    sys.exit(main())
