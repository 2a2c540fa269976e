"""Keys of products of cells: lower bounds on all plans in one, and the way that a bound is of."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.graph.cell_bounds import follow, least_margin, to_go
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_products import Product


@final
class Keys:
    """Asks for keys; knows more of the product whose key was asked last.

    Args:
        graph: the lanes of cells.

    Attributes:
        D: (m, V), see ``cell_bounds.to_go``, of that product.
    """

    def __init__(self, graph: CellGraph) -> None:
        self._graph = graph
        self.D: Array = np.empty((0, 0))
        self._lift: Array = np.empty((0, 0))

    def key(self, product: Product) -> float:
        """Return a lower bound on every plan in a product."""
        graph, (m, V) = self._graph, (len(product.legs), len(self._graph.nodes))
        self.D, self._lift = np.empty((m, V)), np.empty((m - 1, V))
        to_go(
            product.legs, product.rests, graph.lanes, graph.resting, graph.cells.tables, self.D,
            self._lift,
        )  # fmt: skip
        return float(self.D[0, graph.start])

    def renewed(self, product: Product) -> float:
        """Return ``key`` with all bounds renewed."""
        for lane in product.legs.tolist():
            self._graph.renewed(lane)
        for rest in product.rests.tolist():
            self._graph.rest_renewed(rest)
        return self.key(product)

    def steps(self, product: Product) -> IntArray:
        """Return the cheapest way of the product whose key was asked last, see ``follow``."""
        graph = self._graph
        steps = np.empty((len(product.legs) * (len(graph.nodes) + 1), 3), dtype=np.int64)
        tables = graph.tables_of(int(product.legs[-1]))
        count = follow(graph.start, product.legs, graph.lanes, tables, self.D, self._lift, steps)
        return steps[:count]

    def margin(self, product: Product) -> float:
        """Return the least margin on the way of the product whose key was asked last."""
        graph, steps = self._graph, self.steps(product)
        lanes, resting, tables = graph.lanes, graph.resting, graph.cells.tables
        return least_margin(steps, product.legs, product.rests, lanes, resting, tables)
