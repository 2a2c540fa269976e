"""The planners by name; each is loaded when it is asked for."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final

import numpy as np

from gm_ompl.arguments import kind_of
from gm_ompl.errors import InputError, UnknownPlannerError, UnsoundPlannerError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.free import FreeMotion
from gm_ompl.motion.path import PathMotion
from gm_ompl.planners.ompl.table import OMPL_PLANNERS, UNSOUND, Offer
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


def _ompl_planner(called: str, row: Offer) -> type[Planner]:
    """Return the planner that runs OMPL's ``called`` on the hybrid space."""

    class OmplPlanner(Planner):
        name: ClassVar[str] = called
        specs: ClassVar[PlannerSpecs] = PlannerSpecs(
            optimal=row.anytime, randomised=True, free=True
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


_HOMES: Final = {
    "astar": ("lattice_astar", "AStar"),
    "dijkstra": ("lattice_astar", "Dijkstra"),
    "HybridRRT": ("hybrid_planners", "HybridRRT"),
    "HybridRRTConnect": ("hybrid_planners", "HybridRRTConnect"),
    "HybridRRTstar": ("hybrid_planners", "HybridRRTstar"),
}
"""Module and class of the project's own planners: a search loads no other's code."""


class _Planners(Mapping[str, type[Planner]]):
    """The planners, the project's own first."""

    def __getitem__(self, name: str) -> type[Planner]:
        if name in OMPL_PLANNERS:
            return _ompl_planner(name, OMPL_PLANNERS[name])
        module, kind = _HOMES[name]
        planner: type[Planner] = getattr(importlib.import_module(f"{__package__}.{module}"), kind)
        return planner

    def __iter__(self) -> Iterator[str]:
        yield from (*_HOMES, *OMPL_PLANNERS)

    def __len__(self) -> int:
        return len(_HOMES) + len(OMPL_PLANNERS)


PLANNERS: Final = _Planners()


def is_exact(name: str) -> bool:
    """Whether ``name`` is a planner that draws nothing at random; False for one not known here."""
    planner = PLANNERS.get(name)
    return planner is not None and not planner.specs.randomised


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


def suited(planner: Planner, problem: Problem) -> None:
    """Refuse a planner that cannot plan a problem.

    Raises:
        InputError: the motion is free, and the planner needs coordinates; or fingers may be
            placed anywhere, and the planner knows the grid alone.
    """
    if problem.fingers.anywhere is not None and not roams(planner.specs, problem):
        where = "anywhere along paths" if planner.specs.anywhere_on_paths else "on the grid"
        able = [name for name, kind in PLANNERS.items() if roams(kind.specs, problem)]
        raise InputError(
            f"{planner.name} places fingers {where} alone; with fingers.placements.continuous "
            f"plan with {', '.join(able)}, or remove that key"
        )
    if planner.specs.free or not isinstance(problem.motion, FreeMotion):
        return
    raise InputError(
        f"{planner.name} plans along paths and in the plane; a planner that needs no coordinates "
        f"says so by specs.free, as all named ones do: {', '.join(PLANNERS)}"
    )


def roams(specs: PlannerSpecs, problem: Problem) -> bool:
    """Whether a planner places fingers between the grid's placements along a problem's motion."""
    on_path = isinstance(problem.motion, PathMotion)
    return specs.anywhere or (specs.anywhere_on_paths and on_path)
