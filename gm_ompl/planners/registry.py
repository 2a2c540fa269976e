"""The planners by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gm_ompl.errors import UnknownPlannerError, UnsoundPlannerError
from gm_ompl.planners.hybrid_planners import HybridRRT, HybridRRTConnect, HybridRRTstar
from gm_ompl.planners.lattice_astar import AStar, Dijkstra
from gm_ompl.planners.ompl_planners import OMPL_PLANNERS
from gm_ompl.planners.ompl_soundness import UNSOUND
from gm_ompl.planners.planner import Planner

PLANNERS: dict[str, type[Planner]] = {
    "astar": AStar,
    "dijkstra": Dijkstra,
    "HybridRRT": HybridRRT,
    "HybridRRTConnect": HybridRRTConnect,
    "HybridRRTstar": HybridRRTstar,
    **{planner.name: planner for planner in OMPL_PLANNERS},
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
    if name in UNSOUND:
        raise UnsoundPlannerError(name, UNSOUND[name])
    if name not in PLANNERS:
        raise UnknownPlannerError(name, PLANNERS)
    return PLANNERS[name](parameters)
