"""The contact states that mode decisions were asked for, numbered, and their columns."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias, TypeVar, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.state import ContactState
from gm_ompl.feasibility.arc_states import ArcStates
from gm_ompl.feasibility.keys import contact_key
from gm_ompl.mechanics import columns
from gm_ompl.motion.arc import Arc
from gm_ompl.problem import Problem


class Columns(NamedTuple):
    """What acts at contact states, one behind the other, forces over the unit of force.

    Attributes:
        env: (e, 6), the environment's columns.
        first: (K + 1,), where each state's begin.
        loads: (K, 6).
    """

    env: Array
    first: IntArray
    loads: Array


Told: TypeAlias = Callable[[ContactState], object] | None
"""Who is told of a new contact state."""


@final
class KnownStates:
    """Numbers contact states; equal ones get the same number.

    Args:
        problem: the problem.
        U: (6, 6), of the norm (7).
        weight: the object's, over the unit of force.

    Attributes:
        contacts: the states by their numbers, as they were first registered.
    """

    def __init__(self, problem: Problem, U: Array, weight: float) -> None:
        self._problem, self._U, self._weight = problem, U, weight
        self._along = ArcStates(problem)
        self._numbers: dict[bytes, int] = {}
        self.contacts: list[ContactState] = []
        self._columns = Columns(np.empty((256, 6)), np.zeros(257, np.int64), np.empty((256, 6)))

    def number(self, contacts: ContactState, told: Told) -> int:
        """Return a contact state's number."""
        key = contact_key(contacts, self._problem.body.diagonal)
        known = self._numbers.get(key)
        return self._register(key, contacts, told) if known is None else known

    def along(self, arc: Arc, parts: int, told: Told) -> list[int] | None:
        """Return the numbers of the states in the middles of an arc's segments.

        None where ``ArcStates`` does not find them.
        """
        found, numbers = self._along.along(arc, parts), list[int]()
        if found is None:
            return None
        for k, key in enumerate(found):
            known = self._numbers.get(key)
            if known is None:
                known = self._register(key, self._along.state(k), told)
            numbers.append(known)
        return numbers

    def _register(self, key: bytes, contacts: ContactState, told: Told) -> int:
        number = self._numbers[key] = len(self.contacts)
        self.contacts.append(contacts)
        settings, mu = self._problem.mechanics, self._problem.environment.friction
        own = columns.environment_columns(contacts, mu, settings.cone_edges, self._U)
        old, start = self._columns, int(self._columns.first[number])
        end = start + len(own)
        self._columns = Columns(
            with_room(old.env, start, end),
            with_room(old.first, number + 1, number + 2),
            with_room(old.loads, number, number + 1),
        )
        self._columns.env[start:end], self._columns.first[number + 1] = own, end
        self._columns.loads[number] = columns.load(contacts.rotation, self._weight, self._U)
        if told is not None:
            told(contacts)
        return number

    def columns(self) -> Columns:
        """Return what acts at all states so far."""
        K, found = len(self.contacts), self._columns
        return Columns(found.env[: found.first[K]], found.first[: K + 1], found.loads[:K])

    def at(self, number: int) -> tuple[Array, Array]:
        """Return what acts at a state: the environment's columns (e, 6) and the load (6,)."""
        found = self._columns
        return found.env[found.first[number] : found.first[number + 1]], found.loads[number]


Rows = TypeVar("Rows", Array, IntArray)


def with_room(rows: Rows, count: int, wanted: int) -> Rows:
    """Return rows with room for as many as wanted: themselves, or the first of them in new ones."""
    if wanted <= len(rows):
        return rows
    grown = np.empty((max(2 * len(rows), wanted), *rows.shape[1:]), rows.dtype)
    grown[:count] = rows[:count]
    return grown
