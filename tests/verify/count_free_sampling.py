"""The project's own randomised planners on free motion: success, time, cost, honesty."""

from __future__ import annotations

import functools
import time

import numpy as np

import gm_ompl
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.scenario.load import load
from tests.verify.counting import Result, count

SCENARIOS = (
    "tasks/bookshelf", "tasks/corner-pivot", "tasks/flip-cube", "tasks/ledge",
    "tasks/peg-thin-fingers", "tasks/pick-card", "tasks/pick-card-soft", "tasks/placedown",
    "tasks/reorient", "tasks/reorient-one-finger", "tasks/step-over",
    "free/around", "free/l-bracket", "free/out-of-the-corner", "free/over-there", "free/stairs",
)  # fmt: skip

OPTIMA = {
    "tasks/reorient": (2.86367719, 0), "tasks/flip-cube": (9.52419, 1),
    "tasks/placedown": (3.49497, 0), "tasks/reorient-one-finger": (8.70161, 1),
    "free/around": (16.0281, 0), "free/l-bracket": (0.0634115, 0),
    "free/out-of-the-corner": (30.3082, 1), "free/stairs": (15.8984, 1),
}  # fmt: skip
"""Least cost on the contact lattice and its regrasps, proven by astar; off it may be cheaper."""

DEAR = 1.02
"""Times the least cost on the lattice: a plan is called dear beyond."""

SECONDS, SECONDS_BEST = 20.0, 5.0
"""Of CPU time, to the first plan, and for better ones; steady control is not counted."""


@functools.cache
def _warm() -> None:
    """Load the compiled code: instances are timed without it."""
    gm_ompl.plan("tasks/reorient", "HybridRRTConnect", max_iterations=50)


def solve(
    scenario: str, planner: str, seed: int, most: float = SECONDS
) -> tuple[float | None, int, float]:
    """Return the cost of a planner's plan, its regrasps and the CPU time [s]."""
    _warm()
    problem, started = load(scenario).problem, time.process_time()
    judge = Judge(problem, make_backend(problem))
    budget = Budget(stop=lambda: time.process_time() - started >= most)
    # A search for ever better plans without another limit ends by its patience.
    settings = {"patience": 10_000_000} if planner == "HybridRRTstar" else {}
    searcher = make_planner(planner, settings)
    found = searcher.solve(problem, judge, budget, np.random.default_rng(seed))
    regrasps = sum(not hasattr(move, "segments") for move in found.moves)
    return found.cost, regrasps, time.process_time() - started


def _first(scenario: str, planner: str) -> None:
    def run(instance: int) -> Result:
        cost, regrasps, seconds = solve(scenario, planner, instance)
        note = f"cost {cost}, {regrasps} regrasps, {seconds:.2f} s"
        return Result(cost is not None, seconds, note)

    run.__name__ = f"free_first_{scenario.split('/')[1].replace('-', '_')}_{planner}"
    run.__doc__ = f"{planner} plans {scenario} within 20 s of CPU time (worst: seconds)."
    count(instances=100)(run)


def _best(scenario: str) -> None:
    least, most = OPTIMA[scenario]

    def run(instance: int) -> Result:
        cost, regrasps, _ = solve(scenario, "HybridRRTstar", instance, SECONDS_BEST)
        if cost is None:
            return Result(False, None, "no plan", outcome="none")
        ratio = cost / least
        outcome = f"at most {DEAR} times the optimum" if ratio <= DEAR else "dearer"
        return Result(regrasps <= most, ratio, f"cost {cost}, {regrasps} regrasps", outcome=outcome)

    run.__name__ = f"free_best_{scenario.split('/')[1].replace('-', '_')}"
    run.__doc__ = (
        f"HybridRRTstar plans {scenario} in 5 s of CPU time with no more regrasps than the least "
        "cost on the lattice needs (worst: cost over that)."
    )
    count(instances=20)(run)


for _scenario in SCENARIOS:
    for _planner in ("HybridRRT", "HybridRRTConnect"):
        _first(_scenario, _planner)
    if _scenario in OPTIMA:
        _best(_scenario)


@count(instances=200)
def free_plans_hold(instance: int) -> Result:
    """No plan of the project's randomised planners on random free scenarios fails the check."""
    _warm()
    planner = ("HybridRRT", "HybridRRTConnect", "HybridRRTstar")[instance % 3]
    name = f"random/{'free-clutter' if instance % 2 else 'free'}/{instance // 2}"
    plan = gm_ompl.plan(name, planner, time_limit=3.0, seed=instance)
    solved = "solved" if plan.cost is not None else "none"
    holds = gm_ompl.check(plan).holds
    return Result(holds, note=f"{name} {planner}", outcome=f"{planner} {solved}")


PLANNERS = (
    "HybridRRT", "HybridRRTConnect", "HybridRRTstar", "RRT", "RRTConnect", "RRTstar",
    "InformedRRTstar", "SORRTstar", "BITstar", "FMT", "KPIECE1",
)  # fmt: skip


@count(instances=500)
def task_plans_hold(instance: int) -> Result:
    """No plan of any randomised planner on a task or another shipped free scenario fails."""
    _warm()
    scenario = SCENARIOS[instance % len(SCENARIOS)]
    planner = PLANNERS[instance // len(SCENARIOS) % len(PLANNERS)]
    plan = gm_ompl.plan(scenario, planner, time_limit=5.0, seed=instance)
    solved = "solved" if plan.cost is not None else "none"
    holds = gm_ompl.check(plan).holds
    return Result(holds, note=f"{scenario} {planner}", outcome=f"{planner} {solved}")
