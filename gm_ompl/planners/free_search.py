"""Exact search of free motion, whose object graph is made on demand.

Two searches share the work. One is over lanes, in ever larger parts of the object graph, until no
better plan can leave the part. The other is for plans without regrasping; it needs far fewer poses
where those with regrasps are dearer than the best plan. Whichever ends first has the proof.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final, final

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.closure import Closure
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.lane_parts import cheaper, part_search
from gm_ompl.planners.outcome import PROVEN, Log, result_of, without_search
from gm_ompl.planners.planner import Report, SearchResult, Status
from gm_ompl.problem import Problem

FEW_NODES: Final = 4000
"""Parts of the object graph up to this size are searched over lanes before anything else."""

SHARE: Final = 3.0
"""Until a plan is known, the search without regrasping gets so many times the time of lanes."""


@final
class FreeSearch:
    """One search; ``run`` may be called once.

    Args:
        problem: what to plan.
        judge: answers about it; its back end is the kernel's.
        log: told of the progress; its budget is spent.
        report: likewise.
    """

    def __init__(self, problem: Problem, judge: Judge, log: Log, report: Report) -> None:
        self._problem, self._judge, self._log, self._report = problem, judge, log, report
        self._result = without_search(Status.BUDGET, 0.0, log.meter)
        self._kept: KeptSearch | None = None
        self._began = False
        self._expanded = self._generated = 0
        self._taken = [0.0, 0.0]  # by lanes, and by plans without regrasping [s]

    def run(self) -> SearchResult:
        """Search for a plan of least cost."""
        try:
            closure = Closure(self._judge, self._log.meter.spent)
            if not self._reach(closure):
                while not self._step(closure):
                    pass
        except KeyboardInterrupt:
            self._take_kept()
            return dataclasses.replace(self._counted(self._result), status=Status.INTERRUPTED)
        except LimitError as stopped:
            self._take_kept()
            ended = {"ended_by": str(stopped)} if str(stopped) else {}
            counted = self._counted(self._result)
            return dataclasses.replace(counted, statistics={**counted.statistics, **ended})
        return self._result

    def _reach(self, closure: Closure) -> bool:
        """Grow the part to the goal, beside the search without regrasping; whether that is all."""
        before, nodes, there = self._log.meter.elapsed(), FEW_NODES, False
        while not there and self._result.cost is None:
            there = closure.to_goal(nodes) is not None
            self._taken[0] += self._log.meter.elapsed() - before
            if len(closure) >= FEW_NODES and self._keep(SHARE * self._taken[0]):
                return True
            before, nodes = self._log.meter.elapsed(), 2 * nodes
        return False

    def _step(self, closure: Closure) -> bool:
        """Search a larger part, and for plans without regrasping; whether there is no more."""
        cost = self._result.cost
        kept = None if cost is None else self._without_regrasps()
        proves = cost is not None and kept is not None and kept.proves(cost)
        if cost is None:
            closure.double()
        else:
            closure.grow(cost, max(FEW_NODES, len(closure)) if proves else math.inf)
            if closure.next <= cost and proves:
                return self._keep(math.inf)
        return self._search(closure) or (
            self._result.cost is None and self._keep(SHARE * self._taken[0])
        )

    def _without_regrasps(self) -> KeptSearch | None:
        """Return the search for plans without regrasping, begun when it is asked for."""
        if not self._began:
            self._began, self._kept = True, KeptSearch.of(self._judge, self._log)
        return self._kept

    def _search(self, closure: Closure) -> bool:
        """Search a part over lanes; whether that is all."""
        before = self._log.meter.elapsed()
        part = part_search(
            self._problem, self._judge, self._log, self._report, closure, self._result.cost
        )
        found = part.run()
        self._expanded += found.statistics["expanded"]
        self._generated += found.statistics["generated"]
        self._taken[0] += self._log.meter.elapsed() - before
        self._result = _within(cheaper(self._result, self._counted(found)), closure.next)
        return not part.exhausted or closure.next == math.inf or self._result.optimal

    def _counted(self, found: SearchResult) -> SearchResult:
        """Return what was found with the counts of the whole search."""
        counts = self._log.statistics(self._expanded, self._generated)
        return dataclasses.replace(found, statistics={**found.statistics, **counts})

    def _keep(self, seconds: float) -> bool:
        """Go on with the search for plans without regrasping; whether a plan is optimal."""
        kept = self._without_regrasps()
        if kept is None:
            return False
        cost, elapsed = self._result.cost, self._log.meter.elapsed
        while self._taken[1] < seconds and not kept.done:
            before, expanded = elapsed(), kept.expanded
            kept.step(math.inf if cost is None else cost)
            self._expanded += kept.expanded - expanded
            self._taken[1] += elapsed() - before
        self._take_kept()
        return self._result.optimal

    def _take_kept(self) -> None:
        """Take over what the search for plans without regrasping has found so far."""
        kept, result = self._kept, self._result
        if kept is None:
            return
        bound, counted = max(result.lower_bound, kept.bound), self._counted(result)
        if kept.cost < (math.inf if result.cost is None else result.cost):
            solved = Status.SOLVED, kept.cost, bound, kept.moves()
            self._result = result_of(*solved, dict(counted.statistics))
            return
        bound = bound if result.cost is None else min(bound, result.cost)
        optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
        self._result = dataclasses.replace(counted, lower_bound=bound, optimal=optimal)


def _within(result: SearchResult, beyond: float) -> SearchResult:
    """Return what was found in a part of the object graph; plans that leave it cost ``beyond``."""
    if beyond == math.inf:
        return result
    bound = min(result.lower_bound, beyond)
    if result.status is Status.INFEASIBLE:
        return dataclasses.replace(result, status=Status.BUDGET, lower_bound=beyond)
    optimal = result.cost is not None and result.cost <= bound * (1.0 + PROVEN)
    return dataclasses.replace(result, lower_bound=bound, optimal=optimal)
