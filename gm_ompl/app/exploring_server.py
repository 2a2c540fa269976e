"""The server that runs are forked from; see ``forks``.

``python -m gm_ompl.app.exploring_server`` gets ready for ``{"scenario": NAME, "overrides":
[...]}``: the
scenario is loaded, planned and drawn once, so that its runs find everything compiled.
"""

from __future__ import annotations

import gc
import os
import sys
from typing import Final, final

import gm_ompl
from gm_ompl.app.exploring_answers import BaseScenario, answer, ground, mapped
from gm_ompl.exploring.planners import EXACT, SAMPLED
from gm_ompl.forks import Json, RunLimits, serve

WARMING_S: Final = 3.0  # each search that warms the server takes no longer, compiling aside [s]


@final
class Answers:
    """Runs of one scenario."""

    tries = 1  # somebody is waiting

    def __init__(self) -> None:
        self._ground: BaseScenario | None = None

    def prepare(self, request: Json) -> None:
        """Load the scenario, and what planning and drawing it needs."""
        scenario = gm_ompl.load(request["scenario"], request["overrides"])
        self._ground = ground(scenario, EXACT, WARMING_S)
        sampled = {"planner": SAMPLED, "time_s": WARMING_S, "memory_mb": None}
        answer(self._ground, {"settings": [], **sampled})
        gc.collect()
        gc.freeze()  # what all runs share is not to be looked through, and so copied, in each

    def limits(self, task: Json) -> RunLimits:
        """Return what a run may spend."""
        return RunLimits(task["time_s"], task["memory_mb"])

    def carry_out(self, task: Json) -> Json:
        """Return the answer."""
        assert self._ground is not None
        os.nice(task["niceness"])
        return (mapped if "instant" in task else answer)(self._ground, task)


def main() -> None:
    """Serve on the standard streams."""
    serve(Answers())


if __name__ == "__main__":
    main()
    sys.exit(0)
