"""What a lattice search proves where some mode decision could not be proven.

Such an arc is in no plan, so the plan found stands. But "optimal" and "infeasible" speak of all
arcs: a second search, in which every such arc is as good as can be, gives the bound.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.planners.outcome import PROVEN
from gm_ompl.planners.planner import SearchResult, Status


def bounded(judge: Judge, search: Callable[[], SearchResult]) -> SearchResult:
    """Return what ``search`` finds, claiming no more than the decisions it asked for allow."""
    backend, result = judge.backend, search()
    if not isinstance(backend, KernelBackend) or not backend.undecided:
        return result
    if not result.optimal and result.status is not Status.INFEASIBLE:
        return dataclasses.replace(result, lower_bound=0.0)
    backend.forget()
    backend.optimistic = True
    try:
        bound = search().lower_bound
    finally:
        backend.optimistic = False
        backend.forget()
    if result.status is Status.INFEASIBLE and bound < math.inf:
        return dataclasses.replace(result, status=Status.BUDGET, lower_bound=bound)
    optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
    return dataclasses.replace(result, lower_bound=bound, optimal=optimal)
