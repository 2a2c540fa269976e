"""HybridRRTstar on every shipped scenario, under iteration limits: the same on every machine."""

from __future__ import annotations

import gm_ompl
from gm_ompl.scenario.load import shipped
from tests.verify.counting import Result, count

PLANNER = "HybridRRTstar"
ITERATIONS = (60, 240, 960)
"""Tried in turn until a plan is found."""


def _solved(name: str) -> None:
    def run(instance: int) -> Result:
        for limit in ITERATIONS:
            plan = gm_ompl.plan(name, PLANNER, max_iterations=limit, seed=instance)
            if plan.status == "solved":
                report = gm_ompl.check(plan)
                return Result(report.holds, limit, "" if report.holds else report.table())
        return Result(False, None, f"seed {instance}: {plan.status}")

    run.__name__ = f"shipped_{name.replace('/', '_').replace('-', '_')}"
    run.__doc__ = (
        f"{PLANNER} plans {name} within {ITERATIONS[-1]} iterations, and `check` confirms it "
        "(worst: the iterations allowed)."
    )
    count(instances=100)(run)


for _name in shipped():
    if gm_ompl.load(_name).problem.motion.dimension:  # it does not plan free motion
        _solved(_name)
