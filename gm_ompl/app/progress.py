"""How far a search has come, on stderr."""

from __future__ import annotations

import math

from rich.console import Console
from rich.status import Status

from gm_ompl.planners.planner import Progress

FIRST_LINE_S, FACTOR = 5.0, 2.0
"""In a log (no terminal) a line appears after 5 s, 10 s, 20 s, ...: short for a long search too."""


class ProgressLine:
    """Shows a search's events: one line that changes on a terminal, now and then a line in a log.

    Use as a context manager around the search and hand it over as the search's ``report``.
    """

    def __init__(self) -> None:
        self._console = Console(stderr=True)
        self._status: Status | None = None
        self._due = FIRST_LINE_S

    def __enter__(self) -> ProgressLine:
        if self._console.is_terminal:
            self._status = self._console.status("planning ...")
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
            self._console.print(describe(event), highlight=False, soft_wrap=True)
            self._due = FACTOR * max(event.time, self._due)


def describe(event: Progress) -> str:
    """Return the event as one line."""
    best = "none yet" if event.cost is None else f"{event.cost:.6g}"
    bound = f"{event.lower_bound:.6g}" if math.isfinite(event.lower_bound) else "infinite"
    return (
        f"{event.time:.1f} s: {event.expanded:,} nodes expanded, "
        f"{event.mode_decisions:,} mode decisions, best cost {best}, lower bound {bound}"
    )
