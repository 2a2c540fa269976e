"""What waits in the search over cells of placements."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import IntArray
from gm_ompl.graph.cell_graph import CellGraph, Tuple
from gm_ompl.graph.skeletons import Skeleton, skeletons
from gm_ompl.holds.sets import LIFTED
from gm_ompl.problem import Fingers

MOST_PRODUCTS: Final = 20_000
"""Products that plans of one more regrasp may begin with."""

MOST_REGRASPS: Final = 3
"""Regrasps up to which orders of them are listed."""


@dataclass(frozen=True, eq=False)
class Product:
    """Cells for the spots of a skeleton: all plans with their placements in them.

    Attributes:
        skeleton: the order of regrasps.
        cells: per spot.
        legs: (m,), the lanes.
        rests: (m - 1,), between them.
        depth: how often it was divided.
    """

    skeleton: Skeleton
    cells: Tuple
    legs: IntArray
    rests: IntArray
    depth: int

    @property
    def regrasps(self) -> int:
        """How many there are in its plans."""
        return len(self.skeleton.lifted)


@final
class Products:
    """Makes products.

    Args:
        hand: the hand.
        graph: numbers their lanes and rests.
    """

    def __init__(self, hand: Fingers, graph: CellGraph) -> None:
        self._hand, self._graph = hand, graph

    def begin(self, regrasps: int) -> list[Product] | None:
        """Return what plans of so many regrasps begin with; None where that is too much."""
        if regrasps > MOST_REGRASPS:
            return None
        found = list(skeletons(self._hand.groups(), regrasps))
        most = len(self._graph.cells.faces) ** (self._hand.count + regrasps)
        if len(found) * most > MOST_PRODUCTS:
            return None
        parts = (self.made(each, cells, None) for each in found for cells in self._roots(each))
        return [part for part in parts if part is not None]

    def _roots(self, skeleton: Skeleton) -> Iterator[Tuple]:
        """Yield the cells that plans of a skeleton begin with."""
        hand, cells = self._hand, self._graph.cells
        offered: list[tuple[int, ...]] = []
        for spot in range(skeleton.spots):
            finger, wanted = skeleton.finger(spot), set[int | None]()
            if spot < hand.count:
                wanted.add(hand.start[finger])
            if skeleton.is_last(spot):
                wanted.add(hand.goal[finger])
            given = [row for row in wanted if row is not None]
            if len(given) > 1:
                return
            offered.append((cells.point(given[0]),) if given else cells.faces)
        for chosen in itertools.product(*offered):
            pairs = (pair for alike in skeleton.alike for pair in itertools.pairwise(alike))
            if all(chosen[a] <= chosen[b] for a, b in pairs):
                yield chosen

    def divides(self, product: Product) -> bool:
        """Whether some cell of a product can be halved."""
        return any(self._graph.cells.width(cell) > 0.0 for cell in product.cells)

    def divided(self, product: Product) -> Iterator[Product]:
        """Yield what a product falls into with its widest cell halved."""
        cells, chosen = self._graph.cells, product.cells
        widest = max(range(len(chosen)), key=lambda spot: cells.width(chosen[spot]))
        groups = product.skeleton.alike
        alike = next((group for group in groups if widest in group), (widest,))
        spots = [spot for spot in alike if chosen[spot] == chosen[widest]]
        halves = cells.halves(chosen[widest])
        for picked in itertools.combinations_with_replacement(halves, len(spots)):
            replaced = list(chosen)
            for spot, half in zip(spots, picked, strict=True):
                replaced[spot] = half
            part = self.made(product.skeleton, tuple(replaced), product)
            if part is not None:
                yield part

    def made(self, skeleton: Skeleton, cells: Tuple, whole: Product | None) -> Product | None:
        """Return a product, or None where fingertips must penetrate each other, or what is there.

        Args:
            skeleton: the order of regrasps.
            cells: per spot.
            whole: what it is a part of, if anything.
        """
        limits.check()
        graph = self._graph
        sets = [tuple(cells[spot] for spot in leg) for leg in skeleton.legs]
        free = graph.cells.tables.node_free
        if not all(free[i, cell, graph.start] for i, cell in enumerate(sets[0])):
            return None
        if not all(graph.apart(each) for each in sets):
            return None
        legs, rests = np.empty(len(sets), np.int64), np.empty(len(skeleton.lifted), np.int64)
        for m, each in enumerate(sets):
            legs[m] = graph.lane(each, None if whole is None else int(whole.legs[m]))
        for m, finger in enumerate(skeleton.lifted):
            held = (*sets[m][:finger], LIFTED, *sets[m][finger + 1 :])
            rests[m] = graph.rest(held, None if whole is None else int(whole.rests[m]))
        return Product(skeleton, cells, legs, rests, 0 if whole is None else whole.depth + 1)
