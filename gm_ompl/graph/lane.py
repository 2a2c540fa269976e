"""What is known of one lane, and of one hub."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.arrays import BoolArray
from gm_ompl.graph.sets import LIFTED
from gm_ompl.problem import Placements

BLOCKED = -1.0
"""Stands for a margin that is known to fail."""


@final
class Lane:
    """One set of placements along the whole path.

    Attributes:
        placements: canonical.
        hubs: per slot, the hub where it is lifted.
        rows: (n,), the placements.
        known: (2, N, P), decided margins forward and backward; +inf undecided, BLOCKED failed.
        z: (2, N, P), upper bounds on the margins.
        costs: (2, N), lower bounds on Eq. (9).
        d: (N + 1,), lower bounds on the cost to the goal inside the lane.
        version: of the cuts when the bounds were last renewed.
    """

    def __init__(
        self, placements: Placements, hubs: tuple[Placements, ...], N: int, P: int
    ) -> None:
        self.placements, self.hubs = placements, hubs
        self.rows = np.array(placements, dtype=np.int64)
        self.known = np.full((2, N, P), np.inf)
        self.z = np.full((2, N, P), np.inf)
        self.costs, self.d = np.empty((2, N)), np.empty(N + 1)
        self.version = -1


@final
class Hub:
    """One finger lifted, the others in place, at any node.

    Attributes:
        placements: canonical, with LIFTED.
        slot: who is lifted.
        rows: (n,), 0 at ``slot``.
        choices: where the lifted finger may go, clear of the others.
        number: (placements,), each choice's number; -1 elsewhere.
        table: (choices, N + 1), lower bounds on the cost to the goal per choice and node.
        versions: (choices,), of the cuts when a choice's row was last renewed; -2 where the lane
            itself must be asked.
        stable: (N + 1,), whether the rest holds the object: 1, 0, or -1 where undecided.
        value: (N + 1,), lower bounds on the cost from the hub.
        reached: (N + 1,), least cost at which it was reached.
    """

    def __init__(self, placements: Placements, fits: BoolArray, nodes: int) -> None:
        self.placements = placements
        self.slot = placements.index(LIFTED)
        self.rows = np.array(placements, dtype=np.int64)
        self.rows[self.slot] = 0
        self.choices = np.flatnonzero(fits)
        self.number = np.where(fits, np.cumsum(fits) - 1, -1)
        self.table = np.empty((len(self.choices), nodes))
        self.versions = np.full(len(self.choices), -1, dtype=np.int64)
        self.stable = np.full(nodes, -1, dtype=np.int64)
        self.value = np.empty(nodes)
        self.reached = np.full(nodes, np.inf)
