"""Lower bounds on the cost from every hub, any number of regrasps ahead.

One sweep bounds all arcs of all lanes by what is known, and then solves the shortest paths from
all hubs to the goal in that optimistic graph: from a hub to a placement, along that lane, to the
goal or to the next hub. It costs about as much as treating a few thousand lanes one by one, so it
is made when a search has proved to be that hard.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.feasibility.judge import Judge
from gm_ompl.graph.lane_bounds import SHORTER
from gm_ompl.holds.known import Known
from gm_ompl.holds.rows import Tables, lower, lower_once
from gm_ompl.holds.sets import LIFTED, Clearances, Groups, placement_sets
from gm_ompl.problem import Placements, Problem

MOST_HELD = 20_000_000
"""Hubs times nodes whose bounds are held, and lanes times nodes that a sweep may treat (it holds 24
bytes for each); beyond, geometry alone bounds the cost from hubs."""

HELD_BYTES, SWEPT_BYTES = 40.0, 32.0
"""What a hub's bound at a node takes while it is made, and a lane at a node in a sweep."""

MOST = 2**62
"""Codes of hubs are whole numbers up to here."""


@compiled
def lower_hubs(
    sets: IntArray, ids: IntArray, tables: Tables, costs: Array, d: Array, stable: BoolArray,
    V: Array,
) -> bool:  # fmt: skip
    """Lower V (hubs, V) by what each lane offers from its hubs; whether anything fell."""
    onward, fell = np.empty(d.shape[1]), False
    if tables.one_pass:
        return bool(_lower_once(sets, ids, tables, costs, d, (stable, V), onward))
    for i in range(len(sets)):
        _through_hubs(sets[i], ids[i], tables, d[i], V, onward)
        lower(onward, costs[i], tables)
        fell = _fallen(ids[i], onward, stable, V) or fell
    return fell


@lean
def _lower_once(
    sets: IntArray, ids: IntArray, tables: Tables, costs: Array, d: Array,
    hubs: tuple[BoolArray, Array], onward: Array,
) -> bool:  # fmt: skip
    """Do what ``lower_hubs`` does where one pass over the arcs is enough."""
    (stable, V), fell = hubs, False
    for i in range(len(sets)):
        _through_hubs(sets[i], ids[i], tables, d[i], V, onward)
        lower_once(onward, costs[i], tables)
        fell = _fallen(ids[i], onward, stable, V) or fell
    return fell


@inlined
def _through_hubs(
    rows: IntArray, hubs: IntArray, tables: Tables, d: Array, V: Array, onward: Array
) -> None:
    """Write what a lane's nodes cost (V,) where the way leads to the goal, or on to a hub."""
    node_free, X_regr = tables.node_free, tables.X_regr
    for c in range(len(onward)):
        onward[c] = np.inf
        for k in range(len(rows)):
            if V[hubs[k], c] < np.inf:
                onward[c] = min(onward[c], X_regr + V[hubs[k], c])
        for k in range(len(rows)):
            if not node_free[k, rows[k], c]:
                onward[c] = np.inf
        onward[c] = min(onward[c], d[c])


@inlined
def _fallen(hubs: IntArray, onward: Array, stable: BoolArray, V: Array) -> bool:
    """Lower the hubs of a lane; whether one fell."""
    fell = False
    for k in range(len(hubs)):
        for c in range(len(onward)):
            if stable[hubs[k], c] and onward[c] < V[hubs[k], c] * SHORTER:
                V[hubs[k], c] = onward[c]
                fell = True
    return fell


def hub_bounds(problem: Problem, judge: Judge, tables: Tables) -> HubBounds | None:
    """Return bounds of all hubs of a problem; None where there are too many to hold them."""
    hand, P = problem.fingers, len(problem.fingers.placements)
    most = MOST_HELD // len(tables.goal)
    hubs = hub_sets(hand.groups(), _anywhere(tables), judge.clear, most)
    if hubs is None or not any(len(sets) for _, sets in hubs) or (P + 1) ** hand.count > MOST:
        return None
    held = sum(len(sets) for _, sets in hubs) * len(tables.goal)
    if not limits.fits(HELD_BYTES * held):
        return None
    return HubBounds(hubs, hand.groups(), P, tables)


def swept_sets(problem: Problem, judge: Judge, tables: Tables) -> IntArray:
    """Return all sets (L, n); none where they are too many to sweep."""
    hand, most = problem.fingers, MOST_HELD // len(tables.goal)
    sets = placement_sets(hand.groups(), _anywhere(tables), judge.clear, most)
    if sets is None or not limits.fits(SWEPT_BYTES * len(sets) * len(tables.goal)):
        return np.empty((0, hand.count), dtype=np.int64)
    return sets


