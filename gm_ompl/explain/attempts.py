"""Searches that say whether there is a plan: on the lattice, off it, on a finer one."""

from __future__ import annotations

import copy
from typing import Any, final

import numpy as np

from gm_ompl.errors import ScenarioError
from gm_ompl.explain.values import Attempt
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.planner import Budget, Progress, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.scenario.scenario import Scenario

SAMPLER = "HybridRRTConnect"
"""The planner that is not bound to the lattice."""

SAMPLER_ITERATIONS = 2000
"""What it may spend at most, beside its time."""

LEAST_SECONDS = 0.01
"""A search's budget must be more than nothing."""


@final
class _Seen:
    """Hears of a search's progress; any plan is enough."""

    def __init__(self) -> None:
        self._planned = False

    def __call__(self, progress: Progress) -> None:
        """Take note of an event."""
        self._planned = self._planned or progress.cost is not None

    def planned(self) -> bool:
        """Whether a plan is known."""
        return self._planned


def search(
    problem: Problem,
    seconds: float,
    planner: str = "astar",
    seed: int = 0,
    max_iterations: int | None = None,
) -> Status:
    """Return how a search for any plan ends.

    Raises:
        InputError: the start or the goal is off the lattice.
        KeyboardInterrupt: it was interrupted.
    """
    judge, seen = Judge(problem, make_backend(problem)), _Seen()
    limits = Budget(max(seconds, LEAST_SECONDS), max_iterations, stop=seen.planned)
    rng = np.random.default_rng(seed)
    status = make_planner(planner).solve(problem, judge, limits, rng, seen).status
    if status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return status


def sampled(problem: Problem, lattice: Status, seconds: float, seed: int) -> Attempt:
    """Return what a sampler finds that may leave the lattice.

    Args:
        problem: the problem.
        lattice: how the search on the lattice ended.
        seconds: time limit.
        seed: of the sampler.
    """
    status = search(problem, seconds, SAMPLER, seed, SAMPLER_ITERATIONS)
    off = " that is not on the lattice" if lattice is Status.INFEASIBLE else ""
    with_seed = f" --seed {seed}" if seed else ""
    sentence = {
        Status.SOLVED: f"a sampler finds a plan{off}: plan with --planner {SAMPLER}{with_seed}",
        Status.INFEASIBLE: "no lattice of the object's motion can help: at the start or at the "
        "goal no set of placements is geometrically possible",
    }.get(status, f"a sampler ({SAMPLER}) finds none in its time, which proves nothing")
    return Attempt("sampler", status.value, sentence)


def finer(scenario: Scenario, seconds: float) -> Attempt | None:
    """Return what a search on a lattice twice as fine finds; None where there can be no such."""
    change, tree = _twice_as_fine(scenario)
    try:
        problem = Scenario.from_resolved(tree).problem
    except ScenarioError:  # more nodes than can be numbered
        return None
    status = search(problem, seconds)
    sentence = {
        Status.SOLVED: f"a lattice twice as fine has a plan: --set {change}",
        Status.INFEASIBLE: "a lattice twice as fine has none either, which is proven",
    }.get(status, "whether a lattice twice as fine has one was not settled in its time")
    return Attempt("finer lattice", status.value, sentence, change)


def _twice_as_fine(scenario: Scenario) -> tuple[str, dict[str, Any]]:
    """Return the change as for --set, and the scenario's tree with it."""
    tree = copy.deepcopy(scenario.resolved())
    steps = scenario.model.lattice.steps
    if steps is None:
        tree["lattice"]["segments"] = [2 * n for n in tree["lattice"]["segments"]]
        return f"lattice.segments={tree['lattice']['segments']}", tree
    halves = {"x": steps.x / 2, "y": steps.y / 2, "yaw": f"{steps.yaw / 2!r} rad"}
    tree["lattice"]["steps"] = halves
    shown = ", ".join(f"{key}: {value}" for key, value in halves.items())
    return f"lattice.steps={{{shown}}}", tree
