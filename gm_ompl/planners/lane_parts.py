"""One search over lanes, of the whole object graph or of a part: over placements or over cells."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, final

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.closure import Closure
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.graph.lanes import Leaving
from gm_ompl.holds.extraction import Leg, moves_of
from gm_ompl.holds.watch import Stop, never
from gm_ompl.planners.lane_search import LaneSearch
from gm_ompl.planners.lane_sources import start_sets
from gm_ompl.planners.outcome import PROVEN, Log, result_of
from gm_ompl.planners.planner import Report, SearchResult, Status
from gm_ompl.planners.trace import tracer
from gm_ompl.problem import Move, Problem

if TYPE_CHECKING:
    from gm_ompl.graph.cell_graph import CellGraph
    from gm_ompl.planners.cell_search import CellSearch

FEW_SETS: Final = 250_000
"""Sets of placements up to which lanes are treated one by one."""


class PartSearch(Protocol):
    """One search of the whole object graph, or of a part.

    Attributes:
        exhausted: whether it ended by itself, or can prove no more of this part.
    """

    exhausted: bool

    def run(self, pause: Stop = never) -> SearchResult:
        """Search for the cheapest plan, or go on with that, until ``pause`` says so."""


class PartTask(NamedTuple):
    """What is searched, and how.

    Attributes:
        problem: what to plan.
        judge: answers about it; its back end is the kernel's.
        log: told of the progress; its budget is spent.
        report: likewise.
        closure: the part of the object graph; None is all of it.
        most: what plans may cost; None is anything.
    """

    problem: Problem
    judge: Judge
    log: Log
    report: Report
    closure: Closure | None = None
    most: float | None = None

    @property
    def backend(self) -> KernelBackend:
        """The judge's."""
        backend = self.judge.backend
        assert isinstance(backend, KernelBackend), "has_lanes was not asked"
        return backend

    @property
    def beyond(self) -> float:
        """What plans that leave the part cost at least."""
        return math.inf if self.closure is None else self.closure.next

    def leaving(self) -> Leaving | None:
        """Return the arcs of the part, without those that only dearer plans pass."""
        if self.closure is None:
            return None
        return self.closure.leaving(math.inf if self.most is None else self.most * (1.0 + PROVEN))


def part_search(part: PartTask) -> PartSearch:
    """Return the search of a part of the object graph that suits the number of sets."""
    return part_class(part.problem)(part)


def part_class(problem: Problem) -> type[LanePart] | type[CellPart]:
    """Return which search suits a problem; bounds over cells know of z alone."""
    few = set_count(problem) <= FEW_SETS
    plain = few or problem.uncertainty or problem.mechanics.strong
    return LanePart if plain else CellPart


def set_count(problem: Problem) -> int:
    """Return the number of sets of placements, those among them that fit nowhere, too."""
    hand, P = problem.fingers, len(problem.fingers.placements)
    return math.prod(math.comb(P, len(group)) for group in hand.groups())


@final
class LanePart:
    """The search over lanes of placements.

    Attributes:
        exhausted: whether it ended by itself, or can prove no more of this part.
    """

    def __init__(self, part: PartTask) -> None:
        problem, judge, log = part.problem, part.judge, part.log
        self._judge, self._log, self._beyond = judge, log, part.beyond
        stop, leaving = log.meter.spent, part.leaving()
        self._graph = LaneGraph(problem, judge, part.backend, stop, leaving)
        source = start_sets(problem, judge, self._graph)
        self._search = LaneSearch(self._graph, source, log, tracer(part.report), part.beyond)
        self.exhausted = False

    def run(self, pause: Stop = never) -> SearchResult:
        """Search for the cheapest plan, or go on with that, until ``pause`` says so."""
        graph, head = self._graph, self._graph.tables.head
        result, self.exhausted = searched(
            self._judge, graph, self._search, head, self._beyond, self._log, pause
        )
        return result


@final
class CellPart:
    """The search over lanes of cells; where there are too many regrasps, over lanes of placements.

    Attributes:
        exhausted: whether it ended by itself, or can prove no more of this part.
    """

    def __init__(self, part: PartTask) -> None:
        from gm_ompl.graph.cell_graph import CellGraph  # few searches are over cells
        from gm_ompl.planners.cell_search import CellSearch

        problem, judge, log = part.problem, part.judge, part.log
        self._judge, self._log, self._part = judge, log, part
        stop, trace = log.meter.spent, tracer(part.report)
        self._graph = CellGraph(problem, judge, part.backend, stop, part.leaving())
        self._search = CellSearch(problem, judge, self._graph, log, trace, part.beyond)
        self._lanes: LanePart | None = None
        self._result: SearchResult | None = None
        self.exhausted = False

    def run(self, pause: Stop = never) -> SearchResult:
        """Search for the cheapest plan, or go on with that, until ``pause`` says so."""
        if self._lanes is None:
            self._result = self._run(pause)
            if not self._search.given_up:
                return self._result
            self._lanes = LanePart(self._part)
        assert self._result is not None
        found = self._lanes.run(pause)
        self.exhausted = self._lanes.exhausted
        return cheaper(self._result, found)

    def _run(self, pause: Stop) -> SearchResult:
        graph, head, part = self._graph, self._graph.cells.tables.head, self._part
        part.backend.learn = graph.cuts.add
        try:
            result, self.exhausted = searched(
                self._judge, graph, self._search, head, part.beyond, self._log, pause
            )
        finally:
            part.backend.learn = part.backend.pool.add
        return result


def searched(
    judge: Judge, graph: LaneGraph | CellGraph, search: LaneSearch | CellSearch, head: IntArray,
    beyond: float, log: Log, pause: Stop = never,
) -> tuple[SearchResult, bool]:  # fmt: skip
    """Search; return the result, and whether the search can prove no more of its part.

    Args:
        judge: of the problem.
        graph: what is searched.
        search: not begun.
        head: where its arcs lead.
        beyond: what plans that leave the part cost at least.
        log: of the whole search.
        pause: asked whether to end for now.
    """
    status = search.run(pause)
    proven = min(search.cost, beyond) <= search.bound * (1.0 + PROVEN)
    exhausted = status is Status.INFEASIBLE or (status is Status.SOLVED and proven)
    with limits.lifted():
        arcs, legs = search.path()
        moves = moves_along(judge, graph, head, arcs, legs)
    statistics = log.statistics(search.expanded, search.generated, placement_sets=graph.lanes_met)
    return result_of(status, search.cost, search.bound, moves, statistics), exhausted


def moves_along(
    judge: Judge, graph: LaneGraph | CellGraph, head: IntArray, arcs: Sequence[int],
    legs: Sequence[Leg],
) -> tuple[Move, ...]:  # fmt: skip
    """Return the moves of legs along arcs, which lead to the nodes ``head``."""
    nodes = [graph.start, *(int(head[a]) for a in arcs)]
    way = judge.problem.object_graph.way([graph.nodes[c] for c in nodes])
    return moves_of(judge, way, legs)


def cheaper(before: SearchResult, found: SearchResult) -> SearchResult:
    """Return what a search found, with what an earlier one did where that is better."""
    bound = max(before.lower_bound, found.lower_bound)
    best = found
    if before.cost is not None and (found.cost is None or found.cost > before.cost):
        interrupted = found.status is Status.INTERRUPTED
        status = found.status if interrupted else before.status
        best = dataclasses.replace(before, status=status, statistics=found.statistics)
    bound = bound if best.cost is None else min(bound, best.cost)
    optimal = best.cost is not None and best.cost <= bound * (1.0 + PROVEN)
    return dataclasses.replace(best, lower_bound=bound, optimal=optimal)
