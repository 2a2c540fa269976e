"""The clock that budgets are measured by: it stands still while machine code is made or loaded.

A time limit is for the search. The first search on a machine would otherwise spend most of it on
compiling, and the same call would find less than the second time.
"""

from __future__ import annotations

import time

_stood_still = 0.0


def now() -> float:
    """Return the time of the clock [s]; only differences mean something."""
    return time.monotonic() - _stood_still


def stand_still(seconds: float) -> None:
    """Take out ``seconds`` that have just passed [s]."""
    global _stood_still
    _stood_still += seconds
