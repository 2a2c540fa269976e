"""The planners by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from gm_ompl.arguments import kind_of
from gm_ompl.errors import UnknownPlannerError, UnsoundPlannerError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.hybrid_planners import HybridRRT, HybridRRTConnect, HybridRRTstar
from gm_ompl.planners.lattice_astar import AStar, Dijkstra
from gm_ompl.planners.ompl.table import OMPL_PLANNERS, UNSOUND, Row
from gm_ompl.planners.parameters import Parameter
from gm_ompl.planners.planner import (
    Budget,
    Planner,
    PlannerSpecs,
    Report,
    SearchResult,
    silent,
)
from gm_ompl.problem import Problem


def _ompl_planner(called: str, row: Row) -> type[Planner]:
    """Return the planner that runs OMPL's ``called`` on the hybrid space."""

    class OmplPlanner(Planner):
        name: ClassVar[str] = called
        specs: ClassVar[PlannerSpecs] = PlannerSpecs(
            directed=True, optimal=row.anytime, randomised=True
        )
        parameters: ClassVar[tuple[Parameter, ...]] = row.parameters

        def solve(
            self,
            problem: Problem,  # noqa: ARG002 (the judge knows it)
            judge: Judge,
            budget: Budget,
            rng: np.random.Generator,
            report: Report = silent,
        ) -> SearchResult:
            """Search for a plan, judged anew; an iteration is OMPL's question whether to stop.

            A planner that improves its plan stops at the first one where ``budget`` has neither
            a time limit nor an iteration limit.
            """
            from gm_ompl.planners.ompl.run import run  # loads OMPL

            return run(self, judge, budget, rng, report)

    OmplPlanner.__name__, OmplPlanner.__doc__ = called, row.meaning
    return OmplPlanner


PLANNERS: dict[str, type[Planner]] = {
    "astar": AStar,
    "dijkstra": Dijkstra,
    "HybridRRT": HybridRRT,
    "HybridRRTConnect": HybridRRTConnect,
    "HybridRRTstar": HybridRRTstar,
    **{name: _ompl_planner(name, row) for name, row in OMPL_PLANNERS.items()},
}


def make_planner(name: str, parameters: Mapping[str, Any] | None = None) -> Planner:
    """Return the planner called ``name``.

    Args:
        name: the planner's name.
        parameters: values of its parameters; defaults for the rest.

    Raises:
        UnknownPlannerError: there is none of that name.
        UnsoundPlannerError: OMPL has it, but it ignores that motions are one-way.
        InputError: a parameter is unknown, of the wrong type or out of range.
    """
    if not isinstance(name, str):
        raise UnknownPlannerError(kind_of(name), PLANNERS)
    if name in UNSOUND:
        raise UnsoundPlannerError(name, UNSOUND[name])
    if name not in PLANNERS:
        raise UnknownPlannerError(name, PLANNERS)
    return PLANNERS[name](parameters)
