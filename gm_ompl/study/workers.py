"""Runs on this machine: feeds the server that runs are forked from, and starts it anew."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Sequence
from typing import IO, Any, Protocol, TypeAlias, final

from gm_ompl.cores import cores
from gm_ompl.errors import GmOmplError
from gm_ompl.study.task import Task

ATTEMPTS = 5  # a run that somebody else keeps killing is given up after so many attempts

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""A run counts as one core; numeric libraries would take them all."""


Outcome: TypeAlias = dict[str, Any]  # fields of ``RunRecord``


class Executor(Protocol):
    """Where runs are made."""

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome, as they finish."""

    def close(self) -> None:
        """Give back what is kept from one call of ``run`` to the next."""


@final
class LocalExecutor:
    """Runs in processes of their own on this machine.

    The server is kept, warm, for the next call of ``run`` until ``close``.

    Args:
        workers: runs at a time; as many as there are cores where None.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or cores()
        self.server: subprocess.Popen[bytes] | None = None
        self._warm: set[str] = set()

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Yield each task with its outcome, as they finish.

        A run that somebody else ends, by itself or with the server, is made again.

        Raises:
            GmOmplError: the server does not start, or dies again and again without finishing a run.
        """
        waiting = deque(range(len(tasks)))
        attempts = [0] * len(tasks)
        fruitless = 0
        while waiting:
            if fruitless >= ATTEMPTS:
                raise GmOmplError("the server that runs are forked from ends again and again")
            fruitless += 1
            flying: set[int] = set()
            done = False
            try:
                for number, outcome in self._serve(tasks, waiting, flying):
                    attempts[number] += 1
                    if outcome["status"] == "killed" and attempts[number] < ATTEMPTS:
                        waiting.append(number)  # last: what kills it may pass
                        continue
                    fruitless = 0
                    yield tasks[number], outcome
                done = not waiting and not flying
            finally:
                if not done:  # gone, or with runs under way that nobody waits for
                    self.close()
            waiting.extendleft(sorted(flying, reverse=True))

    def _serve(
        self, tasks: Sequence[Task], waiting: deque[int], flying: set[int]
    ) -> Iterator[tuple[int, Outcome]]:
        """Yield outcomes until all tasks are done or the server is gone; ``flying`` stays true."""
        with contextlib.suppress(BrokenPipeError):
            requests, answers = self._streams()
            cold = {tasks[number].planner for number in waiting} - self._warm
            if cold:
                _send(requests, {"planners": sorted(cold)})
                if not answers.readline():
                    return
                self._warm |= cold
            while waiting or flying:
                while waiting and len(flying) < self.workers:
                    number = waiting.popleft()
                    flying.add(number)
                    _send(requests, {"number": number, "task": tasks[number].to_dict()})
                line = answers.readline()
                if not line.endswith(b"\n"):
                    return
                answer = json.loads(line)
                flying.discard(answer["number"])
                yield answer["number"], answer["outcome"]

    def _streams(self) -> tuple[IO[bytes], IO[bytes]]:
        """Return where the server takes requests and gives answers; it is started if need be."""
        if self.server is None:
            # A session of its own: Ctrl-C reaches this process alone, which then ends the server.
            self.server = subprocess.Popen(
                [sys.executable, "-P", "-m", "gm_ompl.study.server"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env={**os.environ, **ONE_THREAD},
                start_new_session=True,
            )
        assert self.server.stdin is not None
        assert self.server.stdout is not None
        return self.server.stdin, self.server.stdout

    def close(self) -> None:
        """End the server and every run that it has left behind."""
        server, self.server = self.server, None
        self._warm.clear()
        if server is None:
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(server.pid, signal.SIGKILL)  # before its number may be given away
        for stream in (server.stdin, server.stdout):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()
        server.wait()


def _send(requests: IO[bytes], request: dict[str, Any]) -> None:
    requests.write(json.dumps(request).encode() + b"\n")
    requests.flush()
