"""A tuning's journal on disk: what may go wrong with it, and who may write it."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import final

from gm_ompl.errors import InputError


@contextmanager
def writing_journal(journal: Path) -> Iterator[None]:
    """Name the journal where it cannot be read or written.

    Raises:
        InputError: that is so.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot write {journal}: {error.strerror or error}") from error
    except ValueError as error:  # optuna's word for a line that is no JSON
        raise InputError(
            f"{journal}: is no journal of a study, or torn: {error}; name another file with -o"
        ) from error


@final
class JournalLock:
    """Lets one process at a time write a journal; the system unlocks for a process that was killed.

    Optuna's own locks are files, which a killed process leaves behind.
    """

    def __init__(self, journal: Path) -> None:
        self._file = journal.with_name(f"{journal.name}.lock")
        self._handle = -1

    def acquire(self) -> bool:
        """Wait for the lock."""
        self._handle = os.open(self._file, os.O_CREAT | os.O_RDWR, 0o666)
        fcntl.flock(self._handle, fcntl.LOCK_EX)
        return True

    def release(self) -> None:
        """Let others have it."""
        os.close(self._handle)
