"""Exact search over cells of placements: branch and bound.

What waits is a *product*: an order of regrasps (``Skeleton``) and a cell for each placement, keyed
by a lower bound on every plan in it. The one in front is doubted where its margins may be least;
where it stands, its widest cell is halved. Cells lose what is of no use in their product. A product
of single placements is judged exactly, so the first to stand in front is optimal. Plans of k
regrasps wait as one until k X_regr comes first.
"""

from __future__ import annotations

import heapq
import math
from typing import Final, final

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.cell_bounds import REGRASP
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_keys import Keys
from gm_ompl.graph.cell_narrowing import Narrowing
from gm_ompl.graph.cell_products import Product, Products
from gm_ompl.holds.cells import Cells
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.watch import Stop, never
from gm_ompl.planners.cell_air import CellAir
from gm_ompl.planners.cell_looks import Sample, doubt, glance
from gm_ompl.planners.outcome import Log, status_of
from gm_ompl.planners.planner import Status
from gm_ompl.planners.trace import Expansion, Trace
from gm_ompl.problem import Problem

SAME: Final = 1e-9
"""A product is no better than the best plan by less than this, relatively."""

LOOKS: Final = 1
"""Margins doubted before a product is divided."""

RISEN: Final = 1e-3
"""A key that has risen by this, relatively, is not divided before it comes first again."""

FIRST_DIVE: Final = 64
"""Products after which one is followed down to single placements."""

DEEP: Final = 4
"""A dive takes no more than one in so many products."""


