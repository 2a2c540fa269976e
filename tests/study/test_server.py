"""The server of runs: what a hang, a crash or cold code costs, and that a run has none of it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from gm_ompl.forks import RunLimits
from gm_ompl.study.task import Task
from tests.study.test_compare import small_tasks

HANGING = """
import time
from gm_ompl import forks
from gm_ompl.study import server
held = []
def behave(task):
    if task.seed == 2:
        held.append(b"x" * 2**26)
    if task.seed > 0:
        time.sleep(60.0)
    return {"status": "solved"}
forks.GRACE_S, server.carry_out = 0.2, behave
server.main()
"""

CRASHING = """
import os, signal
from gm_ompl.errors import InputError
from gm_ompl.study import server
def behave(task):
    if task.seed == 0:
        os.kill(os.getpid(), signal.SIGSEGV)
    raise ZeroDivisionError("by zero") if task.seed == 1 else InputError("not for me")
server.carry_out = behave
server.main()
"""


def test_a_hang_costs_one_run() -> None:
    """A run far beyond its time or memory is killed and recorded; its neighbour is untouched."""
    task, slow = small_tasks()[0], RunLimits(0.2)
    found = _served(
        HANGING,
        [
            replace(task, limits=slow),
            replace(task, seed=1, limits=slow),
            replace(task, seed=2, limits=RunLimits(100.0, memory_mb=1.0)),
        ],
    )
    assert [found[number]["status"] for number in range(3)] == ["solved", "timeout", "memory"]


def test_a_crash_costs_one_run() -> None:
    """A segmentation fault, an exception and a refusal are recorded as what they are."""
    found = _served(CRASHING, [replace(small_tasks()[0], seed=seed) for seed in range(3)])
    assert [found[number]["status"] for number in range(3)] == ["crash", "error", "refused"]
    assert "Segmentation" in found[0]["message"]
    assert found[1]["message"] == "ZeroDivisionError: by zero"
    assert found[2]["message"] == "not for me"


def _served(script: str, tasks: Sequence[Task]) -> dict[int, dict[str, Any]]:
    """Return the outcomes of tasks given to a server whose runs behave as ``script`` says."""
    found: dict[int, dict[str, Any]] = {}
    with subprocess.Popen(
        [sys.executable, "-P", "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as running:
        assert running.stdin is not None and running.stdout is not None
        for number, task in enumerate(tasks):
            line = json.dumps({"number": number, "task": task.to_dict()}) + "\n"
            running.stdin.write(line.encode())
        running.stdin.flush()
        while len(found) < len(tasks):
            answer = json.loads(running.stdout.readline())
            found[answer["number"]] = answer["outcome"]
        running.stdin.close()
        assert running.wait() == 0  # it ends with its input
    return found


COLD = """
import sys
from gm_ompl import compiled
from gm_ompl.study import server
plain = server.carry_out
def counted(task):
    before = compiled.compiled_versions()
    found = plain(task)
    with open({path!r}, "a") as file:
        print(len(compiled.compiled_versions() - before), file=file)
    return found
server.carry_out = counted
server.main()
"""


def test_no_recorded_run_loads_compiled_code(tmp_path: Path) -> None:
    """Without any warm-up, the server loads what the first run needed, and makes it again."""
    counts = tmp_path / "counts"
    found = _served(COLD.format(path=str(counts)), small_tasks()[:1])
    assert found[0]["status"] == "solved" and "compiled" not in found[0]
    loaded = [int(line) for line in counts.read_text().split()]
    assert loaded[0] > 0 and loaded[-1] == 0 and len(loaded) <= 3
