"""Where things go: results to stdout, notes and the log to stderr, plans to files.

A reader of the standard streams may leave, a disk may be full. From then on what is written is
dropped and the work goes on, so that files are still written. A reader who has left has seen
enough; a full disk is told when all is done.
"""

from __future__ import annotations

import io
import json
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from gm_ompl.errors import InputError
from gm_ompl.writing import is_special, is_stdout

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

    from gm_ompl.scenario.scenario import Scenario


def say(text: str = "") -> None:
    """Write a line of results to stdout."""
    sys.stdout.write(text + "\n")


def say_json(value: dict[str, Any]) -> None:
    """Write one JSON object to stdout."""
    json.dump(value, sys.stdout, allow_nan=False)
    sys.stdout.write("\n")


def note(text: str) -> None:
    """Write a line to stderr."""
    sys.stderr.write(text + "\n")


def show_warnings(scenario: Scenario) -> None:
    """Write what looks like a mistake in a scenario to stderr."""
    for warning in scenario.warnings:
        note(f"gm-ompl: warning: {warning}")


class _StderrHandler(logging.Handler):
    """Writes to what stderr is at that moment: the progress line replaces it while it stands."""

    def emit(self, record: logging.LogRecord) -> None:
        note(self.format(record))


def show_log() -> None:
    """Show the package's log on stderr, from INFO on."""
    log = logging.getLogger("gm_ompl")
    if not log.handlers:
        log.addHandler(_StderrHandler())
        log.setLevel(logging.INFO)


def writable(path: Path | None, option: str = "-o") -> Path | None:
    """Return ``path`` with links resolved, once it is known that it can be written.

    Asked before planning, so that hours of search are not lost to a misspelt folder. Devices and
    pipes stay as they are named; "-" is the standard output.

    Raises:
        InputError: its folder is missing or not writable, or it is a folder.
    """
    if path is None:
        return None
    if str(path) == "-":
        path = Path("/dev/stdout")
    if is_special(path) or is_stdout(path):
        if not os.access(path, os.W_OK):
            raise InputError(f"{option} {path}: is not writable")
        return path
    target = path.resolve()
    folder = target.parent
    if not folder.is_dir():
        raise InputError(f"{option} {path}: folder {folder} does not exist; make it first")
    if target.is_dir():
        raise InputError(f"{option} {path}: is a folder; name a file to write")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{option} {path}: folder {folder} is not writable")
    return target


def made_folder(path: Path) -> Path:
    """Return ``path`` with links resolved, a folder that is made where it does not exist.

    Raises:
        InputError: it cannot be made.
    """
    if str(path) == "-":
        raise InputError("-o -: several files are written; name a folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"-o {path}: cannot be made a folder: {error.strerror}") from None
    return path.resolve()


@final
class Outlet(io.FileIO):
    """A standard stream.

    Attributes:
        failure: why something could not be written; None where all was, or the reader left.
    """

    failure: OSError | None = None

    def write(self, data: ReadableBuffer, /) -> int:
        """Write ``data``, or drop it where that is not possible (any more)."""
        try:
            return super().write(data)
        except BrokenPipeError:
            pass
        except OSError as error:
            self.failure = error
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
        return memoryview(data).nbytes


@contextmanager
def outlets() -> Iterator[Outlet | None]:
    """Let the standard streams go through outlets; yield that of stdout, where it has one."""
    before = (sys.stdout, sys.stderr)
    made = [_outlet("stdout"), _outlet("stderr")]
    try:
        yield made[0]
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = before


def _outlet(name: str) -> Outlet | None:
    stream = getattr(sys, name)
    if stream is None:  # closed by whoever called: nothing is wanted
        setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
        return None
    try:
        outlet = Outlet(stream.fileno(), "wb", closefd=False)
    except OSError:  # no file of the system's
        return None
    with suppress(OSError):
        stream.flush()
    at_once = stream.line_buffering or stream.write_through
    buffered = io.BufferedWriter(outlet)
    text = io.TextIOWrapper(buffered, stream.encoding, stream.errors, line_buffering=at_once)
    setattr(sys, name, text)
    return outlet


def hush_libraries() -> None:
    """Keep libraries' warnings, here and in child processes, from the user.

    What matters in them is said in messages of our own. ``python -W`` and PYTHONWARNINGS bring
    them back.
    """
    if not sys.warnoptions:
        warnings.showwarning = lambda *_, **__: None
        os.environ["PYTHONWARNINGS"] = "ignore"
    # Without any handler the root logger would write warnings to stderr.
    logging.getLogger().addHandler(logging.NullHandler())
