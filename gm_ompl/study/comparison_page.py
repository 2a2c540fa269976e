"""``python -m gm_ompl.study.comparison_page RUNS.sqlite [PAGE]``: a comparison's tables in docs/.

Of the stored runs those with the limits that most have are shown; proven optima come from all.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from gm_ompl.errors import InputError
from gm_ompl.study.compare import optima
from gm_ompl.study.pages import table, write_tables
from gm_ompl.study.report import failures, figure, interval
from gm_ompl.study.store import Record, Store
from gm_ompl.study.summary import differences, summarise


def tables(stored: Sequence[Record]) -> dict[str, str]:
    """Return the tables of the stored runs, by the name of their marks.

    Raises:
        InputError: there are no runs.
    """
    if not stored:
        raise InputError("the store holds no runs; gm-ompl compare makes them")
    best = optima(stored)
    usual, _ = Counter(map(_limits, stored)).most_common(1)[0]
    shown = sorted(
        (run for run in stored if _limits(run) == usual),
        key=lambda run: (run.scenario, run.planner != "astar", run.planner, run.seed),
    )
    runs = [
        (
            row.scenario, row.planner, row.runs, f"{row.success:.0%}", figure(row.first_plan_s),
            figure(row.cost), figure(row.ratio), figure(row.regrasps), figure(row.least_z),
            f"{row.peak_mb:.0f}", failures(row),
        )
        for row in summarise(shown, best)
    ]  # fmt: skip
    found = [
        (row.scenario, row.planner, row.what, figure(row.value), interval(row))
        for row in differences(shown, best)
    ]
    head = ("scenario", "planner", "runs", "with a plan", "first plan, s", "cost",
            "cost / optimum", "regrasps", "least z", "peak, MiB", "failures")  # fmt: skip
    return {
        "runs": table(head, runs),
        "differences": table(
            ("scenario", "planner", "figure", "minus astar's", "95% interval"), found
        ),
    }


def _limits(run: Record) -> tuple[float | None, float | None, int | None]:
    return run.time_limit, run.memory_limit, run.max_iterations


def main(arguments: Sequence[str]) -> None:
    """Write the tables into the page."""
    page = Path(arguments[1] if len(arguments) > 1 else "docs/comparison.md")
    with Store(Path(arguments[0])) as store:
        write_tables(page, tables(store.all()))


if __name__ == "__main__":
    main(sys.argv[1:])
