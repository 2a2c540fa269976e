"""Room for what the search for plans that keep the whole hand goes by."""

from __future__ import annotations

from typing import Any, Final, TypeVar, cast

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import with_room
from gm_ompl.graph.kept_book import rehash
from gm_ompl.graph.kept_tables import (
    EMPTY,
    STATES,
    FloorTable,
    KeptArcs,
    Poses,
    Relaxed,
    StateBook,
)

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


def no_relaxed(sets: int) -> Relaxed:
    """Return what says nothing of so many sets."""
    return Relaxed(np.full(sets, EMPTY), np.zeros(sets), new_book(1, 1, 0), np.zeros(0), np.inf)


def new_book(room: int, slots: int, asks: int) -> StateBook:
    """Return a book with room for so many states, slots for margins, and room to ask for them."""
    hashed = 1 << int(2 * room - 1).bit_length()
    numbers, reals = np.zeros((4, room), dtype=np.int64), np.full((3, room), np.inf)
    return StateBook(
        np.full(hashed, EMPTY), numbers[0], numbers[1], reals[0], reals[1], reals[2],
        numbers[2], numbers[3], np.full(slots, EMPTY), np.zeros(slots),
        np.zeros((asks, 2), dtype=np.int64), np.zeros(3, dtype=np.int64),
    )  # fmt: skip


def columns_with_room(columns: Columns, count: int) -> Columns:
    """Return arrays with room for so many rows: themselves where there is."""
    if count <= len(columns[0]):
        return columns
    grown: list[Any] = [with_room(column, len(column), count) for column in columns]
    return cast(Columns, Poses._make(grown) if isinstance(columns, Poses) else tuple(grown))


def book_with_room(book: StateBook, coming: int) -> StateBook | None:
    """Return a book with room for more states, and for the margins that are asked for.

    That is the book itself, or another; None where memory does not do.
    """
    states, asked = int(book.counts[STATES]), int((book.asks != EMPTY).sum())
    room, slots = len(book.cost), len(book.asks)
    least = 2 * (asked + len(book.new))
    if states + coming <= room and least <= slots:
        return book
    room = room if states + coming <= room else 2 * (states + coming)
    while least > slots:
        slots *= 2
    if not limits.fits(80.0 * room + 16.0 * slots):
        return None
    grown = new_book(room, slots, 0)._replace(new=book.new)  # what is asked for stays so
    for name in ("pose", "hand", "cost", "bound", "key", "parent", "via"):
        getattr(grown, name)[:states] = getattr(book, name)[:states]
    grown.counts[:] = book.counts
    rehash(grown, book.asks, book.margins)
    return grown
