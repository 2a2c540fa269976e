"""The server that a comparison's runs are forked from; see ``forks``.

``python -m gm_ompl.study.server`` gets ready for ``{"planners": [...]}``. A run that had to load
compiled code is made again, so that no run's time holds compilation.
"""

from __future__ import annotations

import sys
from typing import Final, final

from gm_ompl.forks import Json, RunLimits, serve
from gm_ompl.study.task import Task, carry_out
from gm_ompl.study.warm import warm_up

COLD_TRIES: Final = 3
"""A run that had to load compiled code is made again at most until this many have been made."""


@final
class Runs:
    """Runs of a comparison."""

    tries = COLD_TRIES

    def prepare(self, request: Json) -> None:
        """Load what the planners use."""
        warm_up(request["planners"])

    def limits(self, task: Json) -> RunLimits:
        """Return the task's own limits."""
        return Task.from_dict(task).limits

    def carry_out(self, task: Json) -> Json:
        """Return what a record keeps of the run."""
        return carry_out(Task.from_dict(task))


def main() -> None:
    """Serve on the standard streams."""
    serve(Runs())


if __name__ == "__main__":
    main()
    sys.exit(0)
