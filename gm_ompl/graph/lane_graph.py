"""Lanes and hubs as the search meets them, with all that is known of each."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.cores import share_out
from gm_ompl.direct import direct
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.hub_bounds import hub_bounds, swept_sets
from gm_ompl.graph.lane import FEW, Hub, Lane
from gm_ompl.graph.lane_air import LaneAir
from gm_ompl.graph.lane_bounds import best_target, hub_defaults, hub_rows, lane_keys, spread
from gm_ompl.graph.lanes import Leaving, lane_table
from gm_ompl.holds.bounds import refresh
from gm_ompl.holds.known import FAILED, UNDECIDED, Known, at_once
from gm_ompl.holds.rows import UNASKED
from gm_ompl.holds.sets import LIFTED, PlacementSets, beside
from gm_ompl.holds.tables import WORTH_A_THREAD
from gm_ompl.holds.watch import Stop, never
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem

_best_target, _hub_rows = direct(best_target), direct(hub_rows)
_lane_keys, _refresh = direct(lane_keys), direct(refresh)


@final
class LaneGraph:
    """All lanes and hubs of an object graph that is small enough to be explored at once.

    ``leaving`` has the arcs of a part of the object graph by their tails; None: all of it.

    Attributes:
        nodes: the object graph's nodes, in the order in which they are numbered here.
        start: the number of the start's.
        tables: what all lanes share.
        sets: canonical sets of placements.
        bounds: of all hubs; None where they are too many.
        air: ways through the air.

    Raises:
        LimitError: ``stop`` said so while the tables were made.
    """

    def __init__(
        self, problem: Problem, judge: Judge, backend: KernelBackend, stop: Stop = never,
        leaving: Leaving | None = None,
    ) -> None:  # fmt: skip
        self._problem, self._judge, self._backend = problem, judge, backend
        self.nodes, self._table = lane_table(judge, stop, leaving)
        self._few = FEW if problem.mechanics.strong else -1
        self.start = self.nodes.index(problem.object_graph.start)
        self.tables, self._known = self._table.measured, Known(judge, self._table)
        backend.pool.reserve(1 + int(self.tables.states.max(initial=0)))
        self._lanes: dict[Placements, Lane] = {}
        self._hubs: dict[Placements, Hub] = {}
        self._lanes_of: dict[Placements, list[Lane]] = {}
        self.sets = PlacementSets(problem.fingers.groups())
        self.bounds = hub_bounds(problem, judge, self.tables)
        self._hubs_risen = self._states_asked = 0
        self._swept: IntArray | None = None
        self.air = LaneAir(problem, judge, self.nodes, self.tables.node_free)

    @property
    def version(self) -> int:
        """Grows with whatever may raise keys: cuts, and bounds of hubs."""
        return self._facts + self._hubs_risen

    @property
    def _facts(self) -> int:
        """Grows with whatever may tighten the bounds of lanes."""
        return self._backend.pool.version + self._states_asked

    @property
    def lanes_met(self) -> int:
        """Number of lanes looked at one by one."""
        return len(self._lanes)

    def coordinates(self, config: int) -> Coordinates:
        """Return the object's coordinates at a node."""
        return self._problem.object_graph.coordinates(self.nodes[config])

    def lane(self, placements: Placements) -> Lane:
        """Return the lane of a canonical set, its bounds renewed."""
        lane = self._lanes.get(placements)
        if lane is None:
            hubs = self.sets.hubs(placements)
            margins = self._known.margins(placements)
            lane = self._lanes[placements] = Lane(placements, hubs, margins, len(self.nodes))
            for hub in hubs:
                self._lanes_of.setdefault(hub, []).append(lane)
                if hub in self._hubs:
                    self._hubs[hub].ask(lane.placements)
        return self.renewed(lane)

    def renewed(self, lane: Lane, force: bool = False) -> Lane:
        """Return ``lane`` with its bounds renewed if cuts were added or ``force`` is set."""
        if force or lane.version != self._facts:
            cuts, tables = self._backend.pool.tables, lane.tables(self.tables)
            _refresh(lane.rows, tables, cuts, lane.known, lane.z, lane.costs, lane.d)
            lane.version = self._facts
        return lane

    def lane_of(self, hub: Hub, index: int) -> Placements:
        """Return the canonical set that choice ``index`` of a hub leads to."""
        return self.sets.replaced(hub.placements, hub.slot, int(hub.choices[index]))

    def hub(self, placements: Placements) -> Hub:
        """Return the hub with these canonical placements."""
        hub = self._hubs.get(placements)
        if hub is None:
            hub = self._hubs[placements] = self._new_hub(placements)
        return hub

    def _new_hub(self, placements: Placements) -> Hub:
        anywhere = np.ones(len(self._problem.fingers.placements), dtype=bool)
        fits = anywhere & beside(placements, self._judge.clear)
        hub = Hub(placements, fits, self._known.rests(placements))
        if self.tables.one_pass:
            self._renew_rows(hub, np.arange(len(hub.choices)))
        else:  # rows are dear: travel bounds them until they come first
            hub.bounded_by(self.tables.ahead)
        for lane in self._lanes_of.get(placements, ()):
            hub.ask(lane.placements)
        self._revalue(hub)
        return hub

    def _renew_rows(self, hub: Hub, which: IntArray) -> None:
        """Write the bounds of some of a hub's choices anew."""
        cuts = self._backend.pool.tables
        _hub_rows(hub.rows, hub.slot, hub.choices, which, self.tables, cuts, hub.table)
        hub.versions[which] = self._facts

    def _revalue(self, hub: Hub) -> None:
        tables = self.tables
        if self.air.learnt:
            hub.table[~self.air.landing[hub.slot, hub.choices]] = np.inf
        best = hub.table.min(axis=0, initial=np.inf)
        hub.value = np.minimum(best, tables.X_regr + tables.least)
        bounds = None if self.bounds is None else self.bounds.row(hub.placements)
        if bounds is not None:
            hub.value = np.maximum(hub.value, bounds)
        hub.value[hub.stable == 0] = np.inf
        for k, row in enumerate(hub.placements):
            if row != LIFTED:
                hub.value[~tables.node_free[k, row]] = np.inf
        if bounds is not None and np.any(hub.value > bounds):
            bounds[:] = hub.value  # keys of all lanes rest on them
            self._hubs_risen += 1

    def learn(self, hub: Hub, index: int, lane: Lane) -> None:
        """Take a lane's bounds into a hub's table."""
        hub.table[index] = lane.d
        hub.versions[index] = -2
        self._revalue(hub)

    def refined(self, hub: Hub, config: int) -> bool:
        """Renew the hub's bound at a node until it rests on a fresh row; whether it changed."""
        before, renewed = hub.value[config], False
        while len(hub.choices):
            index = int(np.argmin(hub.table[:, config]))
            best = hub.table[index, config]
            if best == np.inf or hub.versions[index] == self._facts:
                break
            if hub.versions[index] == -2:
                d = self.lane(self.lane_of(hub, index)).d
                if d[config] == best:
                    break
                hub.table[index] = d
            else:
                self._renew_rows(hub, np.array([index]))
            hub.table[index, ~self.air.landing[hub.slot, hub.choices[index]]] = np.inf
            renewed = True
        if renewed:
            self._revalue(hub)
        return bool(hub.value[config] != before)

    def target(self, lane: Lane, config: int, g: float) -> tuple[float, int, Hub | None]:
        """Return the cheapest conceivable way on from a node of a lane at cost ``g``.

        Returns:
            Its cost, the node to go to, and the hub to enter there (None: it is the goal).
        """
        tables, travel = self.tables, np.empty(len(lane.d))
        shape, hubs = (len(lane.rows), len(lane.d)), lane.hubs
        V, G = np.empty(shape), np.full(shape, np.inf)
        if self.bounds is None:
            hub_defaults(lane.rows, self.tables, V)
        else:
            for k, hub_set in enumerate(hubs):
                V[k] = self.bounds.row(hub_set)
        while True:
            for k, hub_set in enumerate(hubs):
                known = self._hubs.get(hub_set)
                if known is not None:
                    V[k], G[k] = known.value, known.reached
                    self.air.mind_pockets(lane, k, known, G[k])
            cost, node, slot = _best_target(config, g, lane.costs, lane.d, (V, G), tables, travel)
            if slot < 0:
                return cost, node, None
            new = hubs[slot] not in self._hubs
            hub = self.hub(hubs[slot])
            if not self.refined(hub, node) and not new:
                return cost, node, hub

    def close(self, lane: Lane, node: int) -> None:
        """Take note that a lane cannot end at a goal node."""
        lane.closed.add(node)
        self.renewed(lane, force=True)

    def joined(self, hub: Hub, node: int, a: int, b: int) -> bool:
        """Whether the lifted finger of a hub gets from one placement to another at a node."""
        joined = self.air.joined(hub, node, a, b)
        if not joined and self.air.learn(node):
            for known in self._hubs.values():
                self._revalue(known)
            self._hubs_risen += 1
        return joined

    def keys(self, sets: IntArray, config: int) -> Array:
        """Return lower bounds (L,) on the cost from a node to the goal for many lanes (L, n)."""
        keys, bounds, cuts = np.empty(len(sets)), self.bounds, self._backend.pool.tables
        ids = np.zeros((1, sets.shape[1]), dtype=np.int64)
        V = np.empty((0, 1)) if bounds is None else bounds.V

        def work(part: slice) -> None:
            some = ids if bounds is None else bounds.ids(sets[part])
            _lane_keys(sets[part], some, V, config, self.tables, cuts, keys[part])

        share_out(work, len(sets), WORTH_A_THREAD, at_once(self.tables))
        return keys

    def sweep_price(self) -> float:
        """Return how many lanes a sweep bounds; +inf where it is too large."""
        if self._swept is None:
            self._swept = swept_sets(self._problem, self._judge, self.tables)
        if self.bounds is None or not len(self._swept):
            return math.inf
        return float(len(self._swept))

    def sweep(self) -> bool:
        """Renew the bounds of all hubs, any number of regrasps ahead; whether any rose."""
        assert self.bounds is not None, "sweep_price is infinite"
        assert self._swept is not None, "sweep_price was not asked"
        gained = self.bounds.sweep(self._swept, self._known, self.air.landing)
        for hub in self._hubs.values():
            self._revalue(hub)
        self._hubs_risen += 1
        return gained

    def judge_rest(self, hub: Hub, config: int) -> bool:
        """Decide whether the rest of the hand holds the object at a node."""
        if hub.stable[config] == UNDECIDED:
            self._known.rest_holds(hub.placements, config)
            self._revalue(hub)
        return bool(hub.stable[config])

    def way(self, lane: Lane, tail: int, head: int | None = None) -> tuple[int, ...]:
        """Return the arcs of the cheapest way from a lane's node to another, or to a goal node."""
        travel, via = np.empty(len(lane.d)), np.empty(len(lane.d), dtype=np.int64)
        spread(tail, lane.costs, self.tables, travel, via)
        if head is None:
            head = int(np.argmin(np.where(lane.tables(self.tables).goal, travel, np.inf)))
        arcs: list[int] = []
        while head != tail:
            arcs.append(int(via[head]))
            head = int(self.tables.tail[arcs[-1]])
        return tuple(reversed(arcs))

    def judge_arcs(self, lane: Lane, way: tuple[int, ...]) -> bool:
        """Decide the arcs of a way along a lane, least likely to hold first, dear ones by and by.

        Returns:
            Whether all hold; else the lane's bounds have changed.
        """
        kinds, states = self.tables.kind[list(way)], self.tables.states
        if (states[kinds] == UNASKED).any():
            self._states_asked += sum(self._table.ask(a) > 0 for a in way)
            self._backend.pool.reserve(1 + int(states.max()))
        at, parts = np.nonzero(np.isinf(lane.known[kinds]))
        # Smallest bound first; among equals from the far end, where paths tend to fail.
        order = np.lexsort((-at, lane.z[kinds[at], parts]))
        holds, left = True, self._few
        for k, j in zip(kinds[at[order]].tolist(), parts[order].tolist(), strict=True):
            if np.isinf(lane.known[k, j]):
                state = int(states[k, j])
                margin = self._known.decide(lane.placements, state)
                lane.known[states == state] = margin
                left -= margin < np.inf
                if margin == FAILED or left == 0:
                    holds = False
                    break
        self.renewed(lane, force=True)
        return holds
