"""What every planner shares: budget, outcome, progress, and the one method ``solve``."""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, TypeAlias, final

import numpy as np

from gm_ompl import clock, limits
from gm_ompl.feasibility.judge import Judge
from gm_ompl.limits import Limits
from gm_ompl.planners.parameters import Parameter, checked
from gm_ompl.problem import Fingers, Move, Problem


class Status(enum.Enum):
    """How a search ended; the value is the word that plan files use."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    BUDGET = "budget"
    INTERRUPTED = "interrupted"

    @property
    def sentence(self) -> str:
        """What the status means, for the user."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.SOLVED: "a plan was found",
    Status.INFEASIBLE: "it is proven that no plan exists on the scenario's lattice",
    Status.BUDGET: "the budget was spent: no plan was found, and none is ruled out",
    Status.INTERRUPTED: "the search was interrupted",
}


@dataclass(frozen=True)
class Budget:
    """What a search may spend; None is no limit.

    Attributes:
        time_limit: wall time [s].
        max_iterations: iterations: node expansions, or a sampling planner's own iterations.
        memory_limit_mb: resident memory of the whole process [MiB].
        stop: asked now and then; True ends the search as if a limit were reached.
    """

    time_limit: float | None = None
    max_iterations: int | None = None
    memory_limit_mb: float | None = None
    stop: Callable[[], bool] | None = None

    def start(self) -> Meter:
        """Return a running meter of this budget."""
        return Meter(self)


@final
class Meter:
    """A budget being spent; its clock starts when it is made.

    Attributes:
        budget: likewise.
        elsewhere: iterations by other parts of the search.
    """

    def __init__(self, budget: Budget) -> None:
        self.budget, self.elsewhere = budget, 0
        self._started = clock.now()
        self._limits = Limits(budget.time_limit, budget.memory_limit_mb)

    def within(self, iterations: int) -> Meter:
        """Return a running meter of what is left of the time, for a part of the search."""
        seconds = self.budget.time_limit
        left = None if seconds is None else max(seconds - self.elapsed(), 1e-3)
        return Meter(replace(self.budget, max_iterations=iterations, time_limit=left))

    def elapsed(self) -> float:
        """Return the wall time since the start, without what compiling took [s]."""
        return clock.now() - self._started

    def spent(self, iterations: int = 0) -> bool:
        """Whether a limit is reached after ``iterations``, or one in force around the search is.

        Cheap enough for inner loops.
        """
        budget = self.budget
        most = budget.max_iterations
        if most is not None and self.elsewhere + iterations >= most:
            return True
        if budget.stop is not None and budget.stop():
            return True
        return self._limits.passed() or bool(limits.reached())


@dataclass(frozen=True)
class Progress:
    """An event that a running search emits now and then.

    Attributes:
        time: since the start [s].
        expanded: nodes expanded, or iterations.
        open: nodes waiting.
        mode_decisions: decisions of Sec. 3.4 asked for so far.
        cost: of the best plan known, or None.
        lower_bound: no plan is cheaper.
    """

    time: float
    expanded: int
    open: int
    mode_decisions: int
    cost: float | None
    lower_bound: float


Report: TypeAlias = Callable[[Progress], None]


def silent(_: Progress) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class PlannerSpecs:
    """What a planner can and cannot do; that arcs are one-way, all of them respect.

    Attributes:
        optimal: it proves (on the lattice) or approaches the optimum; else it stops at any plan.
        randomised: its result depends on the seed.
        free: it plans free motion, where a pose has no coordinates.
        anywhere: it places fingers between the grid's placements, where a scenario asks for that.
        anywhere_on_paths: likewise, but along paths alone.
    """

    optimal: bool
    randomised: bool
    free: bool = False
    anywhere: bool = False
    anywhere_on_paths: bool = False


@dataclass(frozen=True)
class SearchResult:
    """How a search ended and what it knows.

    Attributes:
        status: how it ended; SOLVED also when a budget was spent with a plan in hand.
        moves: the plan's arcs from start to goal; none without a plan.
        cost: their total, or None without a plan.
        lower_bound: no plan on the lattice is cheaper; +inf where it is proven that none exists
            there.
        optimal: whether the plan is proven optimal on the lattice.
        statistics: at least ``time_s``, ``expanded``, ``generated``, ``mode_decisions`` and
            ``history``, a list of [time, cost or None, bound].
        others: plans that were found before the best, as far as they are kept, the cheapest first.
        fingers: the hand whose placements the moves name, where that is not the problem's.
    """

    status: Status
    moves: tuple[Move, ...] = ()
    cost: float | None = None
    lower_bound: float = 0.0
    optimal: bool = False
    statistics: Mapping[str, Any] = field(default_factory=dict)
    others: tuple[tuple[Move, ...], ...] = ()
    fingers: Fingers | None = None


class Planner(ABC):
    """A way to find plans.

    Attributes:
        name: what users call it.
        specs: what it can and cannot do.
        parameters: its named settings, with ranges and defaults.
        settings: the value of each parameter.

    Args:
        given: values of parameters by name; defaults for the rest.

    Raises:
        InputError: a parameter is unknown, of the wrong type or out of range.
    """

    name: ClassVar[str]
    specs: ClassVar[PlannerSpecs]
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def __init__(self, given: Mapping[str, Any] | None = None) -> None:
        self.settings = checked(self.name, self.parameters, given or {})

    @abstractmethod
    def solve(
        self,
        problem: Problem,
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan.

        Args:
            problem: what to plan.
            judge: answers Sec. 4.2's questions about ``problem``.
            budget: what the search may spend.
            rng: the only source of randomness.
            report: called now and then with the search's progress.

        Raises:
            InputError: the planner cannot treat this problem; the message says why.
        """
