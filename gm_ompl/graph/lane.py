"""What is known of one lane, and of one hub."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.holds.rows import Tables
from gm_ompl.holds.sets import LIFTED, staying_of
from gm_ompl.problem import Placements

FEW: Final = 6
"""Segments decided by z_strong, before a lane must still prove to be the cheapest."""


@final
class Lane:
    """One set of placements along all arcs.

    Attributes:
        placements: canonical.
        hubs: per slot, the hub where it is lifted.
        rows: (n,), the placements.
        known: (K, P), decided margins, as ``Known.margins`` has them.
        z: (K, P), upper bounds on the margins.
        costs: (K,), lower bounds on Eq. (9) by kind of arc.
        d: (V,), lower bounds on the cost to the goal inside the lane.
        version: of the cuts when the bounds were last renewed.
        shut: (n, V), where lifting the finger at a slot leads nowhere: -inf where it cannot get
            away; a cost where it was lifted in a pocket at that cost. None: nowhere that is known.
        closed: goal nodes at which the hand cannot leave.
    """

    def __init__(
        self, placements: Placements, hubs: tuple[Placements, ...], known: Array, nodes: int
    ) -> None:
        self.placements, self.hubs, self.known = placements, hubs, known
        self.rows = np.array(placements, dtype=np.int64)
        self.z = np.full(known.shape, np.inf)
        self.costs, self.d = np.empty(len(known)), np.empty(nodes)
        self.version = -1
        self.shut: Array | None = None
        self.closed: set[int] = set()

    def tables(self, tables: Tables) -> Tables:
        """Return the tables without the goal nodes at which the hand cannot leave."""
        if not self.closed:
            return tables
        goal = tables.goal.copy()
        goal[list(self.closed)] = False
        return tables._replace(goal=goal)

    def bar(self, slot: int, node: int, cost: float) -> None:
        """Take note that lifting the finger at ``slot`` at this cost leads nowhere new."""
        if self.shut is None:
            self.shut = np.full((len(self.rows), len(self.d)), np.inf)
        self.shut[slot, node] = min(self.shut[slot, node], cost)


@final
class Hub:
    """One finger lifted, the others in place, at any node.

    Attributes:
        placements: canonical, with LIFTED.
        slot: who is lifted.
        staying: the fingers that touch, and the row of each.
        rows: (n,), 0 at ``slot``.
        choices: where the lifted finger may go, clear of the others.
        number: (placements,), each choice's number; -1 elsewhere.
        table: (choices, V), lower bounds on the cost to the goal per choice and node.
        versions: (choices,), of the cuts when a choice's row was last renewed; -2 where the lane
            itself must be asked.
        stable: (V,), whether the rest holds the object, as ``Known.rests`` has it.
        value: (V,), lower bounds on the cost from the hub.
        reached: (V,), least cost at which it was reached from outside pockets.
        doubtful: per node where it was reached, the rows (P,) that may be in pockets; without
            nodes that have none.
    """

    def __init__(self, placements: Placements, fits: BoolArray, stable: IntArray) -> None:
        self.placements, self.stable = placements, stable
        self.slot, self.staying = placements.index(LIFTED), staying_of(placements)
        self.rows = np.array(placements, dtype=np.int64)
        self.rows[self.slot] = 0
        self.choices = np.flatnonzero(fits)
        self.number = np.where(fits, np.cumsum(fits) - 1, -1)
        self.table = np.empty((len(self.choices), len(stable)))
        self.versions = np.full(len(self.choices), -1, dtype=np.int64)
        self.value = np.empty(len(stable))
        self.reached = np.full(len(stable), np.inf)
        self.doubtful: dict[int, BoolArray] = {}

    def bounded_by(self, ahead: Array) -> None:
        """Bound the costs by each finger's own travel to the goal, (n, placements, V)."""
        self.table[:] = ahead[self.slot, self.choices]
        for k, row in enumerate(self.placements):
            if row != LIFTED:
                np.maximum(self.table, ahead[k, row], out=self.table)

    def ask(self, placements: Placements) -> None:
        """Have the lane of a set asked itself, which knows more than the cuts."""
        left = list(placements)
        for row in self.placements:
            if row != LIFTED:
                left.remove(row)
        self.versions[self.number[left[0]]] = -2
