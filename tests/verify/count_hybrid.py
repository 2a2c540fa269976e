"""The project's own randomised planners: success, time to the first plan, cost, honesty."""

from __future__ import annotations

import functools

import gm_ompl
from gm_ompl.planfile.model import Plan
from tests.verify.counting import Result, count

OPTIMA = {
    "slide": (15.02468, 0), "push": (15.06489, 0), "tumble": (10.26390, 0),
    "regrasp": (117.39199, 1),
}  # fmt: skip
"""Proven by A*: cost and number of regrasps."""

PLANNERS = (
    "HybridRRT", "HybridRRTConnect", "HybridRRTstar", "RRT", "RRTConnect", "RRTstar",
    "InformedRRTstar", "SORRTstar", "BITstar", "FMT", "KPIECE1",
)  # fmt: skip
"""The project's own, and OMPL's that are sound for one-way motion."""

FAMILIES = ("slide", "push", "tumble", "regrasp", "chain", "planar", "small")


@functools.cache
def _warm() -> None:
    """Load the compiled kernel: instances are timed without it."""
    gm_ompl.plan("paper/slide", "HybridRRTConnect", max_iterations=50)


def _paper(problem: str, planner: str, seed: int) -> Plan:
    _warm()
    return gm_ompl.plan(f"paper/{problem}", planner, time_limit=10.0, seed=seed)


def _first(problem: str, planner: str) -> None:
    def run(instance: int) -> Result:
        plan = _paper(problem, planner, instance)
        return Result(plan.status == "solved", plan.statistics.time_s, f"{plan.status}")

    run.__name__ = f"first_plan_{problem}_{planner}"
    run.__doc__ = f"{planner} solves paper/{problem} within 10 s (worst: seconds)."
    count(instances=100)(run)


def _best(problem: str) -> None:
    cost, regrasps = OPTIMA[problem]

    def run(instance: int) -> Result:
        plan = _paper(problem, "HybridRRTstar", instance)
        if plan.cost is None:
            return Result(False, None, plan.status)
        ratio = plan.cost / cost
        holds = ratio <= 1.01 and plan.regrasps == regrasps
        return Result(holds, ratio, f"cost {plan.cost}, {plan.regrasps} regrasps")

    run.__name__ = f"best_plan_{problem}"
    run.__doc__ = (
        f"HybridRRTstar plans paper/{problem} in 10 s with the optimal number of regrasps at "
        "1.01 times the optimal cost (worst: times)."
    )
    count(instances=100)(run)


for _problem in OPTIMA:
    for _planner in ("HybridRRT", "HybridRRTConnect"):
        _first(_problem, _planner)
    _best(_problem)


@count(instances=1000)
def sampled_plans_hold(instance: int) -> Result:
    """No plan of any randomised planner on a random scenario fails the check."""
    planner = PLANNERS[instance % len(PLANNERS)]
    family = FAMILIES[instance // len(PLANNERS) % len(FAMILIES)]
    name = f"random/{family}/{instance}"
    plan = gm_ompl.plan(name, planner, time_limit=2.0, seed=instance)
    note = f"{name}, {planner}: {plan.status}"
    if plan.status != "solved":
        return Result(True, None, note, outcome=f"{planner} none")
    report = gm_ompl.check(plan)
    return Result(report.holds, None, f"{note} {report.table()}", outcome=f"{planner} solved")
