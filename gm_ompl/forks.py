"""Runs in processes forked from a warm one: everything is imported and compiled before the first.

The server reads JSON lines. ``{"number": n, "task": {...}}`` starts a run in a process of its own,
and is answered by ``{"number": n, "outcome": {...}}`` when that ends; ``{"drop": n}`` kills it, and
nothing is answered. Any other line is for the server itself, which is to get ready, and is answered
by ``{"ready": true}``. What a run had to compile, or to load as compiled, the server loads, so that
no later run pays for it. The server ends, and ends its runs, when its input ends. It starts no
thread: forking is safe.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import resource
import selectors
import signal
import time
from dataclasses import dataclass, field
from typing import Any, NoReturn, Protocol, TypeAlias, final

from gm_ompl.compiled import compiled_versions, load, pack
from gm_ompl.cores import cores
from gm_ompl.errors import GmOmplError, LimitError
from gm_ompl.limits import MEGABYTE, resident_memory

Json: TypeAlias = dict[str, Any]

GRACE_S, GRACE_SHARE = 5.0, 0.5
"""A run is killed this long after its time limit, in seconds and in shares of the limit: a planner
looks at its clock between steps, and control is made steady after the search."""

MEMORY_GRACE = 1.25
"""A run is killed beyond this share of its memory limit; the planner itself should stop before."""

FOREIGN = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that no planner raises by itself: somebody else has ended the run."""

TICK = 0.05  # how often limits are looked at [s]


@dataclass(frozen=True)
class RunLimits:
    """What one run may spend; None is no limit."""

    time_s: float | None = None  # wall time of the search [s]
    memory_mb: float | None = None  # resident memory of the run's process [MiB]
    max_iterations: int | None = None  # the planner's own iterations


class Service(Protocol):
    """What a server does."""

    tries: int
    """A run that had to load compiled code is made again until this many have been made."""

    def prepare(self, request: Json) -> None:
        """Get ready, in the server's own process."""

    def limits(self, task: Json) -> RunLimits:
        """Return what a run of ``task`` may spend."""

    def carry_out(self, task: Json) -> Json:
        """Return what a run of ``task`` tells; called in the run's process."""


def ending(text: bytes | bytearray, verdict: str, status: int) -> Json:
    """Return how a run ended.

    Args:
        text: what it told, JSON; empty or cut where it did not come to that.
        verdict: why the server killed it, or empty.
        status: of its process, as ``os.wait4`` gives it.
    """
    try:
        told: Json = json.loads(text)
    except ValueError:
        told = {}
    if told:
        return told
    if verdict:
        return {"status": verdict, "message": f"killed: {verdict} limit passed by far"}
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        kind = "killed" if number in FOREIGN else "crash"
        return {"status": kind, "message": signal.strsignal(number) or f"signal {number}"}
    return {"status": "crash", "message": f"exit code {os.waitstatus_to_exitcode(status)}"}


def hard_time_limit(limits: RunLimits) -> float:
    """Return the wall time after which a run is killed [s]."""
    if limits.time_s is None:
        return math.inf
    return limits.time_s * (1.0 + GRACE_SHARE) + GRACE_S


def excess(limits: RunLimits, elapsed: float, pid: int) -> str:
    """Return which limit a run has passed by far after ``elapsed`` [s], or an empty string."""
    if elapsed > hard_time_limit(limits):
        return "timeout"
    limit = math.inf if limits.memory_mb is None else MEMORY_GRACE * limits.memory_mb * MEGABYTE
    return "memory" if resident_memory(pid) > limit else ""


