"""Sets of placements along one route: what was decided of each, and what bounds say."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.sets import LIFTED, PlacementSets
from gm_ompl.mechanics.cuts import BLOCK, CutTables
from gm_ompl.problem import Placements
from gm_ompl.sampling.routes import Route
from gm_ompl.sampling.screening import RouteTables, reaches, reaches_back, stride_costs

FAILED = -1.0
"""Stands for a margin that is known to be below z_min."""


@final
class LaneStore:
    """All that is known of sets along one route. A set along a route is a lane.

    Args:
        judge: answers about the problem.
        sets: canonical sets, shared by all routes.
        route: the route.

    Attributes:
        route: likewise.
        margins: per lane, (K, P), z where decided, +inf where not, FAILED where below z_min.
    """

    def __init__(self, judge: Judge, sets: PlacementSets, route: Route) -> None:
        problem, backend = judge.problem, judge.backend
        self._judge, self._backend, self._sets, self.route = judge, backend, sets, route
        self._fingers = tuple(range(problem.fingers.count))
        self._z_min = problem.mechanics.z_min
        self._pool = backend.pool if isinstance(backend, KernelBackend) else None
        scale = backend.scale if isinstance(backend, KernelBackend) else 1.0
        self._X_stab = problem.cost.stability / scale
        self._scale = scale
        self.tables = RouteTables(route.states, route.free, self._z_min / scale)
        self.margins: dict[Placements, Array] = {}
        self._rests: dict[tuple[Placements, int], bool] = {}

    @property
    def cuts(self) -> CutTables:
        """The cuts that decisions have left; none without the compiled kernel."""
        if self._pool is not None:
            return self._pool.tables
        rows = len(self._judge.problem.fingers.placements)
        return CutTables(
            np.zeros((0, 1), dtype=np.int64),
            np.zeros(0, dtype=np.int64),
            np.zeros((0, BLOCK)),
            np.zeros((0, 1, rows, BLOCK)),
            np.zeros(len(self._fingers), dtype=np.int64),
        )

    @property
    def version(self) -> int:
        """Grows with every cut."""
        return 0 if self._pool is None else self._pool.version

    def screen(self, sets: IntArray, first: int, last: int, reach: IntArray) -> None:
        """Tighten ``reach`` (L,): how far each set (L, n) may come from ``first`` to ``last``.

        Where ``last`` is the smaller vertex the motion is followed backwards, from its end.
        """
        if last >= first:
            reaches(sets, first, last, self.tables, self.cuts, reach)
        else:
            reaches_back(sets, first, last, self.tables, self.cuts, reach)

    def costs(self, sets: IntArray) -> Array:
        """Return lower bounds (L, K) on Eq. (9) per set and stride, from all that is known."""
        K, P = self.route.states.shape
        known = np.full((len(sets), K, P), np.inf)
        for m, row in enumerate(sets.tolist()):
            decided = self.margins.get(tuple(row))
            if decided is not None:
                known[m] = decided / self._scale
        costs = np.empty((len(sets), K))
        lengths = self.route.lengths
        stride_costs(sets, known, lengths, self._X_stab, self.tables, self.cuts, costs)
        return costs

    def decided(self, lane: Placements) -> Array:
        """Return the margins of ``lane`` (K, P), to be read."""
        known = self.margins.get(lane)
        if known is None:
            known = self.margins[lane] = np.full(self.route.states.shape, np.inf)
        return known

    def probe(self, lane: Placements, first: int, last: int) -> int:
        """Decide the strides of ``lane`` from vertex ``first`` towards ``last`` until one fails.

        Mechanics alone: ``screen`` knows the geometry. The segments that fail most often are asked
        first.

        Returns:
            ``last`` if all hold; else the vertex beyond which the failing stride lies, as seen
            from ``first``. Strides before it may still be undecided.
        """
        low, high = min(first, last), max(first, last)
        margins = self.decided(lane)
        bad = np.flatnonzero((margins[low:high] == FAILED).any(axis=1))
        if len(bad):
            return int(low + bad[0]) if last > first else int(low + bad[-1] + 1)
        open_ = np.argwhere(np.isinf(margins[low:high]))
        doubt = self.route.suspicion()[low:high]
        order = np.argsort(-doubt[open_[:, 0], open_[:, 1]])
        for k, p in open_[order].tolist():
            if not self._segment_holds(lane, margins, low + k, p):
                return int(low + k if last > first else low + k + 1)
        return last

    def _segment_holds(self, lane: Placements, margins: Array, k: int, p: int) -> bool:
        state = self.route.state(k, p)
        z = self._backend.bound(state, self._fingers, lane)
        if z >= self._z_min:
            z = self._backend.decide(state, self._fingers, lane, self._z_min).z
        holds = z >= self._z_min
        margins[k, p] = z if holds else FAILED
        self.route.tried[k, p] += 1.0
        self.route.failed[k, p] += not holds
        return bool(holds)

    def valid_at(self, vertex: int, lane: Placements) -> bool:
        """Whether the set is geometrically valid at a vertex, fingertips' clearance included."""
        free = self.route.node_free
        return all(free[i, row, vertex] for i, row in enumerate(lane)) and self._judge.apart(lane)

    def lifted(self, lane: Placements, slot: int) -> Placements:
        """Return the canonical set of ``lane`` with the finger at ``slot`` lifted."""
        return self._sets.replaced(lane, slot, LIFTED)

    def rest_known(self, hub: Placements, vertex: int) -> bool | None:
        """Return whether the rest of the hand holds the object, None where not decided."""
        return self._rests.get((hub, vertex))

    def rest_holds(self, hub: Placements, vertex: int) -> bool:
        """Whether the fingers of ``hub`` that are not lifted hold the object at rest."""
        known = self._rests.get((hub, vertex))
        if known is None:
            fingers = tuple(i for i in self._fingers if hub[i] != LIFTED)
            rows = tuple(hub[i] for i in fingers)
            state = self.route.rest_state(vertex)
            known = self._backend.decide(state, fingers, rows, self._z_min).z >= self._z_min
            self._rests[hub, vertex] = known
        return known

    def targets(self, hub: Placements, vertex: int) -> IntArray:
        """Return the canonical sets (L, n) that the lifted finger of ``hub`` can make there."""
        return self._completed(hub, self.route.node_free[hub.index(LIFTED), :, vertex])

    def anywhere(self, hub: Placements) -> IntArray:
        """Return the canonical sets (L, n) that the lifted finger of ``hub`` can make somewhere."""
        return self._completed(hub, self.route.node_free[hub.index(LIFTED)].any(axis=1))

    def _completed(self, hub: Placements, free: BoolArray) -> IntArray:
        slot, fits = hub.index(LIFTED), free.copy()
        for other, row in enumerate(hub):
            pair = self._judge.clear[slot][other]
            if pair is not None and row != LIFTED:
                fits &= pair[:, row]
                # Equal fingertips of no size would fit on one point; two on one are one.
                fits[row] = False
        rows = np.flatnonzero(fits).tolist()
        return as_sets((self._sets.replaced(hub, slot, row) for row in rows), len(hub))


def as_sets(sets: Iterable[Placements], count: int) -> IntArray:
    """Return sets of ``count`` fingers as an array (L, count)."""
    return np.array(list(sets), dtype=np.int64).reshape(-1, count)
