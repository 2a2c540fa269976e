"""One search by ``astar``: time, memory and what it did."""

from __future__ import annotations

import math
import multiprocessing
import resource
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from gm_ompl import api
from gm_ompl.problem import Problem
from gm_ompl.study.report import number


@dataclass(frozen=True)
class Measured:
    """What one search cost."""

    status: str  # how it ended
    optimal: bool  # whether it proved its plan optimal
    cost: float | None  # of the plan
    expanded: int  # nodes (or lanes) expanded
    decisions: int  # mode decisions computed
    seconds: float  # CPU time of ``plan``, everything included
    megabytes: float  # peak resident memory of its process [MiB]
    nodes: int  # of the manipulation-feasibility graph as the paper counts them
    regrasps: int | None = None  # in the plan

    def cells(self, *names: str) -> list[str]:
        """Return the attributes of these names for a table; "ends" is how the search ended."""
        ends = "proven optimal" if self.optimal else self.status
        return [
            ends if name == "ends" else number(getattr(self, name), 6 if name == "cost" else 3)
            for name in names
        ]


def measure(scenario: str, **options: Any) -> Measured:
    """Return what ``measured`` returns, from a new process."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as process:
        return process.submit(measured, scenario, **options).result()


def measured(
    scenario: str,
    *,
    heuristic: str = "lanes",
    overrides: Sequence[str] = (),
    time_limit: float | None = None,
    repeat: bool = True,
) -> Measured:
    """Measure a search in this process; where ``repeat`` holds, twice: the second time counts."""
    loaded = api.load(scenario, overrides)
    for _ in range(2 if repeat else 1):
        started = time.process_time()
        plan = api.plan(loaded, time_limit=time_limit, parameters={"heuristic": heuristic})
        seconds = time.process_time() - started
    return Measured(
        status=plan.status,
        optimal=plan.optimal,
        cost=plan.cost,
        regrasps=plan.regrasps,
        expanded=plan.statistics.expanded,
        decisions=plan.statistics.mode_decisions,
        seconds=seconds,
        megabytes=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        nodes=graph_nodes(loaded.problem),
    )


def graph_nodes(problem: Problem) -> int:
    """Return the number of potential nodes: unordered sets of placements times lattice nodes."""
    placements = len(problem.fingers.placements)
    groups = problem.fingers.groups()
    return math.prod(math.comb(placements, len(group)) for group in groups) * problem.lattice.size
