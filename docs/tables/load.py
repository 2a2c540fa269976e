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
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from gm_ompl import api
from gm_ompl.errors import GmOmplError
from gm_ompl.study.cluster import LOCAL, make_executor
from gm_ompl.study.compare import compare, make_tasks
from gm_ompl.study.store import RunRecord, Store
from gm_ompl.study.task import Limits
from gm_ompl.study.workers import Executor, LocalExecutor, cores

PLANNER = "HybridRRTstar"


@dataclass(frozen=True)
class Load:
    """What many runs took.

    Attributes:
        runs: how many.
        workers: runs at a time.
        elapsed_s: wall time of the whole comparison, warming up included [s].
        search_s: wall time of all searches together [s].
        in_hand_s: wall time of all runs' processes together [s].
        runs_cpu_s: processor time of the runs' processes [s].
        others_cpu_s: processor time of what gives out, watches and stores runs [s].
    """

    runs: int
    workers: int
    elapsed_s: float
    search_s: float
    in_hand_s: float
    runs_cpu_s: float
    others_cpu_s: float

    def lines(self) -> tuple[str, ...]:
        """Return the figures in words."""
        offered = self.workers * self.elapsed_s
        occupied, others = self.in_hand_s / offered, self.others_cpu_s
        return (
            f"{self.runs} runs on {self.workers} workers in {self.elapsed_s:.1f} s",
            f"workers had a run in hand {occupied:.1%} of the time",
            f"workers' cores computed for a run {self.runs_cpu_s / offered:.1%} of the time",
            f"overhead, wall time: {1.0 - occupied:.1%} without a run in hand, warming up included",
            f"overhead, processor time: {others / (self.runs_cpu_s + others):.1%} not in runs, "
            f"{1e3 * others / self.runs:.1f} ms per run, warming up included",
            f"of its time a run spent {1.0 - self.search_s / self.in_hand_s:.1%} outside its "
            "search",
        )


def measure(
    scenario: str, runs: int, seconds: float, workers: int, executor: Executor | None = None
) -> Load:
    """Make the runs, stored as a comparison stores them, in a folder that is then removed.

    Args:
        scenario: its name.
        runs: how many.
        seconds: that each searches [s].
        workers: runs at a time.
        executor: where they are made; this machine where None. Of others, processor time beside
            the runs is that of this process alone.

    Raises:
        GmOmplError: the scenario is unknown, or a run did not end by its time limit.
    """
    tasks = make_tasks([api.load(scenario)], [PLANNER], runs, Limits(time_s=seconds))
    before, started = _cpu(), time.monotonic()
    with (
        tempfile.TemporaryDirectory() as folder,
        Store(Path(folder) / "runs.sqlite") as store,
        closing(executor or LocalExecutor(workers)) as place,
    ):
        records = compare(tasks, store, place)
        elapsed = time.monotonic() - started
    spent = _cpu() - before
    if executor is not None:  # runs that are nobody's children here
        spent += sum(record.cpu_s for record in records)
    return _load(records, workers, elapsed, spent)


def _load(records: Sequence[RunRecord], workers: int, elapsed: float, cpu: float) -> Load:
    failed = [record for record in records if record.search_s is None]
    if failed:
        raise GmOmplError(f"{len(failed)} runs failed, the first: {failed[0].message}")
    runs_cpu = sum(record.cpu_s for record in records)
    return Load(
        runs=len(records),
        workers=workers,
        elapsed_s=elapsed,
        search_s=sum(record.search_s or 0.0 for record in records),
        in_hand_s=sum(record.wall_s for record in records),
        runs_cpu_s=runs_cpu,
        others_cpu_s=cpu - runs_cpu,
    )


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
    options = parser.parse_args(arguments)
    try:
        other = None if options.executor == LOCAL else make_executor(options.executor)
        found = measure(options.scenario, options.runs, options.seconds, options.workers, other)
    except GmOmplError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.writelines(f"{line}\n" for line in found.lines())
    return 0


if __name__ == "__main__":
    sys.exit(main())
