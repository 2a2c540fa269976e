"""The server of runs, seen from the site: a run that nobody waits for any longer is killed."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import os
import signal
import sys
from typing import Final, final

from gm_ompl.errors import GmOmplError
from gm_ompl.forks import Json

MOST: Final = 2**26  # bytes of one answer at most; a plan of a thousand steps has a few millions


class GoneError(GmOmplError):
    """The server has ended; the next run starts another."""


@final
class Pool:
    """Makes runs.

    Args:
        module: the server's, which ``python -m`` runs.
        preparation: what the server is told first.
    """

    def __init__(self, module: str, preparation: Json) -> None:
        self._module, self._preparation = module, preparation
        self._process: asyncio.subprocess.Process | None = None
        self._reader: asyncio.Task[None] | None = None
        self._waiting: dict[int, asyncio.Future[Json]] = {}
        self._numbers = itertools.count(1)
        self._starting = asyncio.Lock()
        self._ended = False

    @property
    def busy(self) -> int:
        """How many runs are under way."""
        return len(self._waiting)

    async def start(self) -> None:
        """Start the server, where there is none."""
        async with self._starting:
            if self._process is not None:
                return
            if self._ended:
                raise GoneError("gm-ompl explore has been ended")
            # A session of its own: Ctrl-C reaches this process alone, which then ends the server.
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", self._module,
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=MOST,
                start_new_session=True,
            )  # fmt: skip
            self._send(self._preparation)
            self._reader = asyncio.create_task(self._read(self._process))

    async def run(self, task: Json) -> Json:
        """Return the outcome of a run; cancelled, the run is killed.

        Raises:
            GoneError: the server ended.
        """
        await self.start()
        number = next(self._numbers)
        future: asyncio.Future[Json] = asyncio.get_running_loop().create_future()
        self._waiting[number] = future
        self._send({"number": number, "task": task})
        try:
            return await future
        finally:
            del self._waiting[number]
            if not future.done() or future.cancelled():
                self._send({"drop": number})

    def _send(self, request: Json) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        """Hand outcomes to those who wait for them, until the server ends."""
        assert process.stdout is not None
        while line := await process.stdout.readline():
            told = json.loads(line)
            future = self._waiting.get(told.get("number"))  # None: it is ready
            if future is not None and not future.done():
                future.set_result(told["outcome"])
        self._kill()
        await process.wait()
        for future in self._waiting.values():
            if not future.done():
                future.set_exception(GoneError("the process that plans has ended; try again"))

    def _kill(self) -> None:
        process, self._process = self._process, None
        if process is not None and process.returncode is None:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)

    def end(self) -> None:
        """End the server and its runs, for good."""
        self._ended = True
        self._kill()

    async def close(self) -> None:
        """Likewise; return once nothing of them is left."""
        self.end()
        if self._reader is not None:
            await self._reader
