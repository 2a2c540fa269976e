"""Exact search over lanes and hubs, for one degree of freedom.

The open list holds lanes, each keyed by a lower bound on the cheapest plan that enters it at a
given node. Nothing is judged before all bounds are as tight as what is known allows; then only the
arcs of the cheapest conceivable plan are judged, those most likely to fail first, so that it is
refuted at small cost. What a judgement teaches (a failed arc, a cut on z for all sets at that
contact state) raises keys; a key is renewed when it reaches the front. The first plan to reach
the front with all its arcs judged is optimal.
"""

from __future__ import annotations

import heapq
import math
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.graph.lane import Hub, Lane
from gm_ompl.graph.lane_graph import LaneGraph
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.watch import Stop, never
from gm_ompl.planners.lane_entries import Choices, Entry, Waiting, legs, lifted_row
from gm_ompl.planners.lane_sources import StartSets
from gm_ompl.planners.outcome import Log, status_of
from gm_ompl.planners.planner import Status
from gm_ompl.planners.trace import Expansion, Trace
from gm_ompl.problem import Placements

SAME: Final = 1e-12
"""Relative difference below which two costs are one."""

FIRST_SWEEP: Final = 1000.0
"""Lanes treated in vain before a sweep over all lanes is considered."""


@final
class LaneSearch:
    """One search; ``run`` may be called again where it paused.

    Args:
        graph: the lanes.
        source: the sets at the start.
        log: told of the progress; its budget is spent.
        trace: told of every lane.
        beyond: a lower bound on plans that leave the part of the object graph that was explored.

    Attributes:
        expanded: lanes taken from the front of the open list.
        bound: no plan is cheaper.
        cost: of the best plan known, or +inf.
    """

    def __init__(
        self,
        graph: LaneGraph,
        source: StartSets,
        log: Log,
        trace: Trace | None = None,
        beyond: float = math.inf,
    ) -> None:
        self._graph, self._source = graph, source
        self._log, self._trace, self._beyond = log, trace, beyond
        self._open: list[tuple[float, int, Waiting]] = []
        self._order = 0
        self._entered: dict[tuple[Placements, int], float] = {}
        self._best: tuple[Entry, tuple[int, ...]] | None = None
        self._stale, self._patience = 0, FIRST_SWEEP
        self.expanded = self.generated = 0
        self.bound, self.cost = 0.0, math.inf

    def run(self, pause: Stop = never) -> Status:
        """Search until a plan is proven optimal, there is proven to be none, or no budget.

        Args:
            pause: asked whether to end for now, as if no budget were left.
        """
        status = status_of(lambda: self._run(pause), lambda: self._best is not None)
        if status is Status.INFEASIBLE:
            self.bound = math.inf
        self._event()
        return status

    def _run(self, pause: Stop) -> Status:
        while True:
            f = min(self._source.key(), self._open[0][0] if self._open else math.inf)
            if f == math.inf:
                break
            self.bound = max(self.bound, min(f, self.cost))
            if f >= self.cost * (1.0 - SAME):
                self.bound = self.cost
                return Status.SOLVED
            if f >= self._beyond and self._best is not None:
                return Status.SOLVED  # the part must grow before more can be proven
            if self._log.meter.spent(self.expanded) or pause():
                return Status.BUDGET
            if self._log.due():
                self._event()
            self._advance()
        if self._best is None:
            return Status.INFEASIBLE
        self.bound = self.cost  # nothing cheaper waits
        return Status.SOLVED

    def _advance(self) -> None:
        """Treat what comes first; among equals, what has been met before."""
        if not self._open or self._source.key() < self._open[0][0]:
            self._emerge()
            return
        f, _, waiting = heapq.heappop(self._open)
        if isinstance(waiting, Entry):
            self._treat(f, waiting)
        else:
            self._leave(waiting)

    def _push(self, f: float, waiting: Waiting) -> None:
        """Let an entry or choices wait; entries of start sets wait at their source."""
        if isinstance(waiting, Entry) and waiting.parent is None:
            self._source.put_back(f, waiting.placements)
        elif f < self.cost:
            self._order += 1
            self.generated += 1
            heapq.heappush(self._open, (f, self._order, waiting))

    def _emerge(self) -> None:
        """Treat the first start set, or renew the keys of several."""
        if self._source.is_ready():
            f, placements = self._source.take()
            self._treat(f, Entry(placements, self._graph.start, 0.0, None))
        else:
            self._wasted(self._source.renew())

    def _treat(self, f: float, entry: Entry) -> None:
        """Renew an entry's key; where it stands, judge the plan that it stands for."""
        graph = self._graph
        self.expanded += 1
        lane = graph.lane(entry.placements)
        cost, node, hub = graph.target(lane, entry.config, entry.g)
        stale = entry.g + cost > f + SAME * f
        if self._trace is not None:
            why = "renewed" if stale else "judged"
            q = graph.coordinates(entry.config)
            self._trace(Expansion(q, entry.placements, entry.g, f, why))
        if entry.parent is None:
            self._source.judged(stale)
        if stale:
            self._push(entry.g + cost, entry)
            self._wasted(1)
        elif entry.parent is None and not graph.air.lands(entry.placements):
            return
        elif hub is None:
            self._finish(lane, entry)
        else:
            self._enter(lane, entry, node, hub)

    def _wasted(self, lanes: int) -> None:
        """Hear of stale keys; where too many are, look further ahead from all hubs.

        A sweep bounds every lane once. Made only when as many lanes were bounded in vain, all
        sweeps together cost no more than what was wasted, whatever the machine.
        """
        self._stale += lanes
        if self._stale < self._patience:
            return
        price = self._graph.sweep_price()
        if self._stale >= price:
            gained = self._graph.sweep()
            self._stale = 0
            # Sweeps that raise nothing are made ever more rarely.
            price = price if gained else 2.0 * max(price, self._patience)
        self._patience = price

    def _finish(self, lane: Lane, entry: Entry) -> None:
        """Judge the lane to the goal; a plan is found where it holds."""
        way = self._graph.way(lane, entry.config)
        end = int(self._graph.tables.head[way[-1]]) if way else entry.config
        if not self._graph.air.leaves(lane, end):
            self._graph.close(lane, end)
        elif self._graph.judge_arcs(lane, way):
            # Not the lane's bound: judged, the way may cost more than another one there.
            total = entry.g + math.fsum(lane.costs[self._graph.tables.kind[list(way)]])
            if total < self.cost:
                self.cost, self._best = total, (entry, way)
        cost, _, _ = self._graph.target(lane, entry.config, entry.g)
        self._push(entry.g + cost, entry)

    def _enter(self, lane: Lane, entry: Entry, node: int, hub: Hub) -> None:
        """Judge the way to a hub and on, least likely first; the hub is reached where it holds."""
        graph, way = self._graph, self._graph.way(lane, entry.config, node)
        if graph.judge_rest(hub, node) and self._goes_on(hub, node) and graph.judge_arcs(lane, way):
            through = graph.tables.X_regr + math.fsum(lane.costs[graph.tables.kind[list(way)]])
            self._lift(hub, node, entry.g + through, entry, way)
        cost, _, _ = graph.target(lane, entry.config, entry.g)
        self._push(entry.g + cost, entry)

    def _goes_on(self, hub: Hub, node: int) -> bool:
        """Judge the best lane from a hub to the goal; whether the hub's bound rests on it."""
        graph = self._graph
        if not len(hub.choices):
            return False
        index = int(np.argmin(hub.table[:, node]))
        if hub.table[index, node] > hub.value[node]:
            return True  # the bound is that of another regrasp: nothing to judge yet
        lane = graph.lane(graph.lane_of(hub, index))
        before = lane.d[node]
        holds = before < math.inf and graph.judge_arcs(lane, graph.way(lane, node))
        graph.learn(hub, index, lane)
        graph.refined(hub, node)
        return holds and lane.d[node] <= before + SAME * before

    def _lift(self, hub: Hub, node: int, g: float, parent: Entry, way: tuple[int, ...]) -> None:
        """Reach a hub at cost ``g``, or the part of it that belongs to a pocket."""
        graph, row = self._graph, lifted_row(hub, parent.placements)
        if graph.air.is_outside(hub, node, row):
            if g < hub.reached[node]:
                hub.reached[node] = g
                doubtful = graph.air.doubtful(hub, node)
                if doubtful is not None:
                    hub.doubtful[node] = doubtful
                self._offer(hub, node, g, parent, way)
        else:
            lane = graph.lane(parent.placements)
            lane.bar(lane.hubs.index(hub.placements), node, g)
            self._offer(hub, node, g, parent, way, pocket=True)

    def _offer(
        self, hub: Hub, node: int, g: float, parent: Entry, way: tuple[int, ...],
        *, pocket: bool = False,
    ) -> None:  # fmt: skip
        """Let all lanes through a hub wait to be entered."""
        keys = g + self._onward(hub, node)
        order = np.argsort(keys, kind="stable")
        if len(keys):
            choices = Choices(hub, node, g, parent, way, keys, order, pocket)
            self._push(float(keys[order[0]]), choices)

    def _onward(self, hub: Hub, node: int) -> Array:
        """Return lower bounds (choices,) on the cost to the goal after each regrasp."""
        graph, tables = self._graph, self._graph.tables
        if graph.bounds is None:
            onward = np.minimum(hub.table[:, node], tables.X_regr + tables.least[node])
        else:
            sets = np.tile(hub.rows, (len(hub.choices), 1))
            sets[:, hub.slot] = hub.choices
            onward = graph.keys(graph.sets.canonical_rows(sets), node)
        free = graph.air.landing[hub.slot, hub.choices, node]
        keys: Array = np.where(free, onward, np.inf)
        return keys

    def _leave(self, choices: Choices) -> None:
        """Enter the next lane from a hub."""
        index = int(choices.order[choices.next])
        f = float(choices.keys[index])
        placements = self._graph.lane_of(choices.hub, index)
        key = (placements, choices.config)
        back = choices.parent.placements == placements
        better = not back and choices.g < self._entered.get(key, math.inf)
        if better and f < math.inf and self._joined(choices, int(choices.hub.choices[index])):
            self._entered[key] = choices.g
            self._push(f, Entry(placements, choices.config, choices.g, choices.parent, choices.way))
        choices.next += 1
        if choices.next < len(choices.order):
            self._push(float(choices.keys[choices.order[choices.next]]), choices)

    def _joined(self, choices: Choices, row: int) -> bool:
        """Whether the lifted finger gets to a placement."""
        hub, node = choices.hub, choices.config
        doubtful = hub.doubtful.get(node)
        if not choices.pocket and (doubtful is None or not doubtful[row]):
            return True
        return self._graph.joined(hub, node, choices.row, row)

    def path(self) -> tuple[tuple[int, ...], list[Leg]]:
        """Return the best plan's arcs, and its legs along them; both empty without one."""
        return ((), []) if self._best is None else legs(*self._best)

    def _event(self) -> None:
        self._log.event(self.cost, min(self.bound, self._beyond), self.expanded, len(self._open))
