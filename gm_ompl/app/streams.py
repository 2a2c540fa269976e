"""Standard output and error of the command: a reader may leave, a disk may be full.

From then on what is written is dropped and the work goes on, so that files are still written. A
reader who has left has seen enough; a full disk is told when all is done.
"""

from __future__ import annotations

import io
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, final

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


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
        warnings.showwarning = _show_nothing
        os.environ["PYTHONWARNINGS"] = "ignore"
    # Without any handler the root logger would write warnings to stderr.
    logging.getLogger().addHandler(logging.NullHandler())


def _show_nothing(*_: object, **__: object) -> None:
    """Stand in for ``warnings.showwarning``."""
