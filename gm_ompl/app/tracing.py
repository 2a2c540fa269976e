"""``--trace``: what a search did, written as it happens (format ``gm-ompl-trace/1``).

A text file, one JSON object a line. The first names the format and the search; then follow
``progress``, ``expansion`` and ``vertex`` events with the time since the start [s]; the last,
``end``, says how it went. Until then it lies beside its place in a hidden file, which a killed
process leaves: that lacks the end alone.
"""

from __future__ import annotations

import json
import math
import time
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Final

from gm_ompl.errors import InputError
from gm_ompl.plan.model import Plan
from gm_ompl.planners.planner import Progress, Report
from gm_ompl.planners.trace import Expansion, Vertex
from gm_ompl.writing import whole

FORMAT: Final = "gm-ompl-trace/1"

WHOLE: Final = 100_000
"""So many expansions are all kept; of each further lot as many, only every second, fourth, ..."""

_KINDS: Final = {Expansion: "expansion", Vertex: "vertex"}


class TraceFile:
    """Writes a trace; a context manager, and a search's ``report`` with a ``trace``.

    Vertices are all kept, since later ones hang on them; expansions are thinned out. The file is
    made when there is something to say: a search refused for its input leaves none.

    Args:
        path: where to write.
        header: what the first line says beside the format.
        onward: also told of progress.
    """

    def __init__(self, path: Path, header: dict[str, Any], onward: Report) -> None:
        self._onward = onward
        self._started = time.monotonic()
        self._seen = 0
        self._path, self._header = path, header
        self._stream: IO[str] | None = None
        self._files = ExitStack()

    def __enter__(self) -> TraceFile:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._files.__exit__(kind, error, trace)

    def __call__(self, event: Progress) -> None:
        """Write ``event`` and pass it on."""
        self._write({"event": "progress", **asdict(event)})
        self._onward(event)

    def trace(self, event: Expansion | Vertex) -> None:
        """Write ``event``."""
        if isinstance(event, Expansion):
            self._seen += 1
            if self._seen % 2 ** (self._seen // WHOLE).bit_length():
                return
        now = time.monotonic() - self._started
        self._write({"event": _KINDS[type(event)], "time": now, **asdict(event)})

    def end(self, plan: Plan) -> None:
        """Write how the search ended."""
        history = [list(row) for row in plan.statistics.history]
        self._write({
            "event": "end", "status": plan.status, "cost": plan.cost,
            "lower_bound": plan.lower_bound, "history": history, "expansions": self._seen,
        })  # fmt: skip

    def _write(self, record: dict[str, Any]) -> None:
        plain = {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in record.items()
        }
        try:
            if self._stream is None:
                self._stream = self._opened()
            self._stream.write(_line(plain))
        except OSError as error:
            raise InputError(f"cannot write {self._path}: {error.strerror or error}") from error

    def _opened(self) -> IO[str]:
        """Open the file and write its first line."""
        part = self._files.enter_context(whole(self._path))
        stream = self._files.enter_context(part.open("w", encoding="utf-8", newline="\n"))
        stream.write(_line({"format": FORMAT, **self._header}))
        return stream


def _line(record: dict[str, Any]) -> str:
    return json.dumps(record, allow_nan=False, separators=(",", ":")) + "\n"
