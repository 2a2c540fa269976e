"""``python -m docs.tables.load``: how well many runs use the workers, and what a run costs.

Every run searches for its whole time limit (``HybridRRTstar`` never ends by itself). Told is how
long workers had a run in hand and their cores computed for it, the overhead, which is the time
without a run in hand, and the processor time of others than the runs, as a share of all: other work
on the machine hardly changes that.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

from gm_ompl import api
from gm_ompl.cores import cores
from gm_ompl.errors import GmOmplError
from gm_ompl.forks import RunLimits
from gm_ompl.study.cluster import LOCAL, make_executor
from gm_ompl.study.compare import compare, make_tasks
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.workers import Executor, LocalExecutor

PLANNER = "HybridRRTstar"


def measure(
    scenario: str, runs: int, seconds: float, executor: Executor
) -> tuple[tuple[RunRecord, ...], float, float]:
    """Make the runs, stored as a comparison stores them, in a folder that is then removed.

    Args:
        scenario: its name.
        runs: how many.
        seconds: that each searches [s].
        executor: where they are made; it is closed.

    Returns:
        The runs; wall time and processor time of all, warming up included [s]. Elsewhere than on
        this machine the latter is that of the runs and of this process.

    Raises:
        GmOmplError: the scenario is unknown, or a run did not end by its time limit.
    """
    tasks = make_tasks([api.load(scenario)], [PLANNER], runs, RunLimits(time_s=seconds))
    before, started = _cpu(), time.monotonic()
    with (
        tempfile.TemporaryDirectory() as folder,
        Store(Path(folder) / "runs.sqlite") as store,
        closing(executor) as place,
    ):
        records = compare(tasks, store, place)
        elapsed = time.monotonic() - started
    failed = [record for record in records if record.search_s is None]
    if failed:
        raise GmOmplError(f"{len(failed)} runs failed, the first: {failed[0].message}")
    elsewhere = not isinstance(executor, LocalExecutor)  # runs that are nobody's children here
    spent = _cpu() - before + elsewhere * sum(record.cpu_s for record in records)
    return records, elapsed, spent


def lines(
    records: Sequence[RunRecord], elapsed: float, spent: float, workers: int
) -> Iterator[str]:
    """Yield the figures in words."""
    offered, runs = workers * elapsed, len(records)
    in_hand, own, searched = (
        sum(getattr(record, name) for record in records) for name in ("wall_s", "cpu_s", "search_s")
    )
    others = spent - own
    yield f"{runs} runs on {workers} workers in {elapsed:.1f} s"
    yield f"workers had a run in hand {in_hand / offered:.1%} of the time"
    yield f"workers' cores computed for a run {own / offered:.1%} of the time"
    yield (
        f"overhead, wall time: {1.0 - in_hand / offered:.1%} without a run in hand, warming up "
        "included"
    )
    yield (
        f"overhead, processor time: {others / spent:.1%} not in runs, "
        f"{1e3 * others / runs:.1f} ms per run, warming up included"
    )
    yield f"of its time a run spent {1.0 - searched / in_hand:.1%} outside its search"


def _cpu() -> float:
    """Return the processor time of this process and of all that it has waited for [s]."""
    used = [resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and say."""
    parser = argparse.ArgumentParser(prog="python -m docs.tables.load", description=__doc__)
    parser.add_argument("--scenario", default="paper/regrasp", metavar="SCENARIO")
    parser.add_argument("--runs", type=int, default=2000, metavar="N")
    parser.add_argument("--seconds", type=float, default=1.0, metavar="S", help="of each run")
    parser.add_argument("--workers", type=int, default=cores(), metavar="N")
    parser.add_argument("--executor", default=LOCAL, metavar="WHERE", help="or dask://HOST:PORT")
    given = parser.parse_args(arguments)
    try:
        local = given.executor == LOCAL
        executor = LocalExecutor(given.workers) if local else make_executor(given.executor)
        found = measure(given.scenario, given.runs, given.seconds, executor)
    except GmOmplError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.writelines(f"{line}\n" for line in lines(*found, given.workers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
