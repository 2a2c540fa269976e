"""States that were met, and margins, as compiled code keeps and finds them: by hashing."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled, inlined, lean
from gm_ompl.graph.kept_tables import ASKED, ASKS_APART, EMPTY, STATES, StateBook


@inlined
def _home(key: int, slots: int) -> int:
    mixed = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
    return int(np.int64((mixed ^ (mixed >> np.uint64(32))) & np.uint64(slots - 1)))


@lean
def find(book: StateBook, pose: int, hand: int) -> int:
    """Return the slot of a state, or the empty one where it would be."""
    slot = _home(pose * 0x1000003 + hand, len(book.slots))
    while book.slots[slot] != EMPTY:
        number = book.slots[slot]
        if book.pose[number] == pose and book.hand[number] == hand:
            break
        slot = (slot + 1) & (len(book.slots) - 1)
    return int(slot)


@lean
def margin_slot(asks: IntArray, ask: int) -> int:
    """Return the slot of a margin, or the empty one where it would be."""
    slot = _home(ask, len(asks))
    while asks[slot] != EMPTY and asks[slot] != ask:
        slot = (slot + 1) & (len(asks) - 1)
    return int(slot)


@compiled
def rehash(book: StateBook, old_asks: IntArray, old_margins: Array) -> None:
    """Fill the slots of a book that has grown."""
    for number in range(book.counts[STATES]):
        book.slots[find(book, book.pose[number], book.hand[number])] = number
    for k in range(len(old_asks)):
        if old_asks[k] != EMPTY:
            slot = margin_slot(book.asks, old_asks[k])
            book.asks[slot], book.margins[slot] = old_asks[k], old_margins[k]


@compiled
def learn(book: StateBook, zs: Array) -> None:
    """Write the margins of what was asked for."""
    for k in range(book.counts[ASKED]):
        slot = margin_slot(book.asks, book.new[k, 0] * ASKS_APART + book.new[k, 1])
        book.margins[slot] = zs[k]
    book.counts[ASKED] = 0


@lean
def meet(pose: int, hand: int, bound: float, book: StateBook) -> int:
    """Return the number of a state; a new one, of that bound, costs +inf and is not open."""
    slot = find(book, pose, hand)
    if book.slots[slot] == EMPTY:
        number = book.counts[STATES]
        book.counts[STATES] += 1
        book.slots[slot], book.pose[number], book.hand[number] = number, pose, hand
        book.cost[number] = book.key[number] = np.inf
        book.bound[number] = bound
    return int(book.slots[slot])


@lean
def put(book: StateBook, number: int, cost: float, parent: int, via: int) -> None:
    """Write a state's cost, parent and arc; it is open."""
    book.cost[number], book.parent[number], book.via[number] = cost, parent, via
    book.key[number] = cost + book.bound[number]


@inlined
def margin(state: int, hand: int, book: StateBook) -> float:
    """Return a margin; NaN where it is not known, and it is asked for."""
    ask = state * ASKS_APART + hand
    slot = margin_slot(book.asks, ask)
    if book.asks[slot] != EMPTY:
        return float(book.margins[slot])
    row = book.counts[ASKED]
    if row < len(book.new):
        book.asks[slot], book.margins[slot] = ask, np.nan
        book.new[row, 0], book.new[row, 1] = state, hand
        book.counts[ASKED] += 1
    return np.nan
