"""What a forked process does: one run, told through a pipe; and how else it may end."""

from __future__ import annotations

import json
import math
import os
import resource
import signal
from typing import Any, NoReturn

from gm_ompl.errors import GmOmplError, LimitError
from gm_ompl.limits import MEGABYTE, resident_memory
from gm_ompl.study.run import carry_out
from gm_ompl.study.task import Limits, Task
from gm_ompl.study.warm import compiled_versions, pack

GRACE_S, GRACE_SHARE = 5.0, 0.5
"""A run is killed this long after its time limit, in seconds and in shares of the limit: a planner
looks at its clock between steps, and control is made steady after the search."""

MEMORY_GRACE = 1.25
"""A run is killed beyond this share of its memory limit; the planner itself should stop before."""

FOREIGN = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
"""Signals that no planner raises by itself: somebody else has ended the run."""


def ending(text: bytes | bytearray, verdict: str, status: int) -> dict[str, Any]:
    """Return how a run ended.

    Args:
        text: what it told, JSON; empty or cut where it did not come to that.
        verdict: why the server killed it, or empty.
        status: of its process, as ``os.wait4`` gives it.
    """
    try:
        told: dict[str, Any] = json.loads(text)
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


def hard_time_limit(limits: Limits) -> float:
    """Return the wall time after which a run is killed [s]."""
    if limits.time_s is None:
        return math.inf
    return limits.time_s * (1.0 + GRACE_SHARE) + GRACE_S


def excess(limits: Limits, elapsed: float, pid: int) -> str:
    """Return which limit a run has passed by far, or an empty string.

    Args:
        limits: of the run.
        elapsed: wall time since its start [s].
        pid: of its process.
    """
    if elapsed > hard_time_limit(limits):
        return "timeout"
    limit = math.inf if limits.memory_mb is None else MEMORY_GRACE * limits.memory_mb * MEGABYTE
    return "memory" if resident_memory(pid) > limit else ""


def run_and_exit(task: Task, pipe: int) -> NoReturn:
    """Carry the task out, tell the result through ``pipe``, and end this process.

    Told is what a record keeps, and under ``compiled`` what had to be loaded on the way.
    """
    code = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):  # what a library prints must not get between the answers
            os.dup2(nowhere, standard)
        limit = hard_time_limit(task.limits)
        if limit < math.inf:  # a second net, for a run that outlives the server
            seconds = math.ceil(limit) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        with open(pipe, "wb") as stream:
            stream.write(json.dumps(_told(task)).encode())
        code = 0
    finally:
        os._exit(code)  # no clean-up of what belongs to the server


def _told(task: Task) -> dict[str, Any]:
    before = compiled_versions()
    try:
        told = carry_out(task)
    except LimitError as error:
        told = {"status": "budget", "message": str(error)}
    except GmOmplError as error:
        told = {"status": "refused", "message": str(error)}
    except Exception as error:
        told = {"status": "error", "message": f"{type(error).__name__}: {error}"}
    return {**told, "compiled": pack(compiled_versions() - before)}
