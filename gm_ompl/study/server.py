"""The server that runs are forked from: everything is imported and compiled before the first one.

``python -m gm_ompl.study.server`` reads JSON lines. The first is ``{"planners": [...]}``, whose
answer ``{"ready": true}`` comes once everything is warm. Each further one,
``{"number": n, "task": {...}}``, starts a run in a process of its own, and is answered by
``{"number": n, "outcome": {...}}`` when that ends. A run that had to load compiled code is made
again once the server has loaded it (see ``warm``). The server ends, and ends its runs, when its
input ends. It starts no thread: forking is safe.
"""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import sys
import time
from dataclasses import dataclass, field
from typing import Any, final

from gm_ompl.study.child import ending, excess, run_and_exit
from gm_ompl.study.task import Task
from gm_ompl.study.warm import load, warm_up

TICK = 0.05
"""How often limits are looked at [s]."""

COLD_TRIES = 3
"""A run that had to load compiled code is made again at most until this many have been made."""


@dataclass
class _Run:
    """A run under way, the ``attempt``-th; ``verdict`` says why the server has killed it."""

    number: int
    task: Task
    attempt: int
    pid: int
    pipe: int
    started: float
    verdict: str = ""
    text: bytearray = field(default_factory=bytearray)


@final
class Server:
    """Forks runs as ``source`` asks, watches them, and tells ``sink`` how they ended."""

    def __init__(self, source: int, sink: int) -> None:
        self._source, self._sink = source, sink
        self._selector = selectors.DefaultSelector()
        self._selector.register(source, selectors.EVENT_READ)
        self._runs: dict[int, _Run] = {}
        self._pending = bytearray()

    def serve(self) -> None:
        """Serve until the input ends."""
        try:
            while True:
                wait = TICK if self._runs else None
                for ready, _ in self._selector.select(wait):
                    if ready.fd == self._source:
                        if not self._read_requests():
                            return
                    else:
                        self._read_run(self._runs[ready.fd])
                self._enforce()
        finally:
            for run in self._runs.values():
                _kill(run.pid)

    def _read_requests(self) -> bool:
        """Answer the requests that have come; return whether more may come."""
        text = os.read(self._source, 1 << 16)
        self._pending += text
        *lines, rest = self._pending.split(b"\n")
        self._pending = bytearray(rest)
        for line in lines:
            self._answer(json.loads(line))
        return bool(text)

    def _answer(self, request: dict[str, Any]) -> None:
        if "task" in request:
            self._start(int(request["number"]), Task.from_dict(request["task"]))
            return
        warm_up(request["planners"])
        self._tell({"ready": True})

    def _start(self, number: int, task: Task, attempt: int = 1) -> None:
        reading, writing = os.pipe()
        pid = os.fork()
        if pid == 0:
            run_and_exit(task, writing)
        os.close(writing)
        run = _Run(number, task, attempt, pid, reading, time.monotonic())
        self._runs[reading] = run
        self._selector.register(reading, selectors.EVENT_READ)

    def _read_run(self, run: _Run) -> None:
        text = os.read(run.pipe, 1 << 16)
        if text:
            run.text += text
            return
        self._selector.unregister(run.pipe)
        os.close(run.pipe)
        del self._runs[run.pipe]
        _, status, usage = os.wait4(run.pid, 0)
        spent = {
            "wall_s": time.monotonic() - run.started,
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "peak_mb": usage.ru_maxrss / 1024.0,
        }
        outcome = ending(run.text, run.verdict, status)
        compiled = outcome.pop("compiled", "")
        if compiled and run.attempt < COLD_TRIES:
            load(compiled)
            self._start(run.number, run.task, run.attempt + 1)
            return
        self._tell({"number": run.number, "outcome": {**outcome, **spent}})

    def _enforce(self) -> None:
        now = time.monotonic()
        for run in self._runs.values():
            if run.verdict:
                continue
            run.verdict = excess(run.task.limits, now - run.started, run.pid)
            if run.verdict:
                _kill(run.pid)

    def _tell(self, answer: dict[str, Any]) -> None:
        left = memoryview(json.dumps(answer).encode() + b"\n")
        while left:
            left = left[os.write(self._sink, left) :]


def _kill(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def main() -> None:
    """Serve on the standard streams."""
    sink = os.dup(1)
    os.dup2(2, 1)  # what libraries print while warming up
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):
        Server(0, sink).serve()


if __name__ == "__main__":
    main()
    sys.exit(0)
