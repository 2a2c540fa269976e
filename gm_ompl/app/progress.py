"""How far a search has come, on stderr."""

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

from gm_ompl.app.output import note
from gm_ompl.planners.planner import Progress

if TYPE_CHECKING:
    from rich.status import Status

FIRST_LINE_S, FACTOR = 5.0, 2.0
"""In a log (no terminal) a line appears after 5 s, 10 s, 20 s, ...: short for a long search too."""


class ProgressLine:
    """Shows a search's events: one line that changes on a terminal, now and then a line in a log.

    Use as a context manager around the search and hand it over as the search's ``report``.
    """

    def __init__(self) -> None:
        self._status: Status | None = None
        self._due = FIRST_LINE_S

    def __enter__(self) -> ProgressLine:
        if sys.stderr.isatty():
            from rich.console import Console  # takes a while to load

            self._status = Console(stderr=True).status("planning ...")
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()

    def __call__(self, event: Progress) -> None:
        """Show ``event``."""
        if self._status is not None:
            self._status.update(describe(event))
        elif event.time >= self._due:
            note(describe(event))
            self._due = FACTOR * max(event.time, self._due)


def describe(event: Progress) -> str:
    """Return the event as one line."""
    best = "none yet" if event.cost is None else f"{event.cost:.6g}"
    bound = f"{event.lower_bound:.6g}" if math.isfinite(event.lower_bound) else "infinite"
    return (
        f"{event.time:.1f} s: {event.expanded:,} nodes expanded, "
        f"{event.mode_decisions:,} mode decisions, best cost {best}, lower bound {bound}"
    )
