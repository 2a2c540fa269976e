"""Exact search for plans of free motion that regrasp at most once.

Plans with k regrasps cost at least k X_regr and what fingertips that are kept must travel; so a
plan that regrasps less often and is cheaper than all of those is optimal. Plans that regrasp once
are looked for where those without regrasping have no proof, and the object turns about one axis.
"""

from __future__ import annotations

import math
from typing import final

from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.goal_distance import GoalDistance
from gm_ompl.graph.goal_sets import GoalSets
from gm_ompl.graph.kept_arcs import START
from gm_ompl.graph.kept_graph import KeptGraph
from gm_ompl.graph.regrasp_graph import RegraspGraph
from gm_ompl.motion.free import FreeMotion
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.state_search import StateSearch
from gm_ompl.problem import Move


@final
class KeptSearch:
    """One search; it can be gone on with.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.
        graph: states of plans that do not regrasp.
        log: its budget is spent.

    Attributes:
        graph: likewise.
    """

    def __init__(self, judge: Judge, graph: KeptGraph, log: Log) -> None:
        self._judge, self._log, self.graph = judge, log, graph
        self._searches = [StateSearch(judge, graph, log)]
        self._others, self._enough = regrasping(judge, graph.goal_sets, 1), math.inf
        problem = judge.problem
        several = problem.fingers.count > 1 and problem.hand is None
        self._goes_on = several and graph.planar is not None

    @classmethod
    def of(cls, judge: Judge, log: Log) -> KeptSearch | None:
        """Return a search, or None where there is nothing to keep, or too much."""
        if not judge.problem.fingers.count:
            return None
        graph = KeptGraph(judge)
        return None if graph.full else cls(judge, graph, log)

    @property
    def bound(self) -> float:
        """No plan is cheaper, however often it regrasps."""
        return min(self._others, *(search.bound for search in self._searches))

    @property
    def cost(self) -> float:
        """Of the best plan that was found here, or +inf."""
        return min(search.cost for search in self._searches)

    @property
    def expanded(self) -> int:
        """States that were followed, those followed again included."""
        return sum(search.expanded for search in self._searches)

    @property
    def waiting(self) -> int:
        """How many states are open."""
        return sum(len(search.graph.open) for search in self._searches)

    @property
    def done(self) -> bool:
        """Whether it can say no more."""
        most = min(self.cost, self._enough)
        full = any(s.graph.full and s.bound < min(most, self._others) for s in self._searches)
        return full or self.bound >= (most if self._goes_on else min(most, self._others))

    def proves(self, cost: float) -> bool:
        """Whether a plan of this cost is proven optimal where no plan found here is cheaper."""
        return cost <= self._others

    def step(self, enough: float) -> None:
        """Go on where plans cheaper than ``enough`` may begin.

        Raises:
            LimitError: a limit is reached.
        """
        self._enough = enough
        if self._log.due():
            self._log.event(min(self.cost, enough), self.bound, self.expanded, self.waiting)
        least, most = min(self._searches, key=lambda s: s.bound), min(self.cost, enough)
        if least.bound < self._others or self._others >= most:
            least.step(min(most, self._others))
        elif self._goes_on:
            self._regrasp()

    def _regrasp(self) -> None:
        """Look for plans that regrasp once, too."""
        graph = self.graph
        assert graph.planar is not None
        once = RegraspGraph(self._judge, graph, graph.planar)
        self._goes_on = False  # last: a limit may be reached before
        if not once.full:
            self._searches.append(StateSearch(self._judge, once, self._log, self._others))
            self._others = regrasping(self._judge, graph.goal_sets, 2)

    def moves(self) -> tuple[Move, ...]:
        """Return the best plan's moves; none where no plan is known."""
        return min(self._searches, key=lambda search: search.cost).moves()


def regrasping(judge: Judge, goal_sets: GoalSets, times: int) -> float:
    """Return a lower bound on plans that regrasp so often, or more often."""
    hand, price = judge.problem.fingers, float(judge.problem.cost.regrasp)
    n, start = hand.count, judge.problem.object_graph.pose(START)
    free, motion = judge.node(start).free, judge.problem.motion
    there = goal_sets.free()
    assert isinstance(motion, FreeMotion)
    ways = [
        GoalDistance(motion.goal, judge.centres(i)[free[i] & there[i]])
        .distances(start.rotation, start.position)
        .min(initial=math.inf)
        for i in range(n)
    ]
    some = times * price + min(ways) if n > times else math.inf
    return min(some, max(n, times) * price)
