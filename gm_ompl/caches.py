"""What is kept because it may be asked for again: one bound on all of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeVar, final

MOST_BYTES: Final = 100_000_000
"""What one memo may hold."""

LEAST: Final = 64
"""Entries kept, however large they are."""

Key = TypeVar("Key")
Value = TypeVar("Value")


def kept(each: int) -> int:
    """Return how many entries of ``each`` bytes are kept."""
    return max(LEAST, MOST_BYTES // each)


@final
class Memo(dict[Key, Value]):
    """Values by key; when it is full it is emptied, and filled anew on demand.

    Args:
        each: about the bytes of an entry.
    """

    def __init__(self, each: int) -> None:
        super().__init__()
        self._most = kept(each)

    def of(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of ``key``, made where it is not known."""
        known = self.get(key)
        if known is None:
            known = self[key] = make()
        return known

    def __setitem__(self, key: Key, value: Value) -> None:
        if len(self) >= self._most:
            self.clear()
        super().__setitem__(key, value)
