"""Best-first search with lazily judged arcs; it knows nothing of hands.

The virtual start and goal nodes of Sec. 4.2 are implicit: ``LazyGraph.sources`` are the arcs from
the one, ``LazyGraph.is_goal`` tells the arcs to the other.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Final, Protocol, TypeAlias, final

from gm_ompl.errors import LimitError
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Status

START: Final = -1
"""The virtual start node."""

GOAL: Final = -2
"""The virtual goal node."""

SAME_COST = 1e-12
"""A path cheaper by less than this, relatively, is no better: sums differ by rounding."""

Entry: TypeAlias = tuple[float, int, int, int, float, bool]
"""(f, order, head, tail, g of the head, whether g is exact); ``order`` is unique.

head = tail stands for the node's late arcs, START for the sources still to come."""

Told: TypeAlias = Callable[[int, float, float, bool], None]
"""Called with (node, cost of getting there, bound, whether it was expanded before)."""


class LazyGraph(Protocol):
    """A directed graph with costs >= 0; nodes are numbers >= 0."""

    def sources(self) -> Iterator[tuple[float, int]]:
        """Yield (bound, start node); bounds are at most the estimates and do not decrease."""

    def starts_at(self, node: int) -> bool:
        """Whether a source is one, asked when it comes to the front."""

    def estimate(self, node: int) -> float:
        """Return a lower bound on the cost to the goal; it may grow, and may be +inf."""

    def is_goal(self, node: int) -> bool:
        """Whether ``node`` is a goal."""

    def arcs(self, node: int) -> Iterable[tuple[int, float, bool]]:
        """Yield (head, cost, exact); a cost that is not exact is a quick lower bound."""

    def late_arcs(self, node: int) -> Iterable[tuple[int, float, bool]]:
        """Yield the arcs that ``arcs`` left out, likewise."""

    def late_bound(self, node: int) -> float:
        """Return a lower bound on the cost to the goal by way of late arcs; +inf without any."""

    def optimistic(self, tail: int, head: int) -> float:
        """Return the present lower bound on the cost of an arc that is not exact."""

    def judge(self, tail: int, head: int) -> float:
        """Return the cost of an arc; +inf where it does not exist."""


