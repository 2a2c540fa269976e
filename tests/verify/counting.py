"""Long counts: a claim tried on thousands of instances, resumable, with a table at the end.

A count is a function of an instance number, registered in a file ``tests/verify/count_*.py``::

    @count(instances=300)
    def search_agreement(instance: int) -> Result:
        \"\"\"The plain search and A* agree on the optimal cost.\"\"\"
        ...
        return Result(holds=gap <= 1e-6, worst=gap, note=f"seed {instance}")

Each instance's result is one line of ``build/verify/NAME.jsonl``, written when it is known; a
second call does the instances that have no line yet. Lines carry a hash of the sources that the
count reaches by imports, and only those of the present sources count.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import json
import statistics
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

Record = dict[str, Any]


@dataclass(frozen=True)
class Result:
    """One instance's outcome.

    Attributes:
        holds: whether the claim holds.
        worst: a number whose largest value the table shows (an error, a ratio), if any.
        note: what a reader needs to find the instance again where the claim fails.
        marginal: whether the instance is too close to call; counted apart, never as holding.
        outcome: one of a few words that say how it ended; the table counts each.
    """

    holds: bool
    worst: float | None = None
    note: str = ""
    marginal: bool = False
    outcome: str = ""


@dataclass(frozen=True)
class Count:
    """A registered count; its claim is the function's docstring."""

    name: str
    claim: str
    instances: int
    function: Callable[[int], Result]

    @property
    def file(self) -> Path:
        """The file that defines it."""
        return Path(inspect.getfile(self.function)).resolve()


REGISTRY: dict[str, Count] = {}


def count(instances: int) -> Callable[[Callable[[int], Result]], Callable[[int], Result]]:
    """Register a function of an instance number (0 .. ``instances`` - 1) as a count."""

    def register(function: Callable[[int], Result]) -> Callable[[int], Result]:
        claim = " ".join((function.__doc__ or "").split())
        name = function.__name__
        REGISTRY[name] = Count(name, claim, instances, function)
        return function

    return register


def source_hash(file: Path, root: Path) -> str:
    """Return a short hash of ``file`` and of all the project's sources that it reaches.

    Reached are the modules of ``gm_ompl`` and ``tests`` below ``root`` that are imported by it,
    or by those, at whatever depth; a change elsewhere leaves a count's results standing.
    """
    reached, waiting = {file}, [file]
    while waiting:
        for path in _imports(waiting.pop(), root) - reached:
            reached.add(path)
            waiting.append(path)
    digest = hashlib.sha256()
    for path in sorted(reached):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def _imports(file: Path, root: Path) -> set[Path]:
    """Return the project's files that one file imports, inside functions too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module)
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    files: set[Path] = set()
    for name in names:
        if name.split(".")[0] in ("gm_ompl", "tests"):
            path = root.joinpath(*name.split("."))
            files.update(p for p in (path.with_suffix(".py"), path / "__init__.py") if p.exists())
    return files


@dataclass(frozen=True)
class Store:
    """The results of one count, a line each; only those of the present sources are read."""

    path: Path
    code: str

    def read(self) -> dict[int, Record]:
        """Return the results by instance; a line cut short by a crash is passed over."""
        results: dict[int, Record] = {}
        if not self.path.exists():
            return results
        for line in self.path.read_text().splitlines():
            try:
                record = json.loads(line)
            except json.JSONDecodeError:
                continue
            if record["code"] == self.code:
                results[record["instance"]] = record
        return results

    def add(self, record: Record) -> Record:
        """Append one result, on a line of its own, and return it as written."""
        record = {**record, "code": self.code}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a+b") as file:
            if file.tell() > 0:
                file.seek(-1, 2)
                if file.read(1) != b"\n":
                    file.write(b"\n")
            file.write(json.dumps(record).encode() + b"\n")
        return record


def try_instance(name: str, instance: int) -> Record:
    """Run one instance; an exception is a failure with its traceback as the note."""
    started = time.perf_counter()
    try:
        result = REGISTRY[name].function(instance)
    except Exception:
        result = Result(holds=False, note=traceback.format_exc())
    return {"instance": instance, "seconds": time.perf_counter() - started, **asdict(result)}


def run(
    a_count: Count, store: Store, *, processes: int, limit: int | None = None
) -> dict[int, Record]:
    """Do the instances that have no result yet, and return all results."""
    wanted = range(a_count.instances if limit is None else min(limit, a_count.instances))
    done = store.read()
    left = [instance for instance in wanted if instance not in done]
    for record in _records(a_count.name, left, processes):
        done[record["instance"]] = store.add(record)
    return {instance: done[instance] for instance in wanted}


def _records(name: str, instances: Sequence[int], processes: int) -> Iterable[Record]:
    if processes == 1 or len(instances) < 2:
        for instance in instances:
            yield try_instance(name, instance)
        return
    # Forked workers know the registry; each takes one instance at a time.
    with ProcessPoolExecutor(processes) as pool:
        futures = [pool.submit(try_instance, name, instance) for instance in instances]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def table(results: dict[str, dict[int, Record]], before: str = "") -> str:
    """Return the Markdown table of all counts that have results.

    Args:
        results: by count and instance.
        before: an earlier page; its rows stand where ``results`` has none for a count. A count
            that was never done has a row of no instances.
    """
    lines = [
        "| count | claim | instances | hold | fail | marginal | worst | median s | outcomes "
        "| sources |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    old = {line.split(" | ")[0].removeprefix("| "): line for line in before.splitlines()}
    for name in sorted(REGISTRY):
        if name in results:
            lines.append(_row(name, results[name]))
        else:
            lines.append(old.get(name, f"| {name} | {REGISTRY[name].claim} | 0 | | | | | | | |"))
    return "\n".join(lines) + "\n"


def _row(name: str, records: dict[int, Record]) -> str:
    """Return a count's row of the table."""
    rows = list(records.values())
    marginal = sum(row["marginal"] for row in rows)
    hold = sum(row["holds"] and not row["marginal"] for row in rows)
    numbers = [row["worst"] for row in rows if row["worst"] is not None]
    worst = f"{max(numbers):.3g}" if numbers else ""
    seconds = statistics.median(row["seconds"] for row in rows)
    return (
        f"| {name} | {REGISTRY[name].claim} | {len(rows)} | {hold} | "
        f"{len(rows) - hold - marginal} | {marginal} | {worst} | {seconds:.3g} | "
        f"{_outcomes(rows)} | {rows[0].get('code', '')} |"
    )


def _outcomes(rows: Sequence[Record]) -> str:
    """Return how often each outcome came, the commonest first."""
    counts = Counter(row["outcome"] for row in rows if row.get("outcome"))
    return ", ".join(f"{number} {outcome}" for outcome, number in counts.most_common())


def failures(records: dict[int, Record]) -> list[str]:
    """Return one line per instance on which the claim fails."""
    return [
        f"instance {number}: {row['note']}"
        for number, row in sorted(records.items())
        if not row["holds"] and not row["marginal"]
    ]
