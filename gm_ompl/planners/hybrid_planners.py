"""The project's own randomised planners, over the object's motion and sets of placements."""

from __future__ import annotations

import math
from typing import ClassVar, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.hybrid_run import HybridRun, impossible
from gm_ompl.planners.hybrid_settings import EXPLORING, IMPROVING, exploring, improving
from gm_ompl.planners.outcome import without_search
from gm_ompl.planners.parameters import Parameter
from gm_ompl.planners.planner import (
    Budget,
    Planner,
    PlannerSpecs,
    Report,
    SearchResult,
    Status,
    silent,
)
from gm_ompl.problem import Problem
from gm_ompl.sampling.anytime import Anytime
from gm_ompl.sampling.explorer import Explorer
from gm_ompl.sampling.first_plan import FirstPlan

_FIRST = PlannerSpecs(directed=True, optimal=False, randomised=True)


@final
class HybridRRT(Planner):
    """One tree, from the start; stops at the first plan."""

    name: ClassVar[str] = "HybridRRT"
    specs: ClassVar[PlannerSpecs] = _FIRST
    parameters: ClassVar[tuple[Parameter, ...]] = EXPLORING

    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan; see ``Planner.solve``."""
        return _first_plan(self, problem, judge, budget, rng, report, two_trees=False)


@final
class HybridRRTConnect(Planner):
    """Two trees, from start and goal, both judged in the direction of execution."""

    name: ClassVar[str] = "HybridRRTConnect"
    specs: ClassVar[PlannerSpecs] = _FIRST
    parameters: ClassVar[tuple[Parameter, ...]] = EXPLORING

    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan; see ``Planner.solve``."""
        return _first_plan(self, problem, judge, budget, rng, report, two_trees=True)


def _first_plan(
    planner: Planner,
    problem: Problem,
    judge: Judge,
    budget: Budget,
    rng: np.random.Generator,
    report: Report,
    two_trees: bool,
) -> SearchResult:
    run = HybridRun(judge, budget, report)
    try:
        if impossible(problem, judge):
            return without_search(Status.INFEASIBLE, math.inf, run.meter)
        explorer = Explorer(judge, two_trees, exploring(planner.settings), rng)
        search = FirstPlan(judge, explorer)
    except KeyboardInterrupt:
        return without_search(Status.INTERRUPTED, 0.0, run.meter)
    return run.until_first(search)


@final
class HybridRRTstar(Planner):
    """Two trees to a first plan, then ever better ones until the budget is spent."""

    name: ClassVar[str] = "HybridRRTstar"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(directed=True, optimal=True, randomised=True)
    parameters: ClassVar[tuple[Parameter, ...]] = IMPROVING

    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for ever better plans; see ``Planner.solve``.

        Without a limit on time or iterations, it ends ``patience`` iterations after the last
        improvement.
        """
        run = HybridRun(judge, budget, report)
        try:
            if impossible(problem, judge):
                return without_search(Status.INFEASIBLE, math.inf, run.meter)
            search = Anytime(judge, improving(self.settings), rng)
        except KeyboardInterrupt:
            return without_search(Status.INTERRUPTED, 0.0, run.meter)
        unlimited = budget.time_limit is None and budget.max_iterations is None
        return run.improve(search, int(self.settings["patience"]) if unlimited else None)
