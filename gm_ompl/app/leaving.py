"""The way out: a process ends with its work, not when all that it loaded was taken apart."""

from __future__ import annotations

import atexit
import os
import sys
import threading
from contextlib import suppress
from typing import NoReturn


def leave(code: int) -> NoReturn:
    """End the process with an exit code; what was registered for its end is done first.

    Python would free one object after the other, for longer than some verbs take, only for the
    system to take back all of it. It has its way where other threads are still at work, or somebody
    looks on: a profiler, a debugger, a prompt.
    """
    watched = sys.getprofile() or sys.gettrace() or sys.flags.interactive or sys.flags.inspect
    if watched or threading.active_count() > 1:
        sys.exit(code)
    atexit._run_exitfuncs()
    for stream in filter(None, (sys.stdout, sys.stderr)):  # a closed one is None
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)
