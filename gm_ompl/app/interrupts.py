"""Ctrl-C and requests to terminate, heard wherever they come.

A signal raises ``KeyboardInterrupt`` in whatever Python code runs. Where that is a callback from a
library in C, a finaliser or the like, Python drops the exception and goes on; it is raised again
then, until somebody hears it.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType
from typing import Any, Final

AGAIN: Final = 0.05  # seconds until an interrupt that was dropped is raised again


class Interrupts:
    """What became of interrupts; of this process."""

    dropped = False
    """Whether Python has dropped one: what fails after that fails for it."""


def listen() -> None:
    """Treat a request to terminate like Ctrl-C, and lose neither."""
    signal.signal(signal.SIGTERM, _interrupt)
    before = sys.unraisablehook

    def heard(unraisable: Any) -> None:
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            before(unraisable)
            return
        Interrupts.dropped = True
        again = threading.Timer(AGAIN, os.kill, (os.getpid(), signal.SIGTERM))
        again.daemon = True
        again.start()

    sys.unraisablehook = heard


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    """What is known is kept."""
    raise KeyboardInterrupt
