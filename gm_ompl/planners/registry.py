"""The planners by name."""

from __future__ import annotations

from gm_ompl.errors import UnknownPlannerError
from gm_ompl.planners.lattice_astar import AStar, Dijkstra
from gm_ompl.planners.planner import Planner

PLANNERS: dict[str, type[Planner]] = {
    "astar": AStar,
    "dijkstra": Dijkstra,
}


def make_planner(name: str) -> Planner:
    """Return the planner called ``name``.

    Raises:
        UnknownPlannerError: there is none of that name.
    """
    if name not in PLANNERS:
        raise UnknownPlannerError(name, PLANNERS)
    return PLANNERS[name]()
