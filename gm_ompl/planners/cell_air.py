"""Ways through the air of plans found over cells of placements."""

from __future__ import annotations

import dataclasses
from typing import final

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.graph.cell_bounds import REGRASP
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_products import Product
from gm_ompl.holds.sets import LIFTED, staying_of
from gm_ompl.problem import Placements, Problem


@final
class CellAir:
    """Answers about products of single placements.

    Args:
        problem: the problem.
        judge: answers about it.
        graph: the lanes of cells.
    """

    def __init__(self, problem: Problem, judge: Judge, graph: CellGraph) -> None:
        self._hand, self._reach, self._graph = problem.fingers, judge.reach, graph
        self._objects = problem.object_graph

    def sets(self, product: Product) -> list[Placements]:
        """Return the canonical set of each leg."""
        found = []
        for leg in product.skeleton.legs:
            placements = self._graph.placements(tuple(product.cells[spot] for spot in leg))
            assert placements is not None, "a cell has several placements"
            found.append(placements)
        return found

    def doubted(self, product: Product, steps: IntArray) -> Product | None:
        """Return the product where fingers have their ways through the air along ``steps``.

        Else the product without what fails there, or None where nothing is left of it.
        """
        graph, reach, sets = self._graph, self._reach, self.sets(product)
        start = self._pose(graph.start)
        if reach.landing(start, sets[0], self._hand.standing) is None:
            return None
        for m, arc, node in steps.tolist():
            if arc == REGRASP and not self._joined(product, m, node):
                rests = product.rests.copy()
                rests[m] = graph.barred(int(rests[m]), node)
                return dataclasses.replace(product, rests=rests)
        end = graph.end(steps)
        if self._hand.leave and reach.landing(self._pose(end), sets[-1]) is None:
            graph.close(int(product.legs[-1]), end)
            return dataclasses.replace(product)
        return product

    def _joined(self, product: Product, m: int, node: int) -> bool:
        """Whether the finger of regrasp m gets to its new placement at a node."""
        skeleton, cells = product.skeleton, self._graph.cells
        finger = skeleton.lifted[m]
        a, b = (cells.row(product.cells[skeleton.legs[k][finger]]) for k in (m, m + 1))
        held = [product.cells[spot] for spot in skeleton.legs[m]]
        held[finger] = LIFTED
        hub = self._graph.placements(tuple(held))
        assert hub is not None, "a cell has several placements"
        slot, staying = hub.index(LIFTED), staying_of(hub)
        return self._reach.joined(self._pose(node), slot, staying, a, b)

    def _pose(self, node: int) -> Pose:
        return self._objects.pose(self._graph.nodes[node])
