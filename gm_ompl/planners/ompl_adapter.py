"""gm_ompl's own planners as planners of OMPL."""

from __future__ import annotations

from typing import Any, final

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl_path import states_of
from gm_ompl.planners.ompl_trace import Grown
from gm_ompl.planners.planner import Budget, Planner, Report, SearchResult, Status, silent
from gm_ompl.sampling.motions import ContinuousModel, HybridState
from gm_ompl.space.convert import Codec
from gm_ompl.space.guard import Guard
from gm_ompl.space.planner_data import Tree

_ENDS = {
    Status.SOLVED: "EXACT_SOLUTION",
    Status.INFEASIBLE: "INFEASIBLE",
    Status.BUDGET: "TIMEOUT",
    Status.INTERRUPTED: "ABORT",
}


@final
class PlainPlanner(ob.Planner):
    """A planner that knows nothing of OMPL, offered to it.

    Args:
        si: OMPL's space information.
        planner: who searches.
        judge: answers about the problem.
        codec: what states mean.
        guard: keeps exceptions.
        rng: the only source of randomness.

    Attributes:
        planner: likewise.
        result: what the last search found, or None.
    """

    def __init__(
        self,
        si: Any,
        planner: Planner,
        judge: Judge,
        codec: Codec,
        guard: Guard,
        rng: np.random.Generator,
    ) -> None:
        super().__init__(si, planner.name)
        self.planner = planner
        self.result: SearchResult | None = None
        self._grown = Grown()
        self._judge, self._codec, self._guard, self._rng = judge, codec, guard, rng

    def clear(self) -> None:
        """Forget the last search."""
        super().clear()
        self.result, self._grown = None, Grown()

    def solve(self, stop: Any) -> Any:
        """Search until ``stop``; hand a path to OMPL where one was found.

        Args:
            stop: OMPL's termination condition, or seconds.
        """
        try:
            status = self._search(stop)
        except BaseException as error:
            self._guard.keep(error)
            status = "ABORT"
        return ob.PlannerStatus(getattr(ob.PlannerStatus, status))

    def _search(self, stop: Any) -> str:
        limit = stop if callable(stop) else ob.timedPlannerTerminationCondition(float(stop))
        self.checkValidity()
        problem = self._judge.problem
        budget = Budget(stop=lambda: bool(limit()))
        self._grown = Grown()
        heard: Report = self._grown if self.planner.specs.randomised else silent
        self.result = self.planner.solve(problem, self._judge, budget, self._rng, heard)
        if self.result.status is Status.SOLVED:
            self._offer(states_of(self._codec.start, self.result.moves))
        return _ENDS[self.result.status]

    def _offer(self, states: list[HybridState]) -> None:
        pdef = self.getProblemDefinition()
        pdef.clearSolutionPaths()  # OMPL would rank by length in the space, not by cost
        si = self.getSpaceInformation()
        path, state = og.PathGeometric(si), si.allocState()
        for meaning in states:
            self._codec.write(state, meaning)
            path.append(state)  # a copy
        pdef.addSolutionPath(path, False, 0.0, self.getName())

    def tree(self) -> Tree:
        """Return what the last search explored; of a search on the lattice, its plan.

        Not an override of ``getPlannerData``: called from C++, that would end the process.
        """
        moves = self.result.moves if self.result is not None else ()
        model = ContinuousModel(self._judge.problem, self._judge)
        return self._grown.tree(model, self._codec.start, moves)