def _anywhere(tables: Tables) -> list[BoolArray]:
    """Return per finger the placements (P,) that are free at some node."""
    return [row.any(axis=1) for row in tables.node_free]


def hub_sets(
    groups: Groups, allowed: Sequence[BoolArray], clear: Clearances, most: int
) -> list[tuple[int, IntArray]] | None:
    """Return all hubs: per group the slot lifted there and the sets (H, n), 0 at that slot.

    Of interchangeable fingers the last one is lifted. None where there are more than ``most``.
    """
    hubs: list[tuple[int, IntArray]] = []
    for slot in (group[-1] for group in groups):
        stay = [i for i in range(len(allowed)) if i != slot]
        kept = (tuple(stay.index(i) for i in group if i != slot) for group in groups)
        rest = placement_sets(
            tuple(group for group in kept if group),
            [allowed[i] for i in stay],
            [[clear[i][j] for j in stay] for i in stay],
            most,
        )
        if rest is None:
            return None
        hubs.append((slot, np.insert(rest, slot, 0, axis=1)))
    return hubs if sum(len(sets) for _, sets in hubs) <= most else None


def _weights(groups: Groups, powers: IntArray) -> IntArray:
    """Return what a placement's number adds to the code of the hub without a slot, (n, n slots).

    ``powers`` (n,) are the places' weights. Within a group the others close up, and LIFTED, which
    adds nothing, comes last.
    """
    weights = np.zeros((len(powers), len(powers)), dtype=np.int64)
    for slot in range(len(powers)):
        for group in groups:
            others = [i for i in group if i != slot]
            weights[others, slot] = powers[list(group[: len(others)])]
    return weights


@final
class HubBounds:
    """The bounds of all hubs of a problem.

    Args:
        hubs: all of them, as ``hub_sets`` has them.
        groups: the groups of interchangeable fingers.
        placements: number of placements.
        lanes: the tables.

    Attributes:
        V: (hubs, V), the bounds; at first those of geometry.
    """

    def __init__(
        self,
        hubs: list[tuple[int, IntArray]],
        groups: Groups,
        placements: int,
        lanes: Tables,
    ) -> None:
        self._tables, self._base = lanes, placements + 1
        n = sum(map(len, groups))
        powers = self._base ** np.arange(n - 1, -1, -1)
        self._weights = _weights(groups, powers)
        codes, bounds = [], []
        for slot, sets in hubs:
            hub = sets + 1
            hub[:, slot] = 0
            codes.append(hub @ powers)
            bounds.append(self._geometric(slot, sets))
        every = np.concatenate(codes)
        order = np.argsort(every)
        self._codes = every[order]
        self.V: Array = np.ascontiguousarray(np.concatenate(bounds)[order])
        self._index = {code: i for i, code in enumerate(self._codes.tolist())}
        self._stable = np.ones(self.V.shape, dtype=bool)

    def _geometric(self, slot: int, sets: IntArray) -> Array:
        """Return V (H, V) as geometry alone bounds it, as ``hub_defaults`` does."""
        lanes = self._tables
        V = np.tile(lanes.least, (len(sets), 1))
        for i, ahead in enumerate(lanes.ahead):
            if i != slot:
                V = np.maximum(V, ahead[sets[:, i]])
        bounds: Array = np.minimum(V, lanes.X_regr + lanes.least)
        return bounds

    def ids(self, sets: IntArray) -> IntArray:
        """Return the hubs' rows in ``V`` for sets (L, n), as (L, n)."""
        rows = np.searchsorted(self._codes, (sets + 1) @ self._weights)
        # Of a set that is free nowhere, hubs are not known, and nobody asks for its bounds.
        return np.ascontiguousarray(np.minimum(rows, len(self._codes) - 1))

    def row(self, hub: Placements) -> Array:
        """Return the bounds (N + 1,) of a hub, given by its canonical placements."""
        bounds: Array = self.V[self._number(hub)]
        return bounds

    def _number(self, hub: Placements) -> int:
        code = 0
        for row in hub:
            code = code * self._base + (0 if row == LIFTED else row + 1)
        return self._index[code]

    def sweep(self, sets: IntArray, known: Known, lands: BoolArray) -> bool:
        """Renew all bounds; whether any rose.

        Args:
            sets: (L, n), all canonical sets.
            known: what was decided of them, and of hubs.
            lands: (n, placements, V), where a finger can be lifted or set down.
        """
        for hub, stable in known.all_rests():
            self._stable[self._number(hub)] &= stable != 0
        ids = self.ids(sets)
        costs, d = known.bounds(sets)
        V = np.full_like(self.V, np.inf)
        tables = self._tables._replace(node_free=lands)
        while lower_hubs(sets, ids, tables, costs, d, self._stable, V):
            limits.check()
        before, self.V = self.V, np.maximum(self.V, V)
        return bool(np.any(before < self.V))
