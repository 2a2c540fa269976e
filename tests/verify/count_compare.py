"""Comparisons of 500 runs in which workers are killed at random: nothing lost, nothing repeated."""

from __future__ import annotations

import functools
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from gm_ompl.study.store import RunRecord, Store
from tests.verify.counting import Result, count

RUNS = 500
MEASURED = (
    "wall_s", "cpu_s", "peak_mb", "first_plan_s", "first_plan_decisions", "search_s", "history",
)  # fmt: skip
"""What the clock decides."""

BETWEEN = (5, 20)
"""Runs that end between two kills: so a slow machine has no more kills per run than a quick one."""

PROGRAM = """
import json, sys
from contextlib import closing
from pathlib import Path
import gm_ompl
from gm_ompl.study.compare import compare, make_tasks
from gm_ompl.study.store import Store
from gm_ompl.forks import RunLimits
from gm_ompl.study.workers import LocalExecutor

class Told:
    def __init__(self, executor, log):
        self.executor, self.log = executor, log
    def run(self, tasks):
        for task, outcome in self.executor.run(tasks):
            with open(self.log, "a") as file:
                file.write(task.key() + "\\\\n")
            yield task, outcome
    def close(self):
        self.executor.close()

folder, runs = Path(sys.argv[1]), int(sys.argv[2])
small = ["lattice.segments=2", "fingers.placements.grid=[2, 2]"]
scenario = gm_ompl.load("paper/slide", small)
tasks = make_tasks([scenario], ["RRT", "HybridRRT"], runs // 2, RunLimits(max_iterations=50))
with Store(folder / "runs.sqlite") as store, closing(Told(LocalExecutor(), folder / "log")) as told:
    compare(tasks, store, told)
""".replace("\\\\n", "\\n")


def _begin(folder: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-P", "-c", PROGRAM, str(folder), str(RUNS)]
    return subprocess.Popen(command, start_new_session=True)


def _stored(folder: Path) -> dict[str, RunRecord]:
    if not (folder / "runs.sqlite").exists():
        return {}
    with Store(folder / "runs.sqlite") as store:
        return {record.key: record for record in store.all()}


@functools.cache
def _undisturbed() -> dict[str, RunRecord]:
    with tempfile.TemporaryDirectory() as folder:
        assert _begin(Path(folder)).wait() == 0
        return _without_times(_stored(Path(folder)))


def _await(log: Path, runs: int, running: subprocess.Popen[bytes]) -> None:
    """Wait until so many more runs have ended, or the comparison has."""

    def ended() -> int:
        return log.read_bytes().count(b"\n") if log.exists() else 0

    end = ended() + runs
    while ended() < end and running.poll() is None:
        time.sleep(0.02)


def _without_times(records: dict[str, RunRecord]) -> dict[str, RunRecord]:
    nothing: dict[str, Any] = dict.fromkeys(MEASURED)
    return {key: replace(record, **nothing) for key, record in records.items()}


def _children(pid: int) -> list[int]:
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    except OSError:
        return []
    return [int(word) for word in text.split()]


def _victims(pid: int, rng: random.Random) -> Iterator[int]:
    """Yield a process to kill: mostly a run, now and then the server or the whole comparison."""
    servers = _children(pid)
    runs = [run for server in servers for run in _children(server)]
    draw = rng.random()
    if draw < 0.05:
        yield pid
    elif draw < 0.15:
        yield from servers
    elif runs:
        yield rng.choice(runs)


@count(instances=10)
def comparison_survives_kills(instance: int) -> Result:
    """500 runs, killed at random, the comparison too: all are there, once, as if undisturbed."""
    rng, wrong, kills = random.Random(instance), "", Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        running, seen = _begin(folder), dict[str, RunRecord]()
        while (code := running.poll()) != 0:
            if code is not None:
                seen = _stored(folder)
                running = _begin(folder)
                kills["comparison"] += 1
            _await(folder / "log", rng.randint(*BETWEEN), running)
            time.sleep(rng.uniform(0.0, 0.2))
            for victim in _victims(running.pid, rng):
                with suppress(ProcessLookupError):
                    os.kill(victim, signal.SIGKILL)
                    kills["kills"] += 1
            lost = [key for key, record in seen.items() if _stored(folder).get(key) != record]
            wrong = wrong or (f"{len(lost)} finished runs lost or changed" if lost else "")
        told = Counter((folder / "log").read_text().split())
        found = _stored(folder)
    # A run told but not yet stored when the comparison itself was killed may be told again.
    repeated = sum(told.values()) - len(told)
    if repeated > kills["comparison"]:
        wrong = wrong or f"{repeated} runs made again"
    calm, found = _undisturbed(), _without_times(found)
    other = [key for key in calm.keys() | found.keys() if calm.get(key) != found.get(key)]
    if other:
        wrong = wrong or f"{len(other)} runs otherwise than undisturbed: {found.get(other[0])}"
    return Result(not wrong, float(kills["kills"]), f"{wrong}; {json.dumps(kills)}")
