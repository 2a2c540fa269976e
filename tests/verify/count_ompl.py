"""OMPL's planners as a script sets them up: by their constructors, nothing else set."""

from __future__ import annotations

import functools
import time
from typing import Any

from ompl import geometric as og

import gm_ompl
from tests.verify.count_hybrid import OPTIMA
from tests.verify.counting import Result, count

PLANNERS = ("RRT", "RRTConnect", "RRTstar", "BITstar")

SECONDS = 5.0
"""Of CPU time, short cuts included; what machine code takes to load is not counted."""

FREE = {"tasks/ledge": 1.80487, "tasks/flip-cube": 9.52419, "free/over-there": 37.1219}
"""Least costs on the lattice; of the last, what HybridRRTstar finds: 31.6759 is the lattice's."""

FREE_SECONDS = 20.0
"""Of CPU time on free motion."""

DEAR = 3.0
"""Times the optimal cost: a plan is called dear beyond."""


@functools.cache
def _warm() -> None:
    """Load the compiled kernel: instances are timed without it."""
    gm_ompl.plan("paper/slide", "HybridRRTConnect", max_iterations=50)


def scripted(
    scenario: Any, planner: str, seed: int, most: float = SECONDS
) -> tuple[gm_ompl.Plan, float]:
    """Return the first plan of one of OMPL's planners, and the CPU time that it took [s]."""
    setup = gm_ompl.setup(scenario, seed=seed)
    setup.setPlanner(getattr(og, planner)(setup.getSpaceInformation()))
    setup.stop_at_first_plan()
    started = time.process_time()
    setup.solve(lambda: time.process_time() - started >= most)
    return gm_ompl.plan_from(setup), time.process_time() - started


def _script(problem: str, planner: str) -> None:
    optimum = OPTIMA[problem][0]

    def run(instance: int) -> Result:
        _warm()
        plan, seconds = scripted(f"paper/{problem}", planner, instance)
        if plan.cost is None:
            return Result(False, seconds, plan.status, outcome="none")
        ratio, report = plan.cost / optimum, gm_ompl.check(plan)
        outcome = f"at most {DEAR:.0f} times the optimum" if ratio <= DEAR else "dearer"
        note = f"{ratio:.3g} times the optimum, {plan.regrasps} regrasps, {seconds:.2f} s"
        return Result(report.holds, seconds, note, outcome=outcome)

    run.__name__ = f"script_{problem}_{planner}"
    run.__doc__ = (
        f"OMPL's {planner}, set up by a script without a range, plans paper/{problem} within 5 s "
        "of CPU time, and the plan passes the check (worst: seconds)."
    )
    count(instances=100)(run)


for _problem in ("tumble", "regrasp"):
    for _planner in PLANNERS:
        _script(_problem, _planner)


def _free(scenario: str, planner: str) -> None:
    least = FREE[scenario]

    def run(instance: int) -> Result:
        _warm()
        plan, seconds = scripted(scenario, planner, instance, FREE_SECONDS)
        if plan.cost is None:
            return Result(False, seconds, plan.status, outcome="none")
        ratio, holds = plan.cost / least, gm_ompl.check(plan).holds
        outcome = f"at most {DEAR:.0f} times the least known" if ratio <= DEAR else "dearer"
        note = f"{ratio:.3g} times the least known, {plan.regrasps} regrasps, {seconds:.2f} s"
        return Result(holds, seconds, note, outcome=outcome)

    run.__name__ = f"script_{scenario.split('/')[1].replace('-', '_')}_{planner}"
    run.__doc__ = (
        f"OMPL's {planner}, set up by a script without a range, plans {scenario} within 20 s of "
        "CPU time, and the plan passes the check (worst: seconds)."
    )
    count(instances=100)(run)


for _scenario in FREE:
    for _planner in PLANNERS:
        _free(_scenario, _planner)