@final
class BestFirstSearch:
    """A* over a ``LazyGraph``.

    An arc enters the open list with a lower bound on its cost. At the front it is re-evaluated,
    goes back if its bound has grown, and is judged only if it stays in front. Nodes are opened
    again when a cheaper path turns up, so an estimate need only be admissible. A node's late arcs
    are made only when their common bound comes to the front.

    Args:
        graph: what to search.
        log: told of the progress; its budget is spent.
        expand: told of every expansion: node, cost of getting there, bound, whether a second one.

    Attributes:
        expanded: nodes expanded so far, those opened again included.
        generated: entries put on the open list so far.
        bound: no path is cheaper.
    """

    def __init__(self, graph: LazyGraph, log: Log, expand: Told | None = None) -> None:
        self._graph, self._log, self._told = graph, log, expand
        self._sources = graph.sources()
        self._open: list[Entry] = []
        self._order = 0
        self._closed: dict[int, float] = {}
        self._parent: dict[int, int] = {}
        self._tentative: dict[int, float] = {}
        self._best = (math.inf, START)  # one value: an interrupt finds both halves or neither
        self.expanded = self.generated = 0
        self.bound = 0.0

    @property
    def cost(self) -> float:
        """Cost of the best path known; +inf while there is none."""
        return self._best[0]

    def run(self) -> Status:
        """Search until a path is proven optimal, none is left, or the budget is spent."""
        try:
            self._push(0.0, START, START, 0.0, True)
            status = self._loop()
        except LimitError:
            status = Status.BUDGET
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        if status is Status.INFEASIBLE:
            self.bound = math.inf
        elif self.cost < math.inf:
            status = Status.SOLVED if status is Status.BUDGET else status
        self.bound = min(self.bound, self.cost)
        self._event()
        return status

    def _loop(self) -> Status:
        while self._open:
            self.bound = max(self.bound, self._open[0][0])
            if self._log.meter.spent(self.expanded):
                return Status.BUDGET
            if self._log.due():
                self._event()
            f, _, head, tail, g, exact = heapq.heappop(self._open)
            if head == GOAL:
                return Status.SOLVED
            if head == START:
                self._next_source(f)
            elif head == tail:
                if g <= self._closed[head]:  # else it was opened again, cheaper
                    self._follow(head, g, self._graph.late_arcs(head))
            else:
                self._visit(f, head, tail, g, exact)
        return Status.INFEASIBLE

    def _next_source(self, f: float) -> None:
        """Put the next source on the open list, and the rest of them behind it."""
        following = next(self._sources, None)
        if following is None:
            return
        bound, node = following
        self._push(max(f, bound), START, START, 0.0, True)
        estimate = self._graph.estimate(node)
        if estimate < self.cost and self._improves(node, 0.0):
            self._push(max(bound, estimate), node, START, 0.0, True)

    def _visit(self, f: float, head: int, tail: int, g: float, exact: bool) -> None:
        """Treat the arc at the front: back with it if its f has grown, else judge, then expand."""
        if not self._better(self._closed.get(head), g):
            return
        graph = self._graph
        estimate = graph.estimate(head)
        if tail == START and g + estimate <= f:
            if not graph.starts_at(head):
                return
            self._tentative[head] = g
        if not exact:
            g = self._closed[tail] + graph.optimistic(tail, head)
            if g + estimate > f:
                self._wait(head, tail, g, estimate, False)
                return
            g = self._closed[tail] + graph.judge(tail, head)
            if g == math.inf or not self._improves(head, g):
                return
            self._tentative[head] = g
        if g + estimate > f:
            self._wait(head, tail, g, estimate, True)
            return
        self._expand(head, tail, g)

    def _expand(self, node: int, tail: int, g: float) -> None:
        graph = self._graph
        self.expanded += 1
        if self._told is not None:
            self._told(node, g, g + graph.estimate(node), node in self._closed)
        self._closed[node] = self._tentative[node] = g
        self._parent[node] = tail
        if graph.is_goal(node) and g < self.cost:
            self._best = (g, node)
            self._push(g, GOAL, node, g, True)
        self._follow(node, g, graph.arcs(node))
        # Marked by head = tail: the rest of this node's arcs.
        self._wait(node, node, g, graph.late_bound(node), True)

    def _follow(self, node: int, g: float, arcs: Iterable[tuple[int, float, bool]]) -> None:
        """Put arcs from ``node``, reached at ``g``, on the open list."""
        graph = self._graph
        for head, cost, exact in arcs:
            through = g + cost
            if not self._improves(head, through):
                continue
            if not exact:
                through = g + graph.optimistic(node, head)
            estimate = graph.estimate(head)
            if exact and through + estimate < self.cost:
                self._tentative[head] = through
            self._wait(head, node, through, estimate, exact)

    def _improves(self, node: int, g: float) -> bool:
        """Whether ``g`` is below every cost at which ``node`` was reached."""
        return self._better(self._tentative.get(node), g)

    @staticmethod
    def _better(known: float | None, g: float) -> bool:
        return known is None or g < known - SAME_COST * known

    def _wait(self, head: int, tail: int, g: float, estimate: float, exact: bool) -> None:
        """Put an arc on the open list unless it cannot lead to a better path."""
        f = g + estimate
        if f < self.cost:
            self._push(f, head, tail, g, exact)

    def _push(self, f: float, head: int, tail: int, g: float, exact: bool) -> None:
        # Of equal f the latest comes first: search goes deep on a plateau.
        self._order -= 1
        self.generated += 1
        heapq.heappush(self._open, (f, self._order, head, tail, g, exact))

    def path(self) -> tuple[int, ...]:
        """Return the nodes of the best path from a source to a goal; empty without one."""
        nodes = []
        node = self._best[1]
        while node != START:
            nodes.append(node)
            node = self._parent[node]
        return tuple(reversed(nodes))

    def _event(self) -> None:
        self._log.event(self.cost, self.bound, self.expanded, len(self._open))
