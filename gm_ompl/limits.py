"""The limits in force: what everything inside a block may take of time and of memory.

Work asks here, wherever it is done. What goes on for long calls ``check`` now and then; what takes
much memory at once calls ``claim`` before it takes it, or asks ``fits`` where it can do without.
"""

from __future__ import annotations

import math
import os
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Final, final

from gm_ompl import clock
from gm_ompl.errors import LimitError

MEGABYTE: Final = 1024.0 * 1024.0

READING_EVERY: Final = 0.01
"""Seconds between two readings of the process's memory: a reading costs 10 us."""


@final
class Limits:
    """What may still be taken; its clock starts when it is made.

    Args:
        seconds: wall time [s], without what compiling takes; None is no limit.
        megabytes: resident memory of the whole process [MiB]; None likewise.
        around: limits in force around these, which hold, too.
    """

    def __init__(
        self,
        seconds: float | None,
        megabytes: float | None = None,
        around: Limits | None = None,
    ) -> None:
        self._seconds, self._megabytes = seconds, megabytes
        self._end = math.inf if seconds is None else clock.now() + seconds
        self._bytes = math.inf if megabytes is None else megabytes * MEGABYTE
        self._around, self._next_reading, self._full = around, -math.inf, False

    def left(self) -> float:
        """Return the time left [s]; +inf without a limit."""
        outside = math.inf if self._around is None else self._around.left()
        return max(0.0, min(self._end - clock.now(), outside))

    def reached(self) -> str:
        """Return which limit is reached, as a sentence; empty where none is."""
        now = clock.now()
        if now >= self._end:
            return f"the time limit of {self._seconds:g} s is reached"
        if self._bytes < math.inf and now >= self._next_reading:
            self._next_reading = now + READING_EVERY
            self._full = resident_memory() >= self._bytes
        if self._full:
            return f"the memory limit of {self._megabytes:g} MB is reached"
        return "" if self._around is None else self._around.reached()

    def passed(self) -> bool:
        """Whether one is reached."""
        return bool(self.reached())

    def part(self, share: float, most: float) -> Limits:
        """Return limits on time alone: a share of what is left, at most ``most`` seconds."""
        return Limits(min(most, share * self.left()))

    def refuses(self, extra: float) -> str:
        """Return which limit ``extra`` more bytes would pass, with the numbers; empty: none."""
        taken = resident_memory() if self._bytes < math.inf else 0.0
        if taken + extra > self._bytes:
            return (
                f"{_shown(extra)} more are needed; the memory limit is {self._megabytes:g} MB, of "
                f"which {_shown(taken)} are taken"
            )
        return "" if self._around is None else self._around.refuses(extra)


_IN_FORCE: ContextVar[Limits | None] = ContextVar("limits in force", default=None)


@contextmanager
def holding(seconds: float | None = None, megabytes: float | None = None) -> Iterator[Limits]:
    """Put limits in force inside the block, beside those around it; see ``Limits``."""
    made = Limits(seconds, megabytes, _IN_FORCE.get())
    token = _IN_FORCE.set(made)
    try:
        yield made
    finally:
        _IN_FORCE.reset(token)


@contextmanager
def lifted(seconds: float | None = None) -> Iterator[None]:
    """Put other limits in force inside the block, for what must follow a search that was ended.

    Args:
        seconds: what it may take at most [s]; None lets it be finished.
    """
    token = _IN_FORCE.set(Limits(seconds))
    try:
        yield
    finally:
        _IN_FORCE.reset(token)


def check() -> None:
    """Raise where a limit in force is reached; cheap enough for loops.

    Raises:
        LimitError: it is.
    """
    here = _IN_FORCE.get()
    if here is not None and (sentence := here.reached()):
        raise LimitError(sentence)


def reached() -> str:
    """Return which limit in force is reached, as a sentence; empty where none is."""
    here = _IN_FORCE.get()
    return "" if here is None else here.reached()


def left() -> float:
    """Return the time left [s]; +inf without a limit."""
    here = _IN_FORCE.get()
    return math.inf if here is None else here.left()


def fits(extra: float) -> bool:
    """Whether ``extra`` more bytes are within the limits in force."""
    here = _IN_FORCE.get()
    return here is None or not here.refuses(extra)


def claim(extra: float, what: str, remedy: str) -> None:
    """Raise where ``extra`` more bytes are beyond a limit in force; take them only afterwards.

    Args:
        extra: bytes.
        what: what they are for, with its numbers: "a lattice of 8,000,001 nodes".
        remedy: what to do instead: "lower lattice.segments".

    Raises:
        LimitError: they are.
    """
    here = _IN_FORCE.get()
    if here is not None and (sentence := here.refuses(extra)):
        raise LimitError(f"{what} cannot fit: {sentence}; {remedy}, or raise the limit")


def _shown(size: float) -> str:
    return f"{size / MEGABYTE:,.0f} MB"


def resident_memory(process: int | None = None) -> float:
    """Return the resident memory of this process [bytes]; of another one, 0 where it is unknown."""
    try:
        with open(f"/proc/{process or 'self'}/statm", "rb") as statm:
            pages = int(statm.read().split()[1])
        return float(pages * os.sysconf("SC_PAGE_SIZE"))
    except (OSError, IndexError):
        if process is not None:
            return 0.0
        # No /proc (macOS): the peak stands in for the present, in bytes there, else in KiB.
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return float(peak) * (1.0 if sys.platform == "darwin" else 1024.0)
