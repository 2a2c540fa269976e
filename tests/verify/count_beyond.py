"""The scenarios beyond one degree of freedom and one box, by the randomised planners."""

from __future__ import annotations

import functools

import gm_ompl
from tests.verify.counting import Result, count

SCENARIOS = (
    "planar/corner", "planar/corridor", "planar/turn",
    "shapes/hexagon", "shapes/l-bracket", "fingers/three",
)  # fmt: skip

PLANNER = "HybridRRTConnect"
LIMIT = 30.0
"""Wall time per plan [s]."""


@functools.cache
def _warm() -> None:
    """Load the compiled kernel: instances are timed without it."""
    gm_ompl.plan("planar/turn", PLANNER, max_iterations=50)


def _first_plan(name: str) -> None:
    def run(instance: int) -> Result:
        _warm()
        plan = gm_ompl.plan(name, PLANNER, time_limit=LIMIT, seed=instance)
        if plan.status != "solved":
            return Result(False, plan.statistics.time_s, plan.status)
        report = gm_ompl.check(plan)
        return Result(report.holds, plan.statistics.time_s, "" if report.holds else report.table())

    run.__name__ = f"beyond_{name.replace('/', '_').replace('-', '_')}"
    run.__doc__ = (
        f"{PLANNER} plans {name} within {LIMIT:g} s, and `check` confirms it (worst: seconds to "
        "the first plan)."
    )
    count(instances=100)(run)


for _name in SCENARIOS:
    _first_plan(_name)
