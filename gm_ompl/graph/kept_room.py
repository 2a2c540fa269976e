"""Room for what the search for plans that keep the whole hand goes by."""

from __future__ import annotations

from typing import Any, Final, TypeVar, cast

import numpy as np

from gm_ompl.arrays import with_room
from gm_ompl.graph.kept_tables import EMPTY, FloorTable, KeptArcs, Poses, StateBook

ASKS: Final = 20_000
"""Margins asked for at once."""

NO_ROWS: Final = np.zeros(0, np.int64)

Columns = TypeVar("Columns", bound=tuple[np.ndarray[Any, Any], ...])


def no_floor(sets: int) -> FloorTable:
    """Return what says nothing of so many sets."""
    goal, none = np.zeros(2), (np.zeros((0, 3)), np.zeros((0, 2)), np.zeros((0, 0)))
    return FloorTable(np.full(sets, EMPTY), *none, goal, 0.0)


def no_arcs(F: int, P: int, parts: int) -> KeptArcs:
    """Return columns of arcs without rows, of F shapes of fingers and P placements."""
    free, states = np.zeros((0, F, P), dtype=bool), np.zeros((0, parts), np.int64)
    forms = np.zeros((0, 2, 3)), np.zeros((0, parts))
    return KeptArcs(NO_ROWS, NO_ROWS, NO_ROWS, *forms, NO_ROWS, free, states)


def new_book(room: int, slots: int) -> StateBook:
    """Return a book with room for so many states, and slots for margins."""
    hashed = 1 << int(2 * room - 1).bit_length()
    numbers, reals = np.zeros((4, room), dtype=np.int64), np.full((3, room), np.inf)
    return StateBook(
        np.full(hashed, EMPTY), numbers[0], numbers[1], reals[0], reals[1], reals[2],
        numbers[2], numbers[3], np.full(slots, EMPTY), np.zeros(slots),
        np.zeros((ASKS, 2), dtype=np.int64), np.zeros(3, dtype=np.int64),
    )  # fmt: skip


def columns_with_room(columns: Columns, count: int) -> Columns:
    """Return arrays with room for so many rows: themselves where there is."""
    if count <= len(columns[0]):
        return columns
    grown: list[Any] = [with_room(column, len(column), count) for column in columns]
    return cast(Columns, Poses._make(grown) if isinstance(columns, Poses) else tuple(grown))
