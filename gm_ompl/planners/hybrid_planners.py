"""The project's own randomised planners, over the object's motion and sets of placements."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from collections import deque
from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.spots import NamedPoints
from gm_ompl.planners.growth import Growth
from gm_ompl.planners.impossible import impossible
from gm_ompl.planners.outcome import Log, result_of, without_search
from gm_ompl.planners.parameters import Parameter, parameters_of
from gm_ompl.planners.planner import (
    Budget,
    Planner,
    PlannerSpecs,
    Report,
    SearchResult,
    Status,
    silent,
)
from gm_ompl.planners.trace import tracer
from gm_ompl.problem import Move, Problem
from gm_ompl.sampling.anytime import Anytime
from gm_ompl.sampling.anywhere import AnywhereSearch, Search
from gm_ompl.sampling.explorer import Explorer, FirstPlan
from gm_ompl.sampling.placing import Placing
from gm_ompl.sampling.settings import ExploringSettings, ImprovingSettings
from gm_ompl.sampling.stages import Refinement

KEPT = 8
"""Plans that a search hands out, the best included."""


def searched(search: Search, log: Log, growth: Growth | None, patience: int | None) -> SearchResult:
    """Search until the budget is spent, or for ``patience`` iterations in vain with a plan.

    Args:
        search: goes on an iteration at a time.
        log: told of the progress; its budget is spent.
        growth: told of every branch and plan, where somebody listens.
        patience: None is endless.
    """
    status, done, last = Status.BUDGET, 0, 0
    plans = deque[tuple[Move, ...]](maxlen=KEPT)

    def stop() -> bool:
        return log.meter.spent(done)

    def event() -> None:
        log.event(search.cost, 0.0, done, search.branches)

    try:
        while not stop():
            changed = search.step(stop)
            done += 1
            if changed:
                last = done
                plans.appendleft(search.moves)
            if growth is not None:
                growth.grown(search.courses)
                if changed:
                    growth.planned(search.moves)
            if changed or log.due():
                event()
            if patience is not None and search.cost < math.inf and done - last >= patience:
                break
    except LimitError:
        pass  # in the middle of an iteration: what was found before stands
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    if status is Status.BUDGET and search.cost < math.inf:
        status = Status.SOLVED
    event()
    statistics = log.statistics(done, search.branches)
    result = result_of(status, search.cost, 0.0, search.moves, statistics)
    others = tuple(moves for moves in plans if moves is not search.moves)
    return dataclasses.replace(result, others=others)


class HybridPlanner(Planner):
    """A planner that searches an iteration at a time; what it searches by is left open."""

    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan; see ``Planner.solve``.

        Without a limit on time or iterations, a search for ever better plans ends ``patience``
        iterations after the last improvement.
        """
        if problem.fingers.anywhere is not None:
            return self._anywhere(problem, judge, budget, rng, report)
        log, trace = Log(budget.start(), judge, report), tracer(report)
        growth = None if trace is None else Growth(problem, trace)
        try:
            if impossible(problem, judge):
                return without_search(Status.INFEASIBLE, math.inf, log.meter)
            search = self.make_search(judge, rng)
        except LimitError as stopped:
            return without_search(Status.BUDGET, 0.0, log.meter, str(stopped))
        except KeyboardInterrupt:
            return without_search(Status.INTERRUPTED, 0.0, log.meter)
        return searched(search, log, growth, self._patience(budget))

    def _anywhere(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report,
    ) -> SearchResult:
        """Search with fingers anywhere on the faces; no proof that there is no plan is tried."""
        placing = Placing(judge)
        log = Log(budget.start(), placing, report)
        search = AnywhereSearch(
            placing, problem, lambda judge, moves: self.make_search(judge, rng, moves), rng
        )
        result = searched(search, log, None, self._patience(budget))
        # Of all points that plans named on the way, those are kept that are still named.
        named, table = NamedPoints(problem.fingers), search.table
        moves = named.named(result.moves, table)
        others = tuple(named.named(other, table) for other in result.others)
        return dataclasses.replace(result, moves=moves, others=others, fingers=named.fingers)

    def _patience(self, budget: Budget) -> int | None:
        """Return after how many iterations in vain a search with a plan ends; None is never."""
        limited = budget.time_limit is not None or budget.max_iterations is not None
        return None if self.specs.optimal and limited else int(self.settings.get("patience", 0))

    @abstractmethod
    def make_search(
        self, judge: Judge, rng: np.random.Generator, moves: Sequence[Move] = ()
    ) -> Search:
        """Return the search, from a plan on where there is one."""


class FirstPlanPlanner(HybridPlanner):
    """A search by one tree or two that ends with its first plan."""

    specs: ClassVar[PlannerSpecs] = PlannerSpecs(
        optimal=False, randomised=True, free=True, anywhere=True
    )
    parameters: ClassVar[tuple[Parameter, ...]] = parameters_of(ExploringSettings)
    two_trees: ClassVar[bool]

    def make_search(
        self,
        judge: Judge,
        rng: np.random.Generator,
        moves: Sequence[Move] = (),  # noqa: ARG002 (it ends with a plan)
    ) -> Search:
        """Return the search."""
        settings = ExploringSettings(**self.settings)
        return FirstPlan(judge, Explorer(judge, self.two_trees, settings, rng))


@final
class HybridRRT(FirstPlanPlanner):
    """One tree, from the start; stops at the first plan."""

    name: ClassVar[str] = "HybridRRT"
    two_trees: ClassVar[bool] = False


@final
class HybridRRTConnect(FirstPlanPlanner):
    """Two trees, from start and goal, both judged in the direction of execution."""

    name: ClassVar[str] = "HybridRRTConnect"
    two_trees: ClassVar[bool] = True


@final
class HybridRRTstar(HybridPlanner):
    """Two trees to a first plan, then ever better ones until the budget is spent."""

    name: ClassVar[str] = "HybridRRTstar"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(
        optimal=True, randomised=True, free=True, anywhere=True
    )
    parameters: ClassVar[tuple[Parameter, ...]] = parameters_of(ImprovingSettings)

    def make_search(
        self, judge: Judge, rng: np.random.Generator, moves: Sequence[Move] = ()
    ) -> Search:
        """Return a search that goes on from plan to plan."""
        search = Anytime(judge, ImprovingSettings(**self.settings), rng)
        if moves:
            search.begin(moves)
        return search


def refine(
    problem: Problem,
    judge: Judge,
    moves: Sequence[Move],
    budget: Budget,
    rng: np.random.Generator,
) -> tuple[Move, ...]:
    """Return a plan that is at most as dear as ``moves``, judged anew; see ``sampling.refine``.

    Ctrl-C ends the refinement and returns the best plan so far.

    Args:
        problem: what was planned.
        judge: answers about it.
        moves: a plan from start to goal.
        budget: what may be spent; an iteration is one random change.
        rng: the source of randomness.
    """
    if not moves:
        return ()
    meter, tried = budget.start(), 0
    refinement = Refinement(problem, judge, moves, rng)
    try:
        refinement.tidy(meter.spent)
        while not meter.spent(tried):
            refinement.step()
            tried += 1
    except (KeyboardInterrupt, LimitError):
        pass  # what was reached so far is kept
    return refinement.moves