def run_and_exit(service: Service, task: Json, pipe: int) -> NoReturn:
    """Carry the task out, tell the result through ``pipe``, and end this process.

    Told is what the service tells, and under ``compiled`` what had to be loaded on the way.
    """
    code = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):  # what a library prints must not get between the answers
            os.dup2(nowhere, standard)
        limit = hard_time_limit(service.limits(task))
        if limit < math.inf:  # a second net, for a run that outlives the server
            seconds = math.ceil(limit * cores()) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        with open(pipe, "wb") as stream:
            stream.write(json.dumps(_told(service, task)).encode())
        code = 0
    finally:
        os._exit(code)  # no clean-up of what belongs to the server


def _told(service: Service, task: Json) -> Json:
    before = compiled_versions()
    try:
        told = service.carry_out(task)
    except LimitError as error:
        told = {"status": "budget", "message": str(error)}
    except GmOmplError as error:
        told = {"status": "refused", "message": str(error)}
    except Exception as error:
        told = {"status": "error", "message": f"{type(error).__name__}: {error}"}
    return {**told, "compiled": pack(compiled_versions() - before)}


@dataclass
class _Run:
    """A run under way, the ``attempt``-th; ``verdict`` says why the server has killed it."""

    number: int
    task: Json
    limits: RunLimits
    attempt: int
    pid: int
    pipe: int
    started: float
    verdict: str = ""
    text: bytearray = field(default_factory=bytearray)


@final
class Server:
    """Forks runs as ``source`` asks, watches them, and tells ``sink`` how they ended."""

    def __init__(self, service: Service, source: int, sink: int) -> None:
        self._service, self._source, self._sink = service, source, sink
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
                    elif ready.fd in self._runs:  # else dropped a moment ago
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

    def _answer(self, request: Json) -> None:
        if "task" in request:
            self._start(int(request["number"]), request["task"])
        elif "drop" in request:
            for run in [run for run in self._runs.values() if run.number == request["drop"]]:
                _kill(run.pid)
                self._end(run)
        else:
            self._service.prepare(request)
            self._tell({"ready": True})

    def _start(self, number: int, task: Json, attempt: int = 1) -> None:
        limits = self._service.limits(task)
        reading, writing = os.pipe()
        pid = os.fork()
        if pid == 0:
            run_and_exit(self._service, task, writing)
        os.close(writing)
        run = _Run(number, task, limits, attempt, pid, reading, time.monotonic())
        self._runs[reading] = run
        self._selector.register(reading, selectors.EVENT_READ)

    def _end(self, run: _Run) -> tuple[int, resource.struct_rusage]:
        """Forget a run once its process has ended; return its status and what it used."""
        self._selector.unregister(run.pipe)
        os.close(run.pipe)
        del self._runs[run.pipe]
        _, status, usage = os.wait4(run.pid, 0)
        return status, usage

    def _read_run(self, run: _Run) -> None:
        text = os.read(run.pipe, 1 << 16)
        if text:
            run.text += text
            return
        status, usage = self._end(run)
        spent = {
            "wall_s": time.monotonic() - run.started,
            "cpu_s": usage.ru_utime + usage.ru_stime,
            "peak_mb": usage.ru_maxrss / 1024.0,
        }
        outcome = ending(run.text, run.verdict, status)
        compiled = outcome.pop("compiled", "")
        again = compiled and run.attempt < self._service.tries
        if not again:
            self._tell({"number": run.number, "outcome": {**outcome, **spent}})
        if compiled:
            load(compiled)
        if again:
            self._start(run.number, run.task, run.attempt + 1)

    def _enforce(self) -> None:
        now = time.monotonic()
        for run in self._runs.values():
            if run.verdict:
                continue
            run.verdict = excess(run.limits, now - run.started, run.pid)
            if run.verdict:
                _kill(run.pid)

    def _tell(self, answer: Json) -> None:
        left = memoryview(json.dumps(answer).encode() + b"\n")
        while left:
            left = left[os.write(self._sink, left) :]


def _kill(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def serve(service: Service) -> None:
    """Serve on the standard streams."""
    sink = os.dup(1)
    os.dup2(2, 1)  # what libraries print while getting ready
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):
        Server(service, 0, sink).serve()
