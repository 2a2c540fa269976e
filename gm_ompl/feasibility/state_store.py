"""Contact states by their numbers, and what acts at them."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from gm_ompl.arrays import Array, IntArray, with_room
from gm_ompl.contact.state import ContactState
from gm_ompl.mechanics import columns
from gm_ompl.mechanics.state_columns import (
    Columns,
    Cones,
    StateRows,
    count_columns,
    write_columns,
)
from gm_ompl.problem import Problem

if TYPE_CHECKING:
    from gm_ompl.feasibility.course_states import StatesFound

FIRST = 256
"""Rows there is room for at first."""


@final
class StateStore:
    """Keeps contact states and their columns.

    Args:
        problem: the problem.
        U: (6, 6), of the norm (7).
        weight: the object's, over the unit of force.
    """

    def __init__(self, problem: Problem, U: Array, weight: float) -> None:
        friction, s = problem.environment.friction, problem.mechanics.cone_edges
        self._cones = Cones(columns.edge_weights(friction, s).copy(), friction, U.copy(), weight)
        self._told: dict[int, ContactState] = {}
        self._count, starts = 0, np.zeros(FIRST + 1, dtype=np.int64)
        points, normals, slip = np.empty((3, FIRST, 3))
        surfaces, R = np.empty(FIRST, dtype=np.int64), np.empty((FIRST, 3, 3))
        self._rows = StateRows(points, normals, slip, surfaces, R, starts)
        self._columns = Columns(np.empty((FIRST, 6)), starts.copy(), np.empty((FIRST, 6)))

    def __len__(self) -> int:
        """Return how many there are."""
        return self._count

    def add(self, contacts: ContactState) -> None:
        """Keep the next contact state."""
        k, cones = self._count, self._cones
        own = columns.environment_columns(contacts, cones.friction, len(cones.edges), cones.U)
        self._make_room(1, 0)
        self._rows.first[k + 1] = self._rows.first[k]
        self._columns.first[k + 1] = self._columns.first[k] + len(own)
        self._columns.loads[k] = columns.load(contacts.rotation, cones.weight, cones.U)
        self._new_columns(1)[:] = own
        self._told[k] = contacts  # last: Ctrl-C may come before, and the number be another state's

    def add_some(self, found: StatesFound, which: IntArray) -> None:
        """Keep some of the states found as the next ones, by compiled code."""
        k, new, sheet, room = self._count, len(which), found.room.at, found.room
        starts, ends = np.concatenate([[0], room.past[:, 0]])[which], room.past[which, 0]
        past = np.cumsum(ends - starts)
        contacts = np.arange(past[-1]) + np.repeat(ends - past, ends - starts)
        self._make_room(new, len(contacts))
        rows, first = self._rows, int(self._rows.first[k])
        own = slice(first, first + len(contacts))
        rows.points[own], rows.normals[own] = sheet.points[contacts], sheet.normals[contacts]
        rows.slip[own], rows.surfaces[own] = room.slip[contacts], sheet.surfaces[contacts]
        rows.rotations[k : k + new] = room.rotations[which]
        rows.first[k + 1 : k + new + 1] = first + past
        count_columns(rows, k + new, self._cones, self._columns, k)
        self._new_columns(new)
        write_columns(rows, k + new, self._cones, self._columns, k)

    def _make_room(self, states: int, contacts: int) -> None:
        """Make room for more states, of so many contacts."""
        K, rows, old = self._count, self._rows, self._columns
        c, past = int(rows.first[K]), K + states
        points, normals, slip, surfaces, R, first = rows
        self._rows = StateRows(
            with_room(points, c, c + contacts), with_room(normals, c, c + contacts),
            with_room(slip, c, c + contacts), with_room(surfaces, c, c + contacts),
            with_room(R, K, past), with_room(first, K + 1, past + 1),
        )  # fmt: skip
        first, loads = with_room(old.first, K + 1, past + 1), with_room(old.loads, K, past)
        self._columns = Columns(old.env, first, loads)

    def _new_columns(self, states: int) -> Array:
        """Return room for the columns of the next states, which were counted."""
        first, K = self._columns.first, self._count
        start, self._count = int(first[K]), K + states
        env = with_room(self._columns.env, start, int(first[self._count]))
        self._columns = self._columns._replace(env=env)
        return env[start : first[self._count]]

    def contacts(self, number: int) -> ContactState:
        """Return the state of a number, as it was first registered."""
        known = self._told.get(number)
        if known is None:
            rows = self._rows
            own = slice(rows.first[number], rows.first[number + 1])
            sheet = rows.points[own], rows.normals[own], rows.slip[own]
            known = ContactState(*sheet, rows.rotations[number], rows.surfaces[own].copy())
            self._told[number] = known
        return known

    def columns(self) -> Columns:
        """Return what acts at all states so far."""
        K, found = self._count, self._columns
        return Columns(found.env[: found.first[K]], found.first[: K + 1], found.loads[:K])

    def at(self, number: int) -> tuple[Array, Array]:
        """Return what acts at a state: the environment's columns (e, 6) and the load (6,)."""
        found = self._columns
        return found.env[found.first[number] : found.first[number + 1]], found.loads[number]
