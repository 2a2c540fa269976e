"""A comparison as OMPL's benchmark log, one per scenario, and as OMPL's benchmark database."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import gm_ompl
from gm_ompl.errors import GmOmplError, InputError
from gm_ompl.study.store import RunRecord
from gm_ompl.study.summary import grouped
from gm_ompl.writing import whole, write_text

STATUSES = (
    "Unknown status", "Invalid start", "Invalid goal", "Unrecognized goal type", "Timeout",
    "Approximate solution", "Exact solution", "Crash", "Abort", "Infeasible problem",
)  # fmt: skip
"""OMPL's words for how a run ended; their place is their number."""

_NUMBER = {
    "solved": 6, "infeasible": 9, "budget": 4, "timeout": 4, "memory": 8, "interrupted": 8,
    "killed": 8, "crash": 7, "error": 7, "refused": 0,
}  # fmt: skip

Column = tuple[str, Callable[[RunRecord, Mapping[str, float]], Any]]


def _ratio(run: RunRecord, optima: Mapping[str, float]) -> float | None:
    best = optima.get(run.scenario_key)
    return run.cost / best if run.cost is not None and best else None


_COLUMNS: tuple[Column, ...] = (
    ("status ENUM", lambda run, _: _NUMBER[run.status]),
    ("solved BOOLEAN", lambda run, _: int(run.solved)),
    ("time REAL", lambda run, _: run.wall_s if run.search_s is None else run.search_s),
    ("memory REAL", lambda run, _: run.peak_mb),
    ("solution length REAL", lambda run, _: run.cost),
    ("best cost REAL", lambda run, _: run.cost),
    ("iterations INTEGER", lambda run, _: run.iterations),
    ("time to first plan REAL", lambda run, _: run.first_plan_s),
    ("cost ratio REAL", _ratio),
    ("lower bound REAL", lambda run, _: run.lower_bound),
    ("proven optimal BOOLEAN", lambda run, _: int(run.optimal)),
    ("regrasps INTEGER", lambda run, _: run.regrasps),
    ("least z REAL", lambda run, _: run.least_z),
    ("mode decisions INTEGER", lambda run, _: run.mode_decisions),
    ("mode decisions to first plan INTEGER", lambda run, _: run.first_plan_decisions),
    ("seed INTEGER", lambda run, _: run.seed),
)


def write_benchmark(
    records: Sequence[RunRecord], optima: Mapping[str, float], folder: Path
) -> tuple[Path, ...]:
    """Write a log per scenario and ``benchmark.db`` into ``folder``, made where it is missing.

    Returns:
        The files written, the database last.

    Raises:
        GmOmplError: OMPL's own statistics script cannot read the logs.
    """
    folder.mkdir(parents=True, exist_ok=True)
    logs = []
    for scenario, planners in grouped(records, str).items():
        # Different names may become one file name: the key keeps them apart.
        key = next(iter(planners.values()))[0].scenario_key[:8]
        path = folder / f"{_word(scenario).replace('/', '-')}-{key}.log"
        write_text(path, "\n".join(_log(scenario, planners, optima)) + "\n")
        logs.append(path)
    database = folder / "benchmark.db"
    with whole(database) as part:
        part.unlink()  # the script would look for its tables in it
        _make_database(logs, part)
    return (*logs, database)


def _make_database(logs: Iterable[Path], database: Path) -> None:
    """Let OMPL's script make the database: so the schema is OMPL's, whichever that is."""
    command = [sys.executable, "-P", "-m", "ompl.ompl_benchmark_statistics", "-d", str(database)]
    done = subprocess.run(
        [*command, *map(str, logs)], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONUTF8": "1"},
    )  # fmt: skip
    if re.search("disk is full|disk I/O error", done.stderr):
        raise InputError(f"cannot write {database.parent}: no space is left for the database")
    if done.returncode:
        raise GmOmplError(f"OMPL's statistics script failed on the logs: {done.stderr.strip()}")


def _log(
    scenario: str, planners: Mapping[str, Sequence[RunRecord]], optima: Mapping[str, float]
) -> Iterator[str]:
    """Yield the lines of one scenario's log."""
    runs = [run for group in planners.values() for run in group]
    first = runs[0]
    yield f"gm_ompl version {_word(gm_ompl.__version__)}"
    yield f"Experiment {_word(scenario)}"
    yield f"Running on {_word(platform.node() or 'unknown')}"
    yield f"Starting at {datetime.now(UTC):%Y-%m-%d %H:%M:%S}"
    yield from ("<<<|", f"scenario {_word(scenario)}, code {_word(first.code)}", "|>>>")
    yield from ("<<<|", f"{platform.machine()} {platform.system()}, {os.cpu_count()} cores", "|>>>")
    yield "0 is the random seed"  # of the first run; each run's own is among its columns
    yield f"{first.time_limit or 0.0} seconds per run"  # 0: no limit
    yield f"{first.memory_limit or 0.0} MB per run"
    yield f"{max(map(len, planners.values()))} runs per planner"
    yield f"{sum(run.wall_s for run in runs)} seconds spent to collect the data"
    yield "1 enum type"
    yield "|".join(("status", *STATUSES))
    yield f"{len(planners)} planners"
    for planner, group in planners.items():
        yield from _planner(planner, group, optima)


def _planner(planner: str, runs: Sequence[RunRecord], optima: Mapping[str, float]) -> Iterator[str]:
    yield planner
    settings = {"name": planner, **runs[0].parameters}
    yield f"{len(settings)} common properties"
    for name, value in settings.items():
        yield f"{name} = {_word(str(value))}"
    yield f"{len(_COLUMNS)} properties for each run"
    yield from (name for name, _ in _COLUMNS)
    yield f"{len(runs)} runs"
    for run in runs:
        yield "".join(f"{_value(make(run, optima))}; " for _, make in _COLUMNS)
    yield from ("2 progress properties for each run", "time REAL", "best cost REAL")
    yield f"{len(runs)} runs"
    for run in runs:
        points = {time: cost for time, cost, _ in run.history}  # of equal times, the last
        yield "".join(f"{time!r},{_value(cost)},;" for time, cost in points.items())
    yield "."


def _value(value: Any) -> str:
    return "" if value is None else repr(value)


def _word(text: str) -> str:
    """Return ``text`` as one word: the log's reader splits lines at spaces."""
    return re.sub(r"[^\w./+:-]+", "_", text) or "_"
