"""Compiled work on both cores: it runs without the interpreter's lock."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from typing import Final

from gm_ompl import limits


def cores() -> int:
    """Return how many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # Linux alone tells which cores a process may use
        return os.cpu_count() or 1


A_FEW: Final = 4
"""Decisions that take longer than it takes to start a thread."""


def share_out(
    work: Callable[[slice], None], count: int, least: int = A_FEW, most: int | None = None
) -> None:
    """Do ``work`` on items 0 to ``count``, its parts at once.

    Args:
        work: does one part of the items.
        count: number of items.
        least: a part with fewer items is not worth a thread.
        most: items between two looks at the limits in force; None does all of them at once.

    Raises:
        LimitError: a limit in force is reached.
    """
    most = most or max(1, count)
    for first in range(0, count, most):
        limits.check()
        _share_out(work, first, min(count, first + most), least)


def _share_out(work: Callable[[slice], None], first: int, last: int, least: int) -> None:
    count = last - first
    parts = max(1, min(cores(), count // least))
    ends = [first + count * part // parts for part in range(parts + 1)]
    slices = [slice(*pair) for pair in itertools.pairwise(ends)]
    if parts == 1:
        work(slices[0])
        return
    from concurrent.futures import ThreadPoolExecutor  # most searches need no threads

    with ThreadPoolExecutor(parts - 1) as threads:
        others = [threads.submit(work, part) for part in slices[1:]]
        work(slices[0])
        for done in others:
            done.result()
