"""Counts on robot hands: plans by HybridRRTConnect, and how the simulated robot does them."""

from __future__ import annotations

import functools
import time

import gm_ompl
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.execute import execute, prepare
from tests.verify.counting import Result, count

SCENARIOS = ("trifinger-push", "trifinger-flip", "trifinger-clutter", "arm-tumble")
PLANNER = "HybridRRTConnect"
LIMIT = 60.0
"""Wall time per plan [s]."""

NEAR, TURNED = 3e-3, 2.0
"""How far the object may be off [m], [deg]."""


@functools.cache
def _warm(name: str) -> None:
    """Load the compiled kernel: instances are timed without it."""
    gm_ompl.plan(name, PLANNER, seed=0)


def _plan(name: str, instance: int) -> Plan:
    """Return astar's plan for instance 0, else the randomised planner's with that seed."""
    if instance == 0:
        return gm_ompl.plan(name, "astar")
    return gm_ompl.plan(name, PLANNER, time_limit=LIMIT, seed=instance)


def _first_plan(name: str) -> None:
    def run(instance: int) -> Result:
        _warm(name)
        began = time.process_time()
        plan = gm_ompl.plan(name, PLANNER, time_limit=LIMIT, seed=instance)
        seconds = time.process_time() - began
        if plan.status != "solved":
            return Result(False, seconds, plan.status, outcome=plan.status)
        report = gm_ompl.check(plan)
        outcome = "within 10 s" if seconds <= 10.0 else "later"
        note = "" if report.holds else report.table()
        return Result(report.holds, seconds, note, outcome=outcome)

    run.__name__ = f"robot_plans_{name.split('/')[1].replace('-', '_')}"
    run.__doc__ = (
        f"{PLANNER} plans {name}, joint paths included, within {LIMIT:g} s, and `check` confirms "
        "it (outcomes and worst: seconds of CPU time for the plan)."
    )
    count(instances=100)(run)


def _executed(name: str) -> None:
    def run(instance: int) -> Result:
        plan = _plan(name, instance)
        if plan.status != "solved":
            return Result(False, None, plan.status, outcome=plan.status)
        report = execute(prepare(plan))
        near = max(report.end_position, report.position)
        turned = max(report.end_angle, report.angle)
        most = max(report.torque.values())
        asked = near <= NEAR and turned <= TURNED and most <= 1.0 and not report.touching
        note = f"seed {instance}: {report.table()}"
        return Result(asked and report.holds, 1e3 * near, note)

    run.__name__ = f"robot_executes_{name.split('/')[1].replace('-', '_')}"
    run.__doc__ = (
        f"The simulated robot does {name}, astar's plan and {PLANNER}'s by 20 seeds: the object "
        f"within {1e3 * NEAR:g} mm and {TURNED:g} degrees throughout, torques and speeds within "
        "limits, no link but fingertips touches anything (worst: mm off)."
    )
    count(instances=21)(run)


for _name in SCENARIOS:
    _first_plan(f"robot/{_name}")
    _executed(f"robot/{_name}")
