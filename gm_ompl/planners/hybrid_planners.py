"""The project's own randomised planners, over the object's motion and sets of placements."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar, Protocol, final

import numpy as np

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.goals import has_set
from gm_ompl.holds.watch import Stop
from gm_ompl.planners.growth import Growth
from gm_ompl.planners.hybrid_settings import EXPLORING, IMPROVING, exploring, improving
from gm_ompl.planners.outcome import Log, result_of, without_search
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
from gm_ompl.planners.trace import tracer
from gm_ompl.problem import Move, Problem
from gm_ompl.sampling.anytime import Anytime
from gm_ompl.sampling.explorer import Course, Explorer
from gm_ompl.sampling.first_plan import FirstPlan
from gm_ompl.sampling.refine import Refinement


class Search(Protocol):
    """A search that goes on an iteration at a time."""

    cost: float
    moves: tuple[Move, ...]

    @property
    def branches(self) -> int:
        """How much it has gathered."""

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far, with the trees grown along them."""

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether the best plan changed."""


@final
class HybridRun:
    """One run of a randomised search.

    Args:
        judge: answers about the problem.
        budget: what may be spent.
        report: called now and then with the progress.

    Attributes:
        log: told of the progress.
    """

    def __init__(self, judge: Judge, budget: Budget, report: Report) -> None:
        self.log = Log(budget.start(), judge, report)
        trace = tracer(report)
        self._growth = None if trace is None else Growth(judge.problem, trace)
        self._iterations = 0

    def search(self, search: Search, patience: int | None) -> SearchResult:
        """Search until the budget is spent, or for ``patience`` iterations in vain with a plan."""
        status = Status.BUDGET
        try:
            self._loop(search, patience)
        except LimitError:
            pass  # in the middle of an iteration: what was found before stands
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        if status is Status.BUDGET and search.cost < math.inf:
            status = Status.SOLVED
        self._event(search)
        statistics = self.log.statistics(self._iterations, search.branches)
        return result_of(status, search.cost, 0.0, search.moves, statistics)

    def _loop(self, search: Search, patience: int | None) -> None:
        def stop() -> bool:
            return self.log.meter.spent(self._iterations)

        last = 0
        while not stop():
            changed = search.step(stop)
            self._iterations += 1
            if self._growth is not None:
                self._growth.grown(search.courses)
                if changed:
                    self._growth.planned(search.moves)
            if changed:
                last = self._iterations
                self._event(search)
            elif self.log.due():
                self._event(search)
            waited = self._iterations - last
            if patience is not None and search.cost < math.inf and waited >= patience:
                return

    def _event(self, search: Search) -> None:
        self.log.event(search.cost, 0.0, self._iterations, search.branches)


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
        run = HybridRun(judge, budget, report)
        try:
            if impossible(problem, judge):
                return without_search(Status.INFEASIBLE, math.inf, run.log.meter)
            search = self.make_search(judge, rng)
        except LimitError as stopped:
            return without_search(Status.BUDGET, 0.0, run.log.meter, str(stopped))
        except KeyboardInterrupt:
            return without_search(Status.INTERRUPTED, 0.0, run.log.meter)
        limited = budget.time_limit is not None or budget.max_iterations is not None
        anytime = self.specs.optimal and limited
        return run.search(search, None if anytime else int(self.settings.get("patience", 0)))

    @abstractmethod
    def make_search(self, judge: Judge, rng: np.random.Generator) -> Search:
        """Return the search."""


@final
class HybridRRT(HybridPlanner):
    """One tree, from the start; stops at the first plan."""

    name: ClassVar[str] = "HybridRRT"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(directed=True, optimal=False, randomised=True)
    parameters: ClassVar[tuple[Parameter, ...]] = EXPLORING

    def make_search(self, judge: Judge, rng: np.random.Generator) -> Search:
        """Return a search by one tree."""
        return FirstPlan(judge, Explorer(judge, False, exploring(self.settings), rng))


@final
class HybridRRTConnect(HybridPlanner):
    """Two trees, from start and goal, both judged in the direction of execution."""

    name: ClassVar[str] = "HybridRRTConnect"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(directed=True, optimal=False, randomised=True)
    parameters: ClassVar[tuple[Parameter, ...]] = EXPLORING

    def make_search(self, judge: Judge, rng: np.random.Generator) -> Search:
        """Return a search by two trees."""
        return FirstPlan(judge, Explorer(judge, True, exploring(self.settings), rng))


@final
class HybridRRTstar(HybridPlanner):
    """Two trees to a first plan, then ever better ones until the budget is spent."""

    name: ClassVar[str] = "HybridRRTstar"
    specs: ClassVar[PlannerSpecs] = PlannerSpecs(directed=True, optimal=True, randomised=True)
    parameters: ClassVar[tuple[Parameter, ...]] = IMPROVING

    def make_search(self, judge: Judge, rng: np.random.Generator) -> Search:
        """Return a search that goes on from plan to plan."""
        return Anytime(judge, improving(self.settings), rng)


def impossible(problem: Problem, judge: Judge) -> bool:
    """Whether it is proven that no plan exists: no set is valid at the start, or at the goal.

    A goal that is a region is not searched for proofs.
    """
    pose = problem.motion.pose
    if not has_set(judge, pose(problem.start), problem.fingers.start):
        return True
    low, high = problem.goal.low, problem.goal.high
    if None in low or low != high:
        return False
    goal = tuple(float(value or 0.0) for value in low)
    return not has_set(judge, pose(goal), problem.fingers.goal)


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
