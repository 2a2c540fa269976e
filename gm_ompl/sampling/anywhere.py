"""Searches with fingers anywhere on the faces: over points drawn at random, ever again.

A search by trees or over samples knows a table of placements. Here it gets one of random points;
while it finds no plan, tables grow. A search for ever better plans goes on among new points, from
the best plan; in turns with it, that plan's fingers are moved on their faces (``finger_moves``),
and sets are sought that spare its regrasps (``climb``).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol, final

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.holds.spots import NamedPoints, PlacedPlan, rows_of
from gm_ompl.holds.watch import Stop
from gm_ompl.problem import Move, Problem, Regrasp
from gm_ompl.sampling.climb import Climb
from gm_ompl.sampling.drawing import drawn
from gm_ompl.sampling.explorer import Course
from gm_ompl.sampling.finger_moves import FingerMoves
from gm_ompl.sampling.placing import Placing

FIRST_POINTS: Final = 150
"""Points of the first table, about."""

MOST_POINTS: Final = 2000
"""Tables grow no further."""

FIRST_PATIENCE: Final = 100
"""Iterations in vain before the first table grows; before each further time half as many more."""

NEAR: Final = 16
"""Points drawn around each placement of the best plan."""

RARER: Final = 6
"""Iterations between two climbs, times those so far."""

TURNS: Final = 2
"""Fingers are moved in one of so many iterations."""

PATIENCE: Final = 40
"""Iterations in vain, with a plan, before a new table."""


class Search(Protocol):
    """A search that goes on an iteration at a time."""

    cost: float
    moves: tuple[Move, ...]

    @property
    def branches(self) -> int:
        """How much it has gathered."""

    @property
    def courses(self) -> Sequence[Course]:
        """The routes tried so far, with the trees grown along them."""

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether the best plan changed."""


MakeSearch = Callable[[Judge, Sequence[Move]], Search]
"""Makes a search over a problem's table, from a plan on: no moves are none."""


@final
class AnywhereSearch:
    """A search over one table of points after the other.

    Args:
        placing: makes judges of few placements.
        problem: what to plan.
        make: makes the search over a table.
        rng: the source of randomness.

    Attributes:
        cost: of the best plan, +inf without one.
        moves: the best plan's; placements by the rows of ``table``.
    """

    def __init__(
        self, placing: Placing, problem: Problem, make: MakeSearch, rng: np.random.Generator
    ) -> None:
        self._placing, self._problem, self._make, self._rng = placing, problem, make, rng
        self._named = NamedPoints(problem.fingers)
        self._points, self._patience = FIRST_POINTS, float(FIRST_PATIENCE)
        self._table: Drawn | None = None
        self._turn = 0
        self._moving: FingerMoves | None = None
        self._moved = math.inf
        self._climb: Climb | None = None
        self._climbed = self._climb_due = 0
        self.cost, self.moves = math.inf, tuple[Move, ...]()

    @property
    def table(self) -> PlacementTable:
        """The placements that the moves name, now and before."""
        return self._named.table

    @property
    def branches(self) -> int:
        """Branches and lanes of the search over the present table."""
        return 0 if self._table is None else self._table.search.branches

    @property
    def courses(self) -> Sequence[Course]:
        """None: the placements along them are those of tables that come and go."""
        return ()

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether the best plan changed."""
        self._turn += 1
        if self._turn % TURNS == 0:
            climb = self._climbing()
            if climb is not None:
                return self._climb_on(climb)
            if self._moving is not None:
                return self._move_fingers(self._moving, stop)
        if self._table is None:
            self._table = self._drawn()
        table = self._table
        changed = table.step(stop) and self._keep(table.plan)
        if changed:
            self._move_from_here()
        if table.vain >= (self._patience if self.cost == math.inf else PATIENCE):
            self._leave(table)
        return changed

    def _drawn(self) -> Drawn:
        """Draw a table around the best plan's placements, to be searched from that plan on."""
        spots = self._placing.spots
        best = [spots.of(self._named.table, row) for row in rows_of(self.moves)]
        # Cubed: most are near, some are far.
        near = spots.around(best, 1.0, self._rng.normal(size=(NEAR, 2)) ** 3)
        judge = self._placing.judge([*best, *near, *drawn(spots, self._points, self._rng)])
        moves = NamedPoints(judge.problem.fingers).named(self.moves, self._named.table)
        return Drawn(judge, self._make(judge, moves))

    def _leave(self, table: Drawn) -> None:
        """Let go of a table; without a plan, the next one is larger."""
        self._placing.done(table.judge)
        self._table = None
        if self.cost == math.inf:
            self._patience *= 1.5
            self._points = min(2 * self._points, MOST_POINTS)

    def _move_from_here(self) -> None:
        """Move the best plan's fingers from now on, if it is much better than what was moved."""
        moved = self._moved if self._moving is None else self._moving.plan.cost
        if self.moves and self.cost * (1.0 + self._placing.gap) < moved:
            problem = dataclasses.replace(self._problem, fingers=self._named.fingers)
            self._moving = FingerMoves(self._placing, problem, self.moves, self._rng)

    def _climbing(self) -> Climb | None:
        """Return a climb to a set that spares the best plan's regrasps, if it is time for one."""
        dear = any(isinstance(move, Regrasp) for move in self.moves) or (
            self.cost == math.inf and self._points > FIRST_POINTS
        )
        courses = () if self._table is None else self._table.search.courses
        if self._climb is None and dear and courses and self._turn >= self._climb_due:
            way = courses[int(self._rng.integers(len(courses)))].store.route.way
            self._climb = Climb(self._placing, way, self._rng)
        return self._climb

    def _climb_on(self, climb: Climb) -> bool:
        climb.step()
        changed = climb.plan is not None and self._keep(climb.plan)
        if changed:
            self._move_from_here()
        if climb.over:
            self._climb, self._climbed = None, self._climbed + 1
            self._climb_due = self._turn + RARER * self._climbed
        return changed

    def _move_fingers(self, moving: FingerMoves, stop: Stop) -> bool:
        better = moving.step(stop) and self._keep(moving.plan)
        if moving.over:
            self._moving, self._moved = None, moving.plan.cost
        return better

    def _keep(self, plan: PlacedPlan) -> bool:
        """Keep a plan if it is the best one."""
        if not plan.cost < self.cost:
            return False
        self.moves, self.cost = self._named.named(plan.moves, plan.table), plan.cost
        return True


@dataclass
class Drawn:
    """A search over one table.

    Attributes:
        judge: of the problem with these placements alone.
        search: searches.
        vain: iterations since it found a better plan.
    """

    judge: Judge
    search: Search
    vain: int = 0

    @property
    def plan(self) -> PlacedPlan:
        """The best plan of the search, which has one."""
        table = self.judge.problem.fingers.placements
        return PlacedPlan(self.search.moves, table, self.search.cost)

    def step(self, stop: Stop) -> bool:
        """Do one iteration; return whether it found a better plan."""
        changed = self.search.step(stop)
        self.vain = 0 if changed else self.vain + 1
        return changed
