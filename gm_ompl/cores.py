"""Compiled work on both cores: it runs without the interpreter's lock."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Final

THREADS: Final = 2
"""Work is shared out among so many threads."""


def share_out(work: Callable[[slice], None], count: int, least: int = 1) -> None:
    """Do ``work`` on items 0 to ``count``, its parts at once.

    Args:
        work: does one part of the items.
        count: number of items.
        least: a part with fewer items is not worth a thread.
    """
    parts = max(1, min(THREADS, count // least))
    ends = [count * part // parts for part in range(parts + 1)]
    slices = [slice(*pair) for pair in itertools.pairwise(ends)]
    if parts == 1:
        work(slices[0])
        return
    from concurrent.futures import ThreadPoolExecutor  # most searches need no threads

    with ThreadPoolExecutor(parts) as threads:
        for done in [threads.submit(work, part) for part in slices]:
            done.result()
