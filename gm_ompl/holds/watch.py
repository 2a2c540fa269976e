"""Preparations that take long listen to the budget, too."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

from gm_ompl.errors import LimitError

Stop: TypeAlias = Callable[[], bool]
"""Asked now and then; True ends what is going on."""

_Item = TypeVar("_Item")


def never() -> bool:
    """Never stop."""
    return False


def watched(items: Iterable[_Item], stop: Stop) -> Iterator[_Item]:
    """Yield ``items`` for as long as ``stop`` says no.

    Raises:
        LimitError: it said yes.
    """
    for item in items:
        if stop():
            raise LimitError
        yield item