@final
class CellSearch:
    """One search; ``run`` may be called once.

    Args:
        problem: what to plan.
        judge: answers about it.
        graph: the lanes of cells.
        log: told of the progress; its budget is spent.
        trace: told of every product.
        beyond: a lower bound on plans that leave the part of the object graph that was explored.
        sample: finds plans, where cells have no end; its plans are no paths of this search.

    Attributes:
        expanded: products taken from the front of the open list.
        bound: no plan is cheaper.
        cost: of the best plan known, or +inf.
        given_up: whether more regrasps than can be listed may be cheaper.
    """

    def __init__(
        self, problem: Problem, judge: Judge, graph: CellGraph, log: Log,
        trace: Trace | None = None, beyond: float = math.inf, sample: Sample | None = None,
    ) -> None:  # fmt: skip
        self._graph, self._products = graph, Products(problem.fingers, graph)
        self._keys, cells = Keys(graph), graph.cells
        self._narrowing: Narrowing | None = None
        if isinstance(cells, Cells):
            self._narrowing = Narrowing(graph, cells, self._products, self._keys)
        self._log, self._trace, self._beyond, self._sample = log, trace, beyond, sample
        self._air = CellAir(problem, judge, graph)
        self._open: list[tuple[float, int, int, float, Product]] = []
        self._next: tuple[float, Product] | None = None  # followed down
        self._aside: list[tuple[float, Product]] = []  # what a dive has passed by: it waits, too
        self._ahead: set[Product] = set()  # what a dive took from there
        self._regrasps, self._dive_at, self._dive_ends, self._dived_at = 0, FIRST_DIVE, 0, 0
        self._best: tuple[Product, IntArray] | None = None
        self.expanded = self.generated = 0
        self.bound, self.cost, self.given_up = 0.0, math.inf, False
        self._dropped = math.inf
        if sample is not None:
            self.cost = sample.enough

    def run(self, pause: Stop = never) -> Status:
        """Search until a plan is proven optimal, or no budget is left, or it gives up.

        Args:
            pause: asked whether to end for now, as if no budget were left.
        """
        status = status_of(lambda: self._run(pause), lambda: self._best is not None)
        self._event()
        return status

    def _run(self, pause: Stop) -> Status:
        while True:
            front = self._front()
            while self._unlisted() <= min(front, self.cost * (1.0 - SAME)) and self._list_more():
                front = self._front()
            f = min(front, self._unlisted())
            self.bound = max(self.bound, min(f, self.cost))
            if f >= self.cost * (1.0 - SAME):
                if self._sample is not None:
                    self.bound = max(self.bound, min(f, self._dropped))
                return Status.INFEASIBLE if self._best is None else Status.SOLVED
            if front >= self.cost * (1.0 - SAME):
                self.given_up = True
                return Status.BUDGET
            if f >= self._beyond and self._best is not None:
                return Status.SOLVED  # the part must grow before more can be proven
            if self._log.meter.spent(self.expanded) or pause():
                return Status.BUDGET
            if self._log.due():
                self._event()
            self._advance()

    def _front(self) -> float:
        while self._open and self._open[0][4] in self._ahead:
            self._ahead.remove(heapq.heappop(self._open)[4])
        waiting = self._open[0][3] if self._open else math.inf
        return waiting if self._next is None else min(waiting, self._next[0])

    def _unlisted(self) -> float:
        """Return a lower bound on plans of more regrasps than were listed."""
        tables = self._graph.cells.tables
        return self._regrasps * tables.X_regr + float(tables.least[self._graph.start])

    def _list_more(self) -> bool:
        """Let the plans of one more regrasp wait; whether they can be listed."""
        found = self._products.begin(self._regrasps)
        if found is None:
            return False
        for product in found:
            self._wait(self._keys.key(product), product)
        self._regrasps += 1
        return True

    def _wait(self, f: float, product: Product) -> None:
        """Let a product wait: of nearly equal keys the one divided most comes first."""
        self._set_aside(f)
        if f < self.cost * (1.0 - SAME):
            self.generated += 1
            key = float(f"{f:.9g}")
            heapq.heappush(self._open, (key, -product.depth, self.generated, f, product))

    def _set_aside(self, f: float) -> None:
        """Take note of what is dropped because the best plan is good enough beside it."""
        if f >= self.cost * (1.0 - SAME):
            self._dropped = min(self._dropped, f)

    def _put_back(self, f: float, product: Product) -> None:
        """Let a product that was treated wait; in a dive it is treated again at once."""
        self._set_aside(f)
        if self.expanded >= self._dive_ends:
            self._wait(f, product)
        elif f < self.cost * (1.0 - SAME):
            self._next = f, product

    def _take(self) -> tuple[float, Product]:
        """Return what comes first, or what a dive comes to next, with its key."""
        if self._next is None and self.expanded < self._dive_ends:
            while self._aside and self._next is None:
                f, product = self._aside.pop()
                if f < self.cost * (1.0 - SAME):
                    self._next = f, product
                    self._ahead.add(product)
        if self._next is None:
            if self.expanded >= self._dive_at:
                self._aside.clear()
                self._dived_at = self.expanded
                self._dive_ends = self.expanded + max(FIRST_DIVE, self.expanded // DEEP)
                self._dive_at = 2 * self._dive_ends
            self._front()
            _, _, _, f, product = heapq.heappop(self._open)
            return f, product
        taken, self._next = self._next, None
        return taken

    def _advance(self) -> None:
        """Treat what comes first, or what is being followed down."""
        f, product = self._take()
        self.expanded += 1
        now, part = self._narrowed(self._keys.renewed(product), product)
        if part is not product or now > f * (1.0 + SAME):
            self._put_back(now, part)
            return
        steps = self._keys.steps(product)
        exact = all(self._graph.cells.row(cell) >= 0 for cell in product.cells)
        holds, looks = doubt(self._graph, product, steps, math.inf if exact else LOOKS)
        self._tell(product, f, exact)
        if exact and looks == 0:
            self._finish(product, steps, now)
            return
        if not exact and holds:
            holds = glance(self._graph, product, steps, self.expanded)
        risen = self._keys.renewed(product)
        if exact or not holds or risen > now * (1.0 + RISEN):
            self._put_back(risen, product)
        elif risen >= self.cost * (1.0 - SAME):
            self._set_aside(risen)
        else:
            if self._sample is not None:
                self._look_in(self._sample, product)
            if self._products.divides(product):
                self._divide(product, risen)
            else:  # it bounds no better than this
                self._dropped = min(self._dropped, risen)

    def _look_in(self, sample: Sample, product: Product) -> None:
        """Let plans be looked for in a product, now and then; a better one ends a dive."""
        turn = product.depth if self.expanded < self._dive_ends else None
        turn = turn if self._products.divides(product) else 0
        enough = sample.look_in(self._graph, product, self.expanded, turn)
        if enough < self.cost:
            self.cost, self._dive_ends = enough, 0

    def _narrowed(self, key: float, product: Product) -> tuple[float, Product]:
        """Return the product whose key was asked last without what is of no use, and its key."""
        if self._narrowing is None:
            return key, product
        return self._narrowing.narrowed(product, key, self.cost * (1.0 - SAME))

    def _divide(self, product: Product, whole: float) -> None:
        """Let the parts of a product of a key wait; in a dive the likeliest comes next.

        That is the one that most likely holds, of those whose keys have hardly risen.
        """
        dives, parts = self.expanded < self._dive_ends, list[tuple[int, float, float, Product]]()
        little = RISEN * (whole - product.regrasps * self._graph.cells.tables.X_regr)
        for part in self._products.divided(product):
            key, part = self._narrowed(self._keys.key(part), part)
            self._set_aside(key)
            if key < self.cost * (1.0 - SAME):
                risen = int((key - whole) / little) if little > 0.0 else 0
                parts.append((risen, -self._keys.margin(part) if dives else 0.0, key, part))
        parts.sort(key=lambda each: each[:3])
        if dives and parts:
            self._put_back(*parts.pop(0)[2:])
        for _, _, key, part in reversed(parts):
            self._wait(key, part)
            if dives:
                self._aside.append((key, part))

    def _finish(self, product: Product, steps: IntArray, cost: float) -> None:
        """Take the plan of a product all of whose margins on the way are judged."""
        instead = self._air.doubted(product, steps)
        if instead is product:
            if self.expanded < self._dive_ends:
                took = max(DEEP, self.expanded - self._dived_at)
                self._dive_at = self.expanded + DEEP * took
            self.cost, self._best, self._dive_ends = cost, (product, steps.copy()), 0
        elif instead is not None:
            self._put_back(self._keys.renewed(instead), instead)

    def path(self) -> tuple[tuple[int, ...], list[Leg]]:
        """Return the best plan's arcs, and its legs along them; both empty without one."""
        if self._best is None:
            return (), []
        product, steps = self._best
        arcs = tuple(arc for arc in steps[:, 1].tolist() if arc != REGRASP)
        legs, at = list[Leg](), 0
        for m, placements in enumerate(self._air.sets(product)):
            count = int(((steps[:, 0] == m) & (steps[:, 1] != REGRASP)).sum())
            legs.append((placements, at, at + count))
            at += count
        return arcs, legs

    def _tell(self, product: Product, f: float, exact: bool) -> None:
        if self._trace is not None:
            q = self._graph.coordinates(self._graph.start)
            placements = self._air.sets(product)[0] if exact else ()
            why = "placements judged" if exact else "cells bounded"
            self._trace(Expansion(q, placements, 0.0, f, why))

    def _event(self) -> None:
        cost = self.cost if self._sample is None else self._sample.cost
        self._log.event(cost, min(self.bound, self._beyond), self.expanded, len(self._open))
