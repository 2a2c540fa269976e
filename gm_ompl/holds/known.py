"""What was decided of sets of placements along the arcs of a table."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray, rows_of
from gm_ompl.cores import share_out
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.holds.bounds import refresh_many
from gm_ompl.holds.rows import Tables
from gm_ompl.holds.sets import LIFTED
from gm_ompl.holds.tables import ArcTable
from gm_ompl.mechanics.cuts import BLOCK, CutTables
from gm_ompl.problem import Placements

FAILED: Final = -1.0
"""Stands for a margin that is known to be below z_min."""

UNDECIDED: Final = -1
"""Of a rest: neither 1, it holds, nor 0, it does not."""

WORTH_A_THREAD: Final = 100_000
"""Segments that take longer to bound than it takes to start a thread."""

SEGMENTS_AT_ONCE: Final = 5_000_000
"""Segments bounded between two looks at the limits in force: some tenths of a second."""


def at_once(tables: Tables) -> int:
    """Return how many sets of placements are bounded between two looks at the limits in force."""
    return int(max(1, SEGMENTS_AT_ONCE // max(1, tables.states.size)))


@final
class Known:
    """All that was decided of sets and hubs on one table.

    Args:
        judge: answers about the problem.
        table: the arcs.

    Attributes:
        table: likewise.
    """

    def __init__(self, judge: Judge, table: ArcTable) -> None:
        backend = judge.backend
        self._judge, self._backend, self.table = judge, backend, table
        self._fingers = tuple(range(judge.problem.fingers.count))
        self._z_min = judge.problem.mechanics.z_min
        kernel = backend if isinstance(backend, KernelBackend) else None
        self._pool = None if kernel is None else kernel.pool
        self._scale = 1.0 if kernel is None else kernel.scale
        self._margins: dict[Placements, Array] = {}
        self._rests: dict[Placements, IntArray] = {}

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

    def margins(self, placements: Placements) -> Array:
        """Return the margins of a set (K, P), over the kernel's unit of force.

        They are +inf where undecided, FAILED where below z_min.
        """
        known = self._margins.get(placements)
        if known is None:
            known = np.full(self.table.tables.states.shape, np.inf)
            self._margins[placements] = known
        return known

    def decide(self, placements: Placements, state: int) -> float:
        """Decide a set at a contact state; return its margin as ``margins`` has it."""
        limits.check()
        z = self._backend.bound(state, self._fingers, placements)
        if z >= self._z_min:
            z = self._backend.decide(state, self._fingers, placements, self._z_min).z
        return z / self._scale if z >= self._z_min else FAILED

    def rests(self, hub: Placements) -> IntArray:
        """Return per node (V,) whether the fingers of a hub hold the object: 1, 0 or UNDECIDED."""
        known = self._rests.get(hub)
        if known is None:
            known = np.full(len(self.table.tables.goal), UNDECIDED)
            self._rests[hub] = known
        return known

    def all_rests(self) -> Iterable[tuple[Placements, IntArray]]:
        """Return every hub that was asked for, with its ``rests``."""
        return self._rests.items()

    def rest_holds(self, hub: Placements, node: int) -> bool:
        """Whether the fingers of ``hub`` that are not lifted hold the object at rest."""
        known = self.rests(hub)
        if known[node] == UNDECIDED:
            limits.check()
            fingers = tuple(i for i in self._fingers if hub[i] != LIFTED)
            rows, state = tuple(hub[i] for i in fingers), self.table.rest_state(node)
            z = self._backend.decide(state, fingers, rows, self._z_min).z
            known[node] = z >= self._z_min
        return bool(known[node])

    def bounds(self, sets: IntArray) -> tuple[Array, Array]:
        """Return for sets (L, n) lower bounds on Eq. (9) (L, K), and on the cost to go (L, V)."""
        tables = self.table.measured
        found = [np.full(tables.states.shape, np.inf)]
        places = np.zeros(len(sets), dtype=np.int64)
        for i, margins in enumerate(map(self._margins.get, rows_of(sets))):
            if margins is not None and np.isfinite(margins).any():
                places[i] = len(found)
                found.append(margins)
        known, cuts = np.array(found), self.cuts
        costs = np.empty((len(sets), len(tables.states)))
        d = np.empty((len(sets), len(tables.goal)))

        def work(part: slice) -> None:
            refresh_many(sets[part], tables, cuts, places[part], known, costs[part], d[part])

        least = max(1, WORTH_A_THREAD // max(1, tables.states.size))
        share_out(work, len(sets), least, at_once(tables))
        return costs, d
