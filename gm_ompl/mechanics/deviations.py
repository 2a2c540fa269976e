"""How contacts may give way while the object deviates, and whether some deviation goes with it.

A contact is open, sticks, or slides on a corner or along a side of its cone's polygon; Coulomb's
law lets those edges press on which friction dissipates most. Twists are R^(-T/2) times the
object's, so that products with the columns of ``mechanics.columns`` are powers.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.compilation import compiled
from gm_ompl.mechanics.tableau import FEASIBLE, feasible

CANCELS: Final = 1e-9
"""What is left of rows of unit length when they depend on each other."""

UNTOLD, CLOSED, OPEN, STICKS, CORNER = -2, -1, 0, 1, 2
"""Ways in which a contact behaves: not said; not open; open; sticks, or slides on as it did before;
slides with corner ``way - CORNER`` of the cone's polygon pressing; and, s more, with the side that
begins there pressing."""


class ContactRows(NamedTuple):
    """All contacts of an instant, fingertips first.

    Attributes:
        columns: (C, 6), wrenches of the edges, for unit normal force.
        first: (c + 1,), where each contact's columns begin.
        normal: (c, 6), wrench of unit normal force without friction.
        one_sided: (c,), whether the object cannot move into it: all but force-controlled fingers,
            which follow along the normal.
        plain: (c,), whether it has one way to slide: it slides already, or has no friction.
    """

    columns: Array
    first: IntArray
    normal: Array
    one_sided: BoolArray
    plain: BoolArray


@compiled
def last_way(contacts: ContactRows, i: int) -> int:
    """Return the last of a contact's ways."""
    s = contacts.first[i + 1] - contacts.first[i]
    return STICKS if contacts.plain[i] else CORNER + 2 * s - 1


@compiled
def presses(contacts: ContactRows, i: int, way: int, pressing: BoolArray) -> None:
    """Write which of a contact's columns may press, into ``pressing`` (C,)."""
    begin, end = contacts.first[i], contacts.first[i + 1]
    s = end - begin
    for j in range(begin, end):
        pressing[j] = way in (STICKS, CLOSED)
    if way >= CORNER:
        j = (way - CORNER) % s
        pressing[begin + j] = True
        if way >= CORNER + s:
            pressing[begin + (j + 1) % s] = True


@compiled
def _rows(
    contacts: ContactRows, i: int, way: int, least: Array, a: int, zero: Array, b: int
) -> tuple[int, int]:
    """Append what a way asks of the twist; return the numbers of rows then."""
    normal, begin = contacts.normal[i], contacts.first[i]
    s = contacts.first[i + 1] - begin
    if way in (OPEN, UNTOLD):
        if contacts.one_sided[i]:
            least[a] = normal
            a += 1
        return a, b
    if contacts.one_sided[i]:
        zero[b] = normal
        b += 1
    if contacts.plain[i] or way == CLOSED:
        return a, b
    edges = contacts.columns
    if way == STICKS:  # two sides of the polygon, or corners, span its plane
        zero[b], zero[b + 1] = edges[begin] - normal, edges[begin + 1] - normal
        return a, b + 2
    j = (way - CORNER) % s
    here, following, before = begin + j, begin + (j + 1) % s, begin + (j + s - 1) % s
    if way < CORNER + s:  # of a convex polygon, neighbours tell which corner is least
        least[a], least[a + 1] = edges[following] - edges[here], edges[before] - edges[here]
        return a + 2, b
    zero[b], least[a] = edges[following] - edges[here], edges[before] - edges[here]
    return a + 1, b + 1


@compiled
def _orthonormal(rows: Array, count: int, basis: Array, rank: int) -> int:
    """Extend an orthonormal basis of ``rank`` rows by the span of rows (count, 6), overwritten.

    What is left of the longest row comes next, so that dependent ones are told from rounding.
    """
    for k in range(count):
        size = np.sqrt((rows[k] * rows[k]).sum())
        if size > 0.0:
            rows[k] /= size
        for r in range(rank):
            rows[k] -= (rows[k] * basis[r]).sum() * basis[r]
    while rank < 6:
        longest, chosen = CANCELS * CANCELS, -1
        for k in range(count):
            square = (rows[k] * rows[k]).sum()
            if square > longest:
                longest, chosen = square, k
        if chosen < 0:
            return rank
        basis[rank] = rows[chosen] / np.sqrt(longest)
        for r in range(rank):  # once more: what rounding left
            basis[rank] -= (basis[rank] * basis[r]).sum() * basis[r]
        basis[rank] /= np.sqrt((basis[rank] * basis[rank]).sum())
        for k in range(count):
            rows[k] -= (rows[k] * basis[rank]).sum() * basis[rank]
        rank += 1
    return rank


@compiled
def deviates(contacts: ContactRows, ways: IntArray) -> bool:
    """Whether some twist other than 0 goes with ways (c,); contacts not said part or stay.

    By Stiemke's theorem none does exactly where the rows that must vanish and those that must not
    be negative have rank 6, and the latter, each taken some positive number of times, cancel but
    for the former.
    """
    c = len(ways)
    least, zero, a, b = np.empty((2 * c + 6, 6)), np.empty((3 * c, 6)), 0, 0
    for i in range(c):
        a, b = _rows(contacts, i, ways[i], least, a, zero, b)
    basis = np.empty((6, 6))
    rank = _orthonormal(zero, b, basis, 0)
    if rank == 6:
        return False
    kept = 0
    for k in range(a):
        size = np.sqrt((least[k] * least[k]).sum())
        row = least[k] / size if size > 0.0 else least[k]
        for r in range(rank):
            row = row - (row * basis[r]).sum() * basis[r]
        size = np.sqrt((row * row).sum())
        if size > CANCELS:
            least[kept] = row / size
            kept += 1
    if _orthonormal(least[:kept].copy(), kept, basis, rank) < 6:
        return True
    # In coordinates of what is left: a short rest, made long, would carry rounding beyond it.
    left = np.zeros((kept, 6))
    for k in range(kept):
        for r in range(rank, 6):
            left[k, r - rank] = (least[k] * basis[r]).sum()
    return not _cancel(left, kept)


@compiled
def _cancel(rows: Array, count: int) -> bool:
    """Whether rows (count, 6), each taken at least once, cancel."""
    N, W = count, count + 6
    T, d, basis, b = np.zeros((6, W)), np.zeros(W), np.empty(6, dtype=np.int64), np.zeros(6)
    for t in range(6):
        basis[t], T[t, N + t] = N + t, 1.0
        for k in range(count):
            T[t, k] = rows[k, t]
            b[t] -= rows[k, t]
    return feasible(T, d, basis, b, FEASIBLE, np.empty(6), np.empty(6)) == 1
