"""Nodes of the contact lattice, numbered as they are found: compiled.

A node is a pose, and the line of the rotation under way there, where one is.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray, with_room
from gm_ompl.compilation import compiled
from gm_ompl.contact.departures import Departures, Tails, Terrain, in_reach
from gm_ompl.contact.offers import begins, find, may_begin, stand
from gm_ompl.contact.poses import Book, number
from gm_ompl.contact.touching import NO_ROOM, Sheet, touched

NONE: Final = -1
"""No node, no arc; of a pose, not known whether rotations begin there."""

FIRST: Final = 256
"""Nodes and poses there is room for at first."""


class NodeBook(NamedTuple):
    """Nodes.

    Attributes:
        places: (room,), the number of each one's pose.
        turning: (room,), 1 where a rotation is under way, else 0.
        lines: (room, 2, 3), its line, a point and a unit direction, world frame.
        next: (room,), another node at the same pose with a rotation under way; NONE: the last.
        first: (room,), the first arc that leaves it; NONE where they are not known.
        past: (room,), the arc behind its last.
        resting: (poses,), the node at a pose where none is under way.
        rotating: (poses,), the first node where one is.
        begins: (poses,), 1 where rotations may begin, 0 where not, or NONE.
        counts: (1,), of nodes.
    """

    places: IntArray
    turning: IntArray
    lines: Array
    next: IntArray
    first: IntArray
    past: IntArray
    resting: IntArray
    rotating: IntArray
    begins: IntArray
    counts: IntArray


@final
class NumberedNodes:
    """Numbers nodes.

    Attributes:
        book: them, as compiled code reads it; another one once it has grown.
    """

    def __init__(self) -> None:
        places, turning, *none = np.full((8, FIRST), NONE)
        lines, counts = np.zeros((FIRST, 2, 3)), np.zeros(1, np.int64)
        self.book = NodeBook._make([places, turning, lines, *none, counts])

    def __len__(self) -> int:
        return int(self.book.counts[0])

    def reserve(self, nodes: int, poses: int) -> NodeBook:
        """Return the book with room for so many more nodes, at the first so many poses."""
        columns, of_nodes = list[Any](self.book[:-1]), len(self) + nodes
        for k, column in enumerate(columns):
            wanted = of_nodes if k < 6 else poses
            columns[k] = with_room(column, len(column), wanted, NONE)
        self.book = NodeBook._make([*columns, self.book.counts])
        return self.book

    def tails(self, nodes: IntArray) -> Tails:
        """Return nodes (N,) as motions leave them."""
        book = self.book
        return Tails(book.places[nodes], book.turning[nodes], book.lines[nodes])


@compiled
def resting(place: int, nodes: NodeBook) -> int:
    """Return the number of the node at a pose where no rotation is under way."""
    if nodes.resting[place] == NONE:
        nodes.resting[place] = nodes.counts[0]
        nodes.places[nodes.counts[0]], nodes.turning[nodes.counts[0]] = place, 0
        nodes.counts[0] += 1
    return int(nodes.resting[place])


@compiled
def rotating(place: int, point: Array, axis: Array, near: float, nodes: NodeBook) -> int:
    """Return the number of the node at a pose with a rotation under way about a line."""
    last, node = NONE, nodes.rotating[place]
    while node != NONE:
        if find(nodes.lines[node : node + 1], point, axis, near) == 0:
            return int(node)
        last, node = node, nodes.next[node]
    new = nodes.counts[0]
    nodes.counts[0] += 1
    nodes.places[new], nodes.turning[new], nodes.next[new] = place, 1, NONE
    for c in range(3):
        nodes.lines[new, 0, c], nodes.lines[new, 1, c] = point[c], axis[c]
    if last == NONE:
        nodes.rotating[place] = new
    else:
        nodes.next[last] = new
    return int(new)


@compiled
def arrive(found: Departures, book: Book, D: float, heads: IntArray) -> None:
    """Write the numbers of the poses (M,) to which motions lead."""
    for i in range(len(heads)):
        heads[i] = number(book, found.rotations[i], found.positions[i], D)


@compiled
def settle_beginnings(
    turns: BoolArray, heads: IntArray, nodes: NodeBook, book: Book, terrain: Terrain, onto: Sheet
) -> int:
    """Find whether rotations may begin at the poses (M,) to which rotations lead.

    Returns:
        A pose at which it is not known how the object stands; ``NO_ROOM`` for contacts; else the
        number of poses.
    """
    for i in range(len(heads)):
        place = heads[i]
        if not turns[i] or nodes.begins[place] != NONE:
            continue
        R, p = book.rotations[place], book.positions[place]
        said = may_begin(R, p, terrain.room, terrain.rules, terrain.D)
        if said < 0:
            past = touched(R, p, terrain.world if in_reach(p, terrain) else terrain.floor, onto, 0)
            if past == NO_ROOM:
                return NO_ROOM
            if past < 0:
                return int(place)
            at = stand(p, onto.points[:past], onto.normals[:past], terrain.rules)
            said = 1 if begins(at.exempt, p, terrain.rules) else 0
        nodes.begins[place] = said
    return int(book.counts[0])


@compiled
def join(
    tails: IntArray, found: Departures, heads: IntArray, kept: IntArray, past: IntArray,
    nodes: NodeBook, near: float,
) -> int:  # fmt: skip
    """Number the nodes to which motions lead; none leads where an earlier one leads, or back.

    Args:
        tails: (N,), the nodes that they leave.
        found: they, row by row.
        heads: (M,), the numbers of the poses to which they lead; the nodes' are written.
        kept: (M,), written: the rows of the motions that are arcs.
        past: (N,), written: the arc behind each node's last.
        nodes: written, but for what leaves them.
        near: lines so near to each other are one.

    Returns:
        How many arcs there are.
    """
    count = begin = 0
    for n in range(len(tails)):
        first = count
        for i in range(begin, found.past[n]):
            place = heads[i]
            if found.turns[i] and nodes.begins[place] == 0:
                head = rotating(place, found.by[i], found.axes[i], near, nodes)
            else:
                head = resting(place, nodes)
            known = head == tails[n]
            for k in range(first, count):
                known |= heads[k] == head
            if not known:
                heads[count], kept[count] = head, i
                count += 1
        begin, past[n] = found.past[n], count
    return count
