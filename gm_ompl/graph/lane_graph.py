"""Lanes and hubs as the search meets them, with all that is known of each."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.decision import Outcome
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.lane_bounds import best_target, hub_defaults, hub_rows, refresh
from gm_ompl.graph.lanes import lane_tables
from gm_ompl.graph.sets import LIFTED, PlacementSets
from gm_ompl.problem import Placements, Problem

BLOCKED = -1.0
"""Stands for a margin that is known to fail."""


@final
class Lane:
    """One set of placements along the whole path.

    Attributes:
        placements: canonical.
        rows: (n,), the same.
        known: (2, N, P), decided margins forward and backward; +inf undecided, BLOCKED failed.
        z: (2, N, P), upper bounds on the margins.
        costs: (2, N), lower bounds on Eq. (9).
        d: (N + 1,), lower bounds on the cost to the goal inside the lane.
        version: of the cuts when the bounds were last renewed.
    """

    def __init__(self, placements: Placements, N: int, P: int) -> None:
        self.placements = placements
        self.rows = np.array(placements, dtype=np.int64)
        self.known = np.full((2, N, P), np.inf)
        self.z = np.empty((2, N, P))
        self.costs, self.d = np.empty((2, N)), np.empty(N + 1)
        self.version = -1


@final
class Hub:
    """One finger lifted, the others in place, at any node.

    Attributes:
        placements: canonical, with LIFTED.
        slot: who is lifted.
        rows: (n,), 0 at ``slot``.
        choices: where the lifted finger may go, clear of the others.
        table: (choices, N + 1), lower bounds on the cost to the goal per choice and node.
        versions: (choices,), of the cuts when a choice's row was last renewed; -2 where the lane
            itself must be asked.
        stable: (N + 1,), whether the rest holds the object: 1, 0, or -1 where undecided.
        value: (N + 1,), lower bounds on the cost from the hub.
        reached: (N + 1,), least cost at which it was reached.
    """

    def __init__(self, placements: Placements, choices: IntArray, nodes: int) -> None:
        self.placements = placements
        self.slot = placements.index(LIFTED)
        self.rows = np.array(placements, dtype=np.int64)
        self.rows[self.slot] = 0
        self.choices = choices
        self.table = np.empty((len(choices), nodes))
        self.versions = np.full(len(choices), -1, dtype=np.int64)
        self.stable = np.full(nodes, -1, dtype=np.int64)
        self.value = np.empty(nodes)
        self.reached = np.full(nodes, np.inf)


@final
class LaneGraph:
    """All lanes and hubs of a problem of one coordinate, made on demand.

    Attributes:
        tables: what all lanes share.
        sets: canonical sets of placements.
    """

    def __init__(self, problem: Problem, judge: Judge, backend: KernelBackend) -> None:
        self._problem, self._judge, self._backend = problem, judge, backend
        self._fingers = tuple(range(problem.fingers.count))
        self._lanes: dict[Placements, Lane] = {}
        self._hubs: dict[Placements, Hub] = {}
        self.tables = lane_tables(problem, judge, backend)
        self.sets = PlacementSets(problem.fingers.groups())

    @property
    def lanes_met(self) -> int:
        """Number of lanes looked at one by one."""
        return len(self._lanes)

    def lane(self, placements: Placements) -> Lane:
        """Return the lane of a canonical set, its bounds renewed."""
        lane = self._lanes.get(placements)
        if lane is None:
            lane = self._lanes[placements] = Lane(placements, *self.tables.forward.shape)
            for hub_set in self._hub_sets(placements):
                self._tell_hub(lane, hub_set)
        return self.renewed(lane)

    def renewed(self, lane: Lane, force: bool = False) -> Lane:
        """Return ``lane`` with its bounds renewed if cuts were added or ``force`` is set."""
        pool = self._backend.pool
        if force or lane.version != pool.version:
            refresh(lane.rows, self.tables, pool.tables, lane.known, lane.z, lane.costs, lane.d)
            lane.version = pool.version
        return lane

    def _hub_sets(self, placements: Placements) -> list[Placements]:
        return [self.sets.replaced(placements, k, LIFTED) for k in self._fingers]

    def _tell_hub(self, lane: Lane, hub_set: Placements) -> None:
        """Make a hub ask the lane itself, which knows more than the cuts."""
        hub = self._hubs.get(hub_set)
        if hub is not None:
            index = self._choice(hub, lane.placements)
            if index is not None:
                hub.versions[index] = -2

    def _choice(self, hub: Hub, placements: Placements) -> int | None:
        left = list(placements)
        for row in hub.placements:
            if row != LIFTED:
                left.remove(row)
        hits = np.flatnonzero(hub.choices == left[0])
        return int(hits[0]) if len(hits) else None

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
        slot = placements.index(LIFTED)
        fits = np.ones(len(self._problem.fingers.placements), dtype=bool)
        for other, row in enumerate(placements):
            pair = self._judge.clear[slot][other]
            if pair is not None:
                fits &= pair[:, row]
        hub = Hub(placements, np.flatnonzero(fits), self.tables.node_free.shape[2])
        every = np.arange(len(hub.choices))
        pool = self._backend.pool
        hub_rows(hub.rows, slot, hub.choices, every, self.tables, pool.tables, hub.table)
        hub.versions[:] = pool.version
        for index in every:
            if self.lane_of(hub, index) in self._lanes:
                hub.versions[index] = -2
        self._revalue(hub)
        return hub

    def _revalue(self, hub: Hub) -> None:
        tables = self.tables
        best = hub.table.min(axis=0, initial=np.inf)
        hub.value = np.minimum(best, tables.X_regr + tables.least)
        hub.value[hub.stable == 0] = np.inf
        for k, row in enumerate(hub.placements):
            if row != LIFTED:
                hub.value[~tables.node_free[k, row]] = np.inf

    def refined(self, hub: Hub, config: int) -> bool:
        """Renew the hub's bound at a node until it rests on a fresh row; whether it changed."""
        pool, before = self._backend.pool, hub.value[config]
        while len(hub.choices):
            index = int(np.argmin(hub.table[:, config]))
            best = hub.table[index, config]
            if best == np.inf or hub.versions[index] == pool.version:
                break
            if hub.versions[index] == -2:
                hub.table[index] = self.lane(self.lane_of(hub, index)).d
                if hub.table[index, config] == best:
                    break
            else:
                one = np.array([index])
                hub_rows(hub.rows, hub.slot, hub.choices, one, self.tables, pool.tables, hub.table)
                hub.versions[index] = pool.version
        self._revalue(hub)
        return bool(hub.value[config] != before)

    def target(self, lane: Lane, config: int, g: float) -> tuple[float, int, Hub | None]:
        """Return the cheapest conceivable way on from a node of a lane at cost ``g``.

        Returns:
            Its cost, the node to go to, and the hub to enter there (None: it is the goal).
        """
        shape = (len(lane.rows), len(lane.d))
        V, G = np.empty(shape), np.full(shape, np.inf)
        hubs = self._hub_sets(lane.placements)
        hub_defaults(lane.rows, self.tables, V)
        while True:
            for k, hub_set in enumerate(hubs):
                known = self._hubs.get(hub_set)
                if known is not None:
                    V[k], G[k] = known.value, known.reached
            cost, node, slot = best_target(
                config, g, lane.costs, lane.d, V, G, self.tables.X_regr
            )
            if slot < 0:
                return cost, node, None
            new = hubs[slot] not in self._hubs
            hub = self.hub(hubs[slot])
            if not self.refined(hub, node) and not new:
                return cost, node, hub

    def judge_rest(self, hub: Hub, config: int) -> bool:
        """Decide whether the rest of the hand holds the object at a node."""
        if hub.stable[config] < 0:
            fingers = tuple(k for k in self._fingers if k != hub.slot)
            rows = tuple(hub.placements[k] for k in fingers)
            q = self._problem.lattice.coordinates(config)
            state, z_min = self._judge.environment(q, None), self._problem.mechanics.z_min
            z = self._backend.decide(state, fingers, rows, z_min).z
            hub.stable[config] = z >= z_min
            self._revalue(hub)
        return bool(hub.stable[config])

    def judge_arcs(self, lane: Lane, tail: int, head: int) -> bool:
        """Decide the lane's arcs from node ``tail`` to ``head``, least likely to hold first.

        Returns:
            Whether all hold; else the lane's bounds have changed.
        """
        way = 0 if head >= tail else 1
        span = slice(min(tail, head), max(tail, head))
        states = (self.tables.forward, self.tables.backward)[way]
        undecided = np.argwhere(np.isinf(lane.known[way, span]))
        undecided[:, 0] += span.start
        # Smallest bound first; among equals from the far end, where paths tend to fail.
        nearness = undecided[:, 0] * (1 if way else -1)
        bounds = lane.z[way, undecided[:, 0], undecided[:, 1]]
        holds = True
        for k in np.lexsort((nearness, bounds)):
            i, j = undecided[k]
            if np.isinf(lane.known[way, i, j]) and not self._judge_state(lane, int(states[i, j])):
                holds = False
                break
        self.renewed(lane, force=True)
        return holds

    def _judge_state(self, lane: Lane, state: int) -> bool:
        """Decide one contact state for a lane and write it to all its segments in that state."""
        z_min = self._problem.mechanics.z_min
        decision = self._backend.decide(state, self._fingers, lane.placements, z_min)
        holds = decision.outcome is Outcome.STABLE and decision.z >= z_min
        margin = decision.z / self._backend.scale if holds else BLOCKED
        for way, states in enumerate((self.tables.forward, self.tables.backward)):
            lane.known[way][states == state] = margin
        return holds
