"""Exact search over all placements on the listed faces, up to a gap.

Cells of whole faces, halved without end, bound what plans cost at least (``cell_search``). Plans
come from points: searched over few placements at once, they are exact there. First come the grid's
placements; then points around the best plan's, ever nearer; then those of cells that stand in front
of the search. It ends once no cell can hold a plan that is cheaper than the best by the gap.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Final, final

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.patches import frames
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_products import Product
from gm_ompl.holds.face_cells import FaceCells
from gm_ompl.holds.spots import NamedPoints, Spot, Spots, rows_of
from gm_ompl.planners.cell_search import CellSearch
from gm_ompl.planners.lane_parts import PartTask, part_search
from gm_ompl.planners.outcome import PROVEN, Log, without_search
from gm_ompl.planners.planner import Meter, Report, SearchResult, Status, silent
from gm_ompl.planners.trace import tracer
from gm_ompl.problem import Move, Problem

ON_GRID: Final = 500
"""Lanes or products expanded at most for a first plan on the grid."""

ON_POINTS: Final = 60
"""Likewise on a few points."""

NEAREST: Final = 0.02
"""How near the best plan's placements others are looked at, in half sizes of the face: this much
of the gap."""

FIRST_LOOK: Final = 32
"""Products after which one is looked into first."""

RARELY: Final = 4
"""Then after one more in so many."""

TURNS: Final = 8
"""What is followed down is looked into each time it was divided so often."""

BETTER: Final = 1e-9
"""A plan is better if it is cheaper by this, relatively."""


def solve_anywhere(problem: Problem, judge: Judge, budget: Meter, report: Report) -> SearchResult:
    """Search for a plan that costs at most a gap more than any other on the faces.

    ``problem.fingers.anywhere`` says where, and the gap. The bound holds for all placements on the
    faces, the object on its lattice.

    Args:
        problem: what to plan.
        judge: answers about it.
        budget: the running budget.
        report: told of the progress.

    Raises:
        InputError: the start or the goal is off the lattice.
    """
    log = Log(budget, judge, report)
    found: PointPlans | None = None
    try:
        found = PointPlans(problem, judge, log)
        return _searched(problem, judge, log, found, report)
    except KeyboardInterrupt:
        status, why = Status.INTERRUPTED, ""
    except LimitError as stopped:
        status, why = Status.BUDGET, str(stopped)
    if found is None or found.cost == math.inf:
        return without_search(status, 0.0, log.meter, why)
    status = Status.SOLVED if status is Status.BUDGET else status
    return found.result(status, 0.0, log.statistics(0, 0, placement_sets=0))


def _searched(
    problem: Problem, judge: Judge, log: Log, found: PointPlans, report: Report
) -> SearchResult:
    """Find a first plan; bound all plans by cells."""
    hand = problem.fingers
    frame = frames(found.patches, hand.placements.labels)
    framed = dataclasses.replace(problem, fingers=dataclasses.replace(hand, placements=frame))
    backend = found.backend.of_hand(framed)
    bare = judge.of_hand(framed, backend)
    found.begin()
    graph = CellGraph(
        framed, bare, backend, log.meter.spent,
        tree=lambda table: FaceCells(bare, table, found.patches, hand.placements),
    )  # fmt: skip
    search = CellSearch(framed, bare, graph, log, tracer(report), sample=found)
    status = search.run()
    if found.cost < math.inf and status is not Status.INTERRUPTED:
        status = Status.SOLVED
    statistics = log.statistics(search.expanded, search.generated, placement_sets=graph.lanes_met)
    return found.result(status, search.bound, statistics)


@final
class PointPlans:
    """Plans over few placements at once, and the best of them.

    Args:
        problem: what to plan.
        judge: answers about it.
        log: of the whole search.

    Attributes:
        patches: where fingers may be placed.
        cost: of the best plan, or +inf.
        decisions: mode decisions made.
        backend: the problem's.
    """

    def __init__(self, problem: Problem, judge: Judge, log: Log) -> None:
        where = problem.fingers.anywhere
        assert where is not None, "the scenario asks for it"
        self._problem, self._judge, self._log, self._where = problem, judge, log, where
        self._points = Spots(problem)
        self.patches = self._points.patches
        self.cost, self.decisions = math.inf, 0
        assert isinstance(judge.backend, KernelBackend), "the scenario asks for it"
        self.backend = judge.backend
        self._moves: tuple[Move, ...] = ()
        self._table = problem.fingers.placements
        self._due = FIRST_LOOK

    @property
    def enough(self) -> float:
        """What no plan may be cheaper than for the best one to be within the gap."""
        return self.cost / (1.0 + self._where.gap)

    def begin(self) -> None:
        """Find a first plan on the grid, and better ones around it."""
        self._take(self._problem, self._judge, ON_GRID)
        self._refine()
        self._log.event(self.cost, 0.0, 0, 0)

    def look_in(self, graph: CellGraph, product: Product, expanded: int, turn: int | None) -> float:
        """Look for a plan in a product, now and then; return ``enough``. See ``Sample``."""
        if turn is None and expanded >= self._due:
            self._due = expanded + max(FIRST_LOOK, expanded // RARELY)
            turn = 0
        if turn is not None and turn % TURNS == 0:
            cells = graph.cells
            assert isinstance(cells, FaceCells), "made for these cells"
            spots = [
                (int(cells.boxes.faces[cell]), tuple(point))
                for cell in dict.fromkeys(product.cells)
                for point in cells.places(cell).tolist()
            ]
            if self._look_at(spots):
                self._refine()
        return self.enough

    def _refine(self) -> None:
        """Look around the best plan's placements, ever nearer."""
        reach = 0.25
        while (
            self.cost < math.inf
            and reach >= NEAREST * self._where.gap
            and not self._log.meter.spent()
        ):
            before = self.cost
            little = 0.1 * self._where.gap * before
            near = self._points.around(self._spots(), reach)
            if not self._look_at(near) or before - self.cost < little:
                reach /= 2.0

    def _spots(self) -> list[Spot]:
        """Return where the best plan has its fingers, each place once."""
        return [self._points.of(self._table, row) for row in rows_of(self._moves)]

    def _look_at(self, spots: Sequence[Spot]) -> bool:
        """Search over these points and the placements that the hand must start and end at."""
        problem = self._points.placed(spots)
        judge = self._judge.of_hand(problem, self.backend.of_hand(problem))
        return self._take(problem, judge, ON_POINTS)

    def _take(self, problem: Problem, judge: Judge, most: int) -> bool:
        """Search over a problem's placements; whether its plan is better than the best."""
        meter = self._log.meter.within(most)
        result = part_search(PartTask(problem, judge, Log(meter, judge), silent)).run()
        self.decisions += int(result.statistics["mode_decisions"])
        if result.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if result.cost is None or not result.cost < self.cost * (1.0 - BETTER):
            return False
        self.cost, self._moves, self._table = result.cost, result.moves, problem.fingers.placements
        return True

    def result(self, status: Status, bound: float, statistics: dict[str, object]) -> SearchResult:
        """Return the best plan with the bound that was proved."""
        statistics = {**statistics, "mode_decisions": self.decisions}
        if not self._moves and self.cost == math.inf:
            return SearchResult(status, lower_bound=bound, statistics=statistics)
        named = NamedPoints(self._problem.fingers)
        moves = named.named(self._moves, self._table)
        bound = min(bound, self.cost)
        return SearchResult(
            status=status,
            moves=moves,
            cost=self.cost,
            lower_bound=bound,
            optimal=self.cost <= bound * (1.0 + PROVEN),
            statistics={**statistics, "gap": self.cost / bound - 1.0 if bound > 0.0 else None},
            fingers=named.fingers,
        )
