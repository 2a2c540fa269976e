"""Where the search over cells looks at a product, and what looks into its cells."""

from __future__ import annotations

import math
from typing import Final, Protocol

from gm_ompl.arrays import IntArray
from gm_ompl.graph.cell_bounds import REGRASP, weakest
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_products import Product

GOLDEN: Final = (math.sqrt(5.0) - 1.0) / 2.0
"""Multiples of it, less whole numbers, lie evenly."""


class Sample(Protocol):
    """Finds plans for placements in cells without end.

    Attributes:
        cost: of the best plan, or +inf.
    """

    cost: float

    @property
    def enough(self) -> float:
        """A lower bound that proves the best plan good enough."""

    def look_in(self, graph: CellGraph, product: Product, expanded: int, turn: int | None) -> float:
        """Look for a plan in a product, now and then; return ``enough``.

        Args:
            graph: the lanes of cells.
            product: where to look.
            expanded: products taken from the front so far.
            turn: how often a product that is followed down was divided; None for another.
        """


def doubt(graph: CellGraph, product: Product, steps: IntArray, most: float) -> tuple[bool, int]:
    """Look at where a way may hold least; return whether it may hold, and the looks.

    Args:
        graph: the lanes of cells.
        product: whose way it is.
        steps: the way, see ``cell_bounds.follow``.
        most: how many looks.
    """
    legs, rests, looks = product.legs, product.rests, 0
    while looks < most:
        lanes, resting, tables = graph.lanes, graph.resting, graph.cells.tables
        i, part = weakest(steps, legs, rests, lanes, resting, tables)
        if i < 0:
            break
        looks += 1
        m, arc, node = steps[i].tolist()
        if arc == REGRASP:
            holds = graph.look_at_rest(int(rests[m]), node)
        else:
            holds = graph.look(int(legs[m]), arc, part)
        if not holds:
            return False, looks
    return True, looks


def glance(graph: CellGraph, product: Product, steps: IntArray, turn: int) -> bool:
    """Look at one more segment of a way, elsewhere every ``turn``; whether it may hold.

    Cuts tell little of how weak segments are at which nothing was looked at for long.
    """
    tables = graph.cells.tables
    P = tables.states.shape[1]
    i, part = divmod(int(turn * GOLDEN % 1.0 * len(steps) * P), P)
    m, arc, _ = steps[i].tolist()
    if arc == REGRASP or graph.lanes.looked[product.legs[m], tables.kind[arc], part]:
        return True
    return graph.look(int(product.legs[m]), arc, part)
