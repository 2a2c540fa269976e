"""``--trace``: what a search did, written as it happens, and read (format ``gm-ompl-trace/1``).

A text file, one JSON object a line. The first names the format and the search; then follow
``progress``, ``expansion`` and ``vertex`` events with the time since the start [s]; the last,
``end``, says how it went. Until then it lies beside its place in a hidden file, which a killed
process leaves: that lacks the end alone.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any, Final

from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Progress, Report
from gm_ompl.planners.trace import Expansion, Vertex
from gm_ompl.reading import Kind, read_text
from gm_ompl.writing import whole

FORMAT: Final = "gm-ompl-trace/1"

KIND: Final = Kind(
    "trace", "JSON lines, as `gm-ompl plan --trace` writes it", 128 * 2**20,
    lambda text: InputError(f"--trace {text}"),
)  # fmt: skip

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

    def __exit__(self, *raised: Any) -> None:
        self._files.__exit__(*raised)

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


@dataclass(frozen=True, eq=False)
class Told:
    """What a trace file says.

    Attributes:
        header: its first line.
        history: (time [s], cost or None, bound or None), in time order.
        expansions: events in order.
        vertices: by number, as last said; in the order of their first event.
    """

    header: Mapping[str, Any]
    history: tuple[tuple[float, float | None, float | None], ...]
    expansions: tuple[Mapping[str, Any], ...] = ()
    vertices: Mapping[int, Mapping[str, Any]] | None = None


def read_trace(path: Path) -> Told:
    """Read a trace file; a last line cut short by an interruption is left out.

    Raises:
        InputError: it cannot be read or is no trace; the message names file and line.
    """
    lines = read_text(path, KIND).splitlines()
    records = [_record(path, k, line, len(lines)) for k, line in enumerate(lines)]
    if not records or records[0].get("format") != FORMAT:
        raise InputError(f'--trace {path}:1: not a trace; its first line says "format": "{FORMAT}"')
    try:
        return _told(records)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"--trace {path}: an event lacks or garbles {error}") from error


def _record(path: Path, k: int, line: str, count: int) -> dict[str, Any]:
    try:
        record = json.loads(line)
    except ValueError as error:
        if k == count - 1 and k > 0:
            return {}
        raise InputError(f"--trace {path}:{k + 1}: not a line of JSON") from error
    if not isinstance(record, dict):
        raise InputError(f"--trace {path}:{k + 1}: must be one JSON object")
    return record


def _told(records: list[dict[str, Any]]) -> Told:
    history: list[tuple[float, float | None, float | None]] = []
    expansions: list[Mapping[str, Any]] = []
    vertices: dict[int, Mapping[str, Any]] = {}
    for record in records[1:]:
        match record.get("event"):
            case "progress":
                history.append((float(record["time"]), record["cost"], record["lower_bound"]))
            case "expansion":
                expansions.append({"q": _floats(record["q"]), **_rest(record, "bound", "why")})
            case "vertex":
                number = int(record["number"])
                vertices[number] = {
                    "q": _floats(record["q"]), "placements": tuple(map(int, record["placements"])),
                    **_rest(record, "parent", "kind", "tree"),
                }  # fmt: skip
            case "end" if record["history"]:
                history = [(float(t), cost, bound) for t, cost, bound in record["history"]]
    return Told(records[0], tuple(history), tuple(expansions), vertices)


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _rest(record: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {name: record[name] for name in names}
