"""States of the object with fingertips in place, made on demand: what searches over them share."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.kept_arcs import KeptObject
from gm_ompl.graph.kept_book import learn
from gm_ompl.graph.kept_room import book_with_room
from gm_ompl.graph.kept_states import expand
from gm_ompl.graph.kept_tables import ASKED, EMPTY, FAILED, STATES, KeptTables
from gm_ompl.holds.extraction import Leg
from gm_ompl.holds.sets import LIFTED
from gm_ompl.problem import Placements


class StateGraph(ABC):
    """States, their costs and keys.

    Args:
        judge: of a problem of free motion; its back end is the kernel's.
        own: the object's poses and arcs.
        tables: what compiled code goes by.

    Attributes:
        object: the object's poses and arcs.
        tables: what compiled code goes by; others once they have grown.
        full: whether nothing more can be told: memory does not do.
        paid: what all plans pay for regrasps.
        doubt: of plans that cost as much, or more, nothing can be told.
        slack: the limit on bounds is ahead of the least one by this at least, and at most, relative
            to what is to travel.
    """

    paid, doubt, slack = 0.0, np.inf, (0.005, 0.05)

    def __init__(self, judge: Judge, own: KeptObject, tables: KeptTables) -> None:
        self._judge, self.object, self.tables, self.full = judge, own, tables, False

    @property
    def open(self) -> IntArray:
        """The states that are open."""
        book = self.tables.book
        return np.flatnonzero(book.key[: book.counts[STATES]] < np.inf)

    def placements(self, hand: int) -> Placements:
        """Return a set of placements."""
        return tuple(self.tables.hands.rows[hand].tolist())

    def reach(self, limit: float) -> bool:
        """See that bounds tell of plans up to ``limit``; whether they rose, or there is no room.

        Raises:
            LimitError: a limit in force is reached.
        """
        del limit
        return False

    @abstractmethod
    def follow(self, which: IntArray, limit: float) -> None:
        """Follow what leads on from states, up to plans of a bound of at most ``limit``.

        What is asked for is found, too.

        Raises:
            LimitError: a limit in force is reached.
        """

    @abstractmethod
    def arrived(self) -> IntArray:
        """Return the states that plans may end with."""

    @abstractmethod
    def stands(self, number: int) -> bool:
        """Whether fingers get through the air where the way to a state asks for it."""

    @abstractmethod
    def legs(self, number: int) -> tuple[list[int], list[Leg]]:
        """Return the nodes on the way to a state, and the sets of placements on it."""

    def way(self, number: int) -> list[int]:
        """Return the states on the way to one."""
        states = list[int]()
        while number != EMPTY:
            states.append(number)
            number = int(self.tables.book.parent[number])
        return states[::-1]

    def _has_room(self, coming: int) -> bool:
        """Whether there is room for more states, and for the margins that are asked for."""
        book = book_with_room(self.tables.book, coming)
        self.full |= book is None
        if book is not None:
            self.tables = self.tables._replace(book=book)
        return not self.full

    def _expand(self, which: IntArray, limit: float) -> None:
        """Follow the arcs from states."""
        of = self.tables.book.pose[which]
        self.object.prepare(of)
        self._take_in()
        poses, n = self.tables.poses, self.tables.hands.rows.shape[1]
        most = int((poses.past[of] - poses.first[of]).max(initial=0)) + n
        while len(which) and self._has_room(most):
            which = which[expand(which, limit, self.tables) :]

    def _take_in(self) -> None:
        """Go by what the object has become."""
        own = self.object
        self.tables = self.tables._replace(poses=own.poses, bodies=own.bodies, arcs=own.arcs)

    def _decide(self) -> None:
        """Decide the margins that were asked for."""
        book, backend = self.tables.book, self._judge.backend
        assert isinstance(backend, KernelBackend)
        new, z_min = book.new[: book.counts[ASKED]].copy(), self._judge.problem.mechanics.z_min
        rows = self.tables.hands.rows[new[:, 1]]
        lifted, zs = (rows == LIFTED).any(axis=1), np.zeros(len(new))
        if not lifted.all():
            some = ~lifted
            zs[some] = backend.margins(new[some, 0], rows[some], z_min)
        for k in np.flatnonzero(lifted).tolist():
            fingers = np.flatnonzero(rows[k] != LIFTED)
            held = tuple(fingers.tolist()), tuple(rows[k, fingers].tolist())
            zs[k] = backend.decide(int(new[k, 0]), *held, z_min).z
        if len(new):
            learn(book, np.where(zs >= z_min, zs, FAILED))
