"""Finished runs and trials on disk, nothing lost by a kill; the only import of pyarrow."""

from __future__ import annotations

import fcntl
import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from types import NoneType
from typing import Any, TypeAlias, final, get_args, get_type_hints

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.reading import Kind, check_ordinary
from gm_ompl.writing import whole

History: TypeAlias = tuple[tuple[float, float | None, float | None], ...]


@dataclass(frozen=True)
class RunRecord:
    """One finished run."""

    key: str  # see ``Task.key``
    scenario: str  # its name
    scenario_key: str  # a hash of the resolved scenario
    planner: str  # its name
    parameters: dict[str, Any]  # the planner's
    seed: int  # of the run
    time_limit: float | None  # [s], or None
    memory_limit: float | None  # [MiB], or None
    max_iterations: int | None  # or None
    code: str  # the version of the code that ran
    # "solved", "infeasible", "budget" or "interrupted" as in plan files; "timeout" and "memory"
    # where the run was stopped from outside; "killed" where somebody else did that again and
    # again; "crash" and "error" where the planner failed; "refused" where it cannot treat the
    # scenario
    status: str
    message: str = ""  # why, where there is something to say
    cost: float | None = None  # of the plan, or None
    optimal: bool = False  # whether it is proven optimal
    # no plan on the lattice is cheaper; None where nothing is known
    lower_bound: float | None = None
    first_plan_s: float | None = None  # time to the first plan [s], or None
    search_s: float | None = None  # of the search [s], or None
    wall_s: float = 0.0  # of the whole run, its process included [s]
    cpu_s: float = 0.0  # processor time of the whole run [s]
    # peak resident memory of the run's process [MiB], what is shared with the server it was
    # forked from included
    peak_mb: float = 0.0
    regrasps: int | None = None  # in the plan, or None
    least_z: float | None = None  # the smallest stability margin along the plan, or None
    # by how much all ranges of uncertainty may be widened together, or None
    tolerance: float | None = None
    mode_decisions: int | None = None  # made by the search
    # mode decisions made when the first plan was reported, or None. The Hybrid planners report it
    # at once; others at their next progress event.
    first_plan_decisions: int | None = None
    # of the scenario's lattice: nodes times placements to the power of fingers
    states: float | None = None
    iterations: int | None = None  # nodes expanded, or the planner's own iterations
    # (time, cost of the best plan or None, lower bound or None), in time order
    history: History = ()

    @property
    def solved(self) -> bool:
        """Whether the run found a plan."""
        return self.cost is not None


KIND = Kind("store of runs", "SQLite, as compare and tune write it", 2**40)

_COLUMNS = tuple(field.name for field in fields(RunRecord))
_JSON = ("parameters", "history")
_CREATE = f"""CREATE TABLE IF NOT EXISTS runs
({", ".join(f"{name} {'TEXT PRIMARY KEY' if name == 'key' else ''}" for name in _COLUMNS)})"""


class Store:
    """A file of finished runs (SQLite, written ahead, so that a kill loses nothing finished).

    Args:
        path: the file; it is made where it does not exist.

    Raises:
        InputError: it cannot be used.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if os.path.lexists(path):
            check_ordinary(path, KIND)
        with _named(path):
            self._connection = sqlite3.connect(path, timeout=30.0, isolation_level=None)
            self._connection.execute("PRAGMA journal_mode=WAL")
            self._connection.execute(_CREATE)
            have = tuple(row[1] for row in self._connection.execute("PRAGMA table_info(runs)"))
        if have != _COLUMNS:
            raise InputError(f"{path}: holds runs of another version; name another folder")

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()

    def add(self, record: RunRecord) -> None:
        """Store a run; one that is there already stays as it is."""
        values = [
            json.dumps(getattr(record, name)) if name in _JSON else getattr(record, name)
            for name in _COLUMNS
        ]
        marks = ",".join("?" * len(_COLUMNS))
        with _named(self.path):
            self._connection.execute(f"INSERT OR IGNORE INTO runs VALUES ({marks})", values)

    def get(self, keys: Iterable[str]) -> dict[str, RunRecord]:
        """Return the stored ones of the runs with these keys."""
        select = "SELECT * FROM runs WHERE key = ?"
        records = (record for key in keys for record in self._select(select, (key,)))
        return {record.key: record for record in records}

    def all(self) -> tuple[RunRecord, ...]:
        """Return every stored run, in the order in which they finished."""
        return tuple(self._select("SELECT * FROM runs ORDER BY rowid"))

    def _select(self, command: str, values: tuple[str, ...] = ()) -> list[RunRecord]:
        try:
            return [_record(row) for row in self._connection.execute(command, values)]
        except (sqlite3.Error, ValueError, TypeError) as error:
            raise InputError(
                f"{self.path}: is damaged ({error}); name another folder, or delete the file"
            ) from None


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Name the file where SQLite cannot write it: a full disk, another file."""
    try:
        yield
    except sqlite3.Error as error:
        raise InputError(f"{path}: cannot be used as a store of runs: {error}") from None


def _record(row: tuple[Any, ...]) -> RunRecord:
    values = dict(zip(_COLUMNS, row, strict=True))
    values["parameters"] = json.loads(values["parameters"])
    values["history"] = tuple(tuple(entry) for entry in json.loads(values["history"]))
    values["optimal"] = bool(values["optimal"])
    return RunRecord(**values)


def write_parquet(records: Sequence[RunRecord], path: Path) -> None:
    """Write the runs, a row each, the columns being those of ``RunRecord``.

    Parameters are JSON text; the history is a list of (time_s, cost, lower_bound). A column has the
    same type whatever the runs hold.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    try:
        import pyarrow as arrow
        from pyarrow import parquet
    except ImportError:
        raise MissingExtraError("pyarrow", "parquet") from None
    kinds = {float: arrow.float64(), int: arrow.int64(), bool: arrow.bool_()}
    parts = ("time_s", "cost", "lower_bound")
    columns = {}
    for name, hint in get_type_hints(RunRecord).items():
        kind = next(part for part in get_args(hint) or (hint,) if part is not NoneType)
        columns[name] = kinds.get(kind, arrow.string())
    columns["history"] = arrow.list_(arrow.struct([(part, arrow.float64()) for part in parts]))
    rows = [
        {
            **{name: getattr(run, name) for name in columns},
            "parameters": json.dumps(run.parameters),
            "history": [dict(zip(parts, entry, strict=True)) for entry in run.history],
        }
        for run in records
    ]
    with whole(path) as part:
        parquet.write_table(arrow.Table.from_pylist(rows, schema=arrow.schema(columns)), part)


@contextmanager
def writing_journal(journal: Path) -> Iterator[None]:
    """Name the journal where it cannot be read or written.

    Raises:
        InputError: that is so.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot write {journal}: {error.strerror or error}") from error
    except ValueError as error:  # optuna's word for a line that is no JSON
        raise InputError(
            f"{journal}: is no journal of a study, or torn: {error}; name another file with -o"
        ) from error


@final
class JournalLock:
    """Lets one process at a time write a journal; the system unlocks for a process that was killed.

    Optuna's own locks are files, which a killed process leaves behind.
    """

    def __init__(self, journal: Path) -> None:
        self._file = journal.with_name(f"{journal.name}.lock")
        self._handle = -1

    def acquire(self) -> bool:
        """Wait for the lock."""
        self._handle = os.open(self._file, os.O_CREAT | os.O_RDWR, 0o666)
        fcntl.flock(self._handle, fcntl.LOCK_EX)
        return True

    def release(self) -> None:
        """Let others have it."""
        os.close(self._handle)
