"""Placements on no grid: the hand of a problem with points of the faces in its table."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.patches import Patch, loose, patches
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.problem import Displacement, Fingers, Move, Problem

Spot: TypeAlias = tuple[int, tuple[float, float, float]]
"""A patch, and a point on it."""


COMPASS: Final = np.array([[float(i), float(j)] for i in (0, -1, 1) for j in (0, -1, 1)])
"""Steps along a face's axes and between them, the first one none."""

NONE: Final = np.zeros((0, 2))


@final
class Spots:
    """Where the fingers of a problem may be placed, and problems with few placements.

    Args:
        problem: asks for placements anywhere on faces.

    Attributes:
        patches: where fingers may be placed.
    """

    def __init__(self, problem: Problem) -> None:
        where = problem.fingers.anywhere
        assert where is not None, "the scenario asks for it"
        self._problem = problem
        self.patches: tuple[Patch, ...] = patches(problem.body, where.faces, where.margin)
        self._patch_of = {patch.number: f for f, patch in enumerate(self.patches)}

    def offers(self, spot: Spot) -> bool:
        """Whether a finger may be placed at a spot."""
        return bool(self.patches[spot[0]].offers(np.array([spot[1]]))[0])

    def of(self, table: PlacementTable, row: int) -> Spot:
        """Return where a placement of a table is."""
        x, y, z = table.points[row].tolist()
        return self._patch_of[int(table.face[row])], (x, y, z)

    def around(self, spots: Iterable[Spot], reach: float, others: Array = NONE) -> list[Spot]:
        """Return spots and others around them, on the rim rather than beyond it, offered or not.

        Args:
            spots: where to look.
            reach: how far, in half sizes of the face.
            others: (k, 2), steps tried beside those along the face's axes and between them, over
                the reach.
        """
        steps = np.concatenate([COMPASS, others])
        found = []
        for f, point in spots:
            patch = self.patches[f]
            half = patch.rectangle.half
            place = patch.places(np.array([point]))
            points = patch.points(np.clip(place + reach * steps * half, -half, half))
            points[0] = point
            found += [(f, (x, y, z)) for x, y, z in points.tolist()]
        return found

    def placed(self, spots: Iterable[Spot]) -> Problem:
        """Return the problem with these placements alone, and those that the hand is given.

        Spots that are not offered are left out, and each is taken once.
        """
        hand = self._problem.fingers
        kept = [spot for spot in dict.fromkeys(spots) if self.offers(spot)]
        given = sorted({row for row in (*hand.start, *hand.goal) if row is not None})
        table = hand.placements.at(given)
        if kept:
            which, points = [f for f, _ in kept], np.array([point for _, point in kept])
            table = table.joined(loose(self.patches, which, points, table.labels))
        start, goal = (
            tuple(None if row is None else given.index(row) for row in rows)
            for rows in (hand.start, hand.goal)
        )
        placed = dataclasses.replace(hand, placements=table, start=start, goal=goal)
        return dataclasses.replace(self._problem, fingers=placed)


class PlacedPlan(NamedTuple):
    """A plan, and whose rows its moves name.

    Attributes:
        moves: from start to goal.
        table: the placements.
        cost: of all moves.
    """

    moves: tuple[Move, ...]
    table: PlacementTable
    cost: float


@final
class NamedPoints:
    """A hand's placements, and behind them those of other tables that plans name.

    Args:
        hand: the problem's.

    Attributes:
        table: all of them so far; rows stay what they are.
    """

    def __init__(self, hand: Fingers) -> None:
        self._hand, self.table = hand, hand.placements

    @property
    def fingers(self) -> Fingers:
        """The hand with these placements."""
        return dataclasses.replace(self._hand, placements=self.table)

    def row(self, other: PlacementTable, row: int) -> int:
        """Return the row here of another table's placement, which joins these if it is new."""
        label, cell = other.labels[int(other.face[row])], other.cell[row].tolist()
        known = (
            self.table.find_point(label, other.points[row].tolist())
            if min(cell) < 0
            else self.table.find(label, cell)
        )
        if known is None:
            self.table = self.table.joined(other.at([row]))
            known = len(self.table) - 1
        return known

    def named(self, moves: Sequence[Move], other: PlacementTable) -> tuple[Move, ...]:
        """Return moves with the rows of another table told by those of this one."""
        rows = {row: self.row(other, row) for row in rows_of(moves)}
        return tuple(renamed(move, rows) for move in moves)


def rows_of(moves: Iterable[Move]) -> list[int]:
    """Return the placements that moves name, each once."""
    return list(
        dict.fromkeys(
            row
            for move in moves
            for row in (
                move.placements
                if isinstance(move, Displacement)
                else (*move.placements, move.target)
            )
        )
    )


def renamed(move: Move, rows: dict[int, int]) -> Move:
    """Return a move with its placements' rows in another table."""
    placements = tuple(rows[row] for row in move.placements)
    if isinstance(move, Displacement):
        return dataclasses.replace(move, placements=placements)
    return dataclasses.replace(move, placements=placements, target=rows[move.target])
