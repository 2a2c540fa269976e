"""``python -m docs.tables.free_comparison``: planners side by side on free motion.

Runs are made as for ``comparison``.

Ten minutes on two cores; goes on where it was stopped.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from docs.tables.comparison import Comparison, marked, produce
from docs.tables.pages import write_tables

DESIGN = Comparison(
    single=("tasks/placedown", "tasks/reorient", "tasks/flip-cube", "free/stairs"),
    families=("random/free", "random/free-clutter"),
    planners=("astar", "HybridRRT", "HybridRRTConnect", "HybridRRTstar",
              "RRT", "RRTConnect", "RRTstar", "BITstar"),
    seeds=4,
    time_limit=10.0,
)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Make what is missing and write the tables into the page."""
    return produce("free-comparison", DESIGN, arguments, lambda _design, page, shown, best:
                   write_tables(page, marked(shown, best)))  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
