"""Cells lose the placements that are of no use in their product.

A cell stands for its best placement along each arc, whichever that is. But one placement must be
free along all arcs of its legs, and its finger's travel is its own. Where the product's bound with
one placement in the place of its cell is not below what is good enough, that leaves the cell: what
is left is often a small part of it, whose corners bound margins far better.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined
from gm_ompl.graph.cell_bounds import LaneRoom
from gm_ompl.graph.cell_graph import CellGraph
from gm_ompl.graph.cell_keys import Keys
from gm_ompl.graph.cell_products import Product, Products
from gm_ompl.holds.cells import Cells
from gm_ompl.holds.rows import Tables, lower

ROUNDS: Final = 3
"""Times that the cells of a product are narrowed, each time by what is left of the others."""

MOST_WORK: Final = 20_000
"""Placements times legs times arcs up to which a cell is narrowed: it takes less than a margin."""

On: TypeAlias = tuple[int, int]
"""The first and the last leg on which a finger is at its placement."""


class LegWays(NamedTuple):
    """The ways that are open to a product.

    Attributes:
        legs: (m,), lanes.
        D: (m, V), see ``cell_bounds.to_go``.
        holds: (m - 1, V), whether the fingers that stay may hold the object between two legs.
        start: the start node.
        enough: plans that cost as much are of no use.
    """

    legs: IntArray
    D: Array
    holds: BoolArray
    start: int
    enough: float


@inlined
def factors_of(on: On, ways: LegWays, room: LaneRoom, tables: Tables) -> Array:
    """Return the least factors of Eq. (9) on some legs, (legs, K, P)."""
    first, last = on
    K, P = tables.states.shape
    factors = np.ones((last - first + 1, K, P))
    for m in range(first, last + 1):
        for k in range(K):
            for j in range(P):
                z = max(room.z[ways.legs[m], k, j], tables.z_floor)
                if tables.X_stab > 0.0:
                    factors[m - first, k, j] = 1.0 + tables.X_stab / z
    return factors


@compiled
def useful(
    finger: int, members: IntArray, on: On, ways: LegWays, room: LaneRoom, points: Tables,
    tables: Tables,
) -> BoolArray:  # fmt: skip
    """Return which placements (k,) of a finger's cell may be part of a plan that is of use.

    Args:
        finger: the finger.
        members: its cell's placements.
        on: where it is in the cell.
        ways: of the product.
        room: of the lanes.
        points: tables by placements.
        tables: by cells.
    """
    (first, last), (legs, D, holds, start, enough) = on, ways
    factors = factors_of(on, ways, room, tables)
    (K, P), V, end = tables.states.shape, D.shape[1], len(legs) - 1
    costs, d, after = np.empty(K), np.empty(V), np.empty(V)
    keep = np.zeros(len(members), dtype=np.bool_)
    for i in range(len(members)):
        p = members[i]
        for c in range(V if last < end else 0):
            after[c] = D[last + 1, c]
        for m in range(last, -1, -1):
            lane = legs[m]
            for c in range(V):
                if m == end:
                    d[c] = 0.0 if room.d[lane, c] <= 0.0 else np.inf
                else:
                    d[c] = tables.X_regr + after[c] if holds[m, c] else np.inf
                if m >= first and not points.node_free[finger, p, c]:
                    d[c] = np.inf
            for k in range(K):
                costs[k] = room.costs[lane, k]
                if m >= first:
                    row, travel = tables.like[k], 0.0
                    for j in range(P):
                        travel += factors[m - first, k, j] * points.lengths[finger, p, row, j]
                    free = points.free[finger, p, row]
                    costs[k] = max(costs[k], travel) if free else np.inf
            lower(d, costs, tables)
            for c in range(V):
                after[c] = d[c]
        keep[i] = d[start] < enough
    return keep


@final
class Narrowing:
    """Narrows the cells of products.

    Args:
        graph: the lanes of cells.
        cells: its cells.
        products: makes products.
        keys: bounds them.
    """

    def __init__(self, graph: CellGraph, cells: Cells, products: Products, keys: Keys) -> None:
        self._graph, self._cells, self._products, self._keys = graph, cells, products, keys

    def narrowed(self, product: Product, key: float, enough: float) -> tuple[float, Product]:
        """Return a product without what is in no plan that costs less than ``enough``.

        Args:
            product: the product whose key was asked last.
            key: that key.
            enough: what is good enough.

        Returns:
            Its key, +inf where nothing is left, and the product; the same one if it lost nothing.
        """
        for _ in range(ROUNDS):
            if key >= enough:
                break
            part = self._narrowed(product, enough)
            if part is product:
                break
            if part is None:
                return np.inf, product
            product, key = part, self._keys.key(part)
        return key, product

    def _narrowed(self, product: Product, enough: float) -> Product | None:
        """Narrow each cell once, by the others as they were; None where nothing is left."""
        graph, skeleton, narrow = self._graph, product.skeleton, dict[tuple[int, ...], int]()
        ways, cells = self._ways(product, enough), list(product.cells)
        for spot, cell in enumerate(product.cells):
            members, on = self._cells.members(cell), skeleton.stays(spot)
            work = len(members) * (1 + on[1]) * len(self._cells.tables.tail)
            if len(members) == 1 or work > MOST_WORK:
                continue
            finger = graph.likeness(skeleton.finger(spot))
            if (cell, finger, *on) not in narrow:  # interchangeable fingers lose the same
                keep = useful(
                    finger, members, on, ways, graph.lanes, self._cells.points, self._cells.tables
                )
                if not keep.any():
                    return None
                narrow[cell, finger, *on] = self._cells.of(members[keep])
            cells[spot] = narrow[cell, finger, *on]
        same = tuple(cells) == product.cells
        return product if same else self._products.made(skeleton, tuple(cells), product)

    def _ways(self, product: Product, enough: float) -> LegWays:
        """Return the ways that are open to a product whose key was asked last."""
        graph, tables, skeleton = self._graph, self._cells.tables, product.skeleton
        holds = graph.resting.z[product.rests] >= tables.z_min
        for m, leg in enumerate(skeleton.legs[1:]):
            for spot in leg:
                holds[m] &= tables.node_free[skeleton.finger(spot), product.cells[spot]]
        return LegWays(product.legs, self._keys.D, holds, graph.start, enough)
