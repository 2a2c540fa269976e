"""Sets of placements near others: each finger at one of a few points around its own."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.holds.spots import Spot, Spots
from gm_ompl.problem import Placements
from gm_ompl.sampling.lane_store import SetDraw, as_sets
from gm_ompl.sampling.placing import Placing

Hand: TypeAlias = tuple[Spot, ...]
"""Where each finger is."""

FIRST_REACH: Final = 0.25
"""How far away points are first, in half sizes of the face."""

DRAWN: Final = 4
"""Points drawn around each, beside those along the face's axes and between them."""

SETS: Final = 400
"""Sets around a hand, at most, where several fingers move at once."""


def hand_of(spots: Spots, table: PlacementTable, placements: Placements) -> Hand:
    """Return where the fingers of a set of a table are."""
    return tuple(spots.of(table, row) for row in placements)


class Near(NamedTuple):
    """Some hands, and points around those where their fingers are.

    Attributes:
        hands: likewise.
        points: per place of a finger, itself and those around it.
    """

    hands: Sequence[Hand]
    points: Mapping[Spot, Sequence[Spot]]

    @classmethod
    def around(
        cls, placing: Placing, hands: Sequence[Hand], reach: float, rng: np.random.Generator
    ) -> Near:
        """Return points around, so far away at most, in half sizes of the face; some at random."""
        places = dict.fromkeys(itertools.chain.from_iterable(hands))
        points = {
            place: placing.spots.around([place], reach, rng.uniform(-1.0, 1.0, (DRAWN, 2)))
            for place in places
        }
        return cls(hands, points)

    def judge(self, placing: Placing) -> Judge:
        """Return a judge of the problem with these points."""
        return placing.judge(itertools.chain.from_iterable(self.points.values()))

    def sets(self, placing: Placing, judge: Judge, most: int, rng: np.random.Generator) -> IntArray:
        """Return the canonical sets (L, n) near the hands, by the rows of ``judge``'s table.

        Per hand so many at most; those with one finger elsewhere are among them all the same.
        """
        table, rows = judge.problem.fingers.placements, defaultdict[Spot, list[int]](list)
        for row in range(len(table)):
            rows[placing.spots.of(table, row)].append(row)
        draw, found = SetDraw(judge.problem, judge, 0.0, 1.0), []
        for hand in self.hands:
            options = [[row for spot in self.points[place] for row in rows[spot]] for place in hand]
            found.append(draw.fitting(_combined(options, most, rng)))
        return np.concatenate(found)


def _combined(options: Sequence[Sequence[int]], most: int, rng: np.random.Generator) -> IntArray:
    """Return sets of one option per finger: all; or, where they are too many, some.

    These have one finger elsewhere; others, drawn at random, fill up what may be left. The first
    option is where a finger is.
    """
    if math.prod(map(len, options)) <= most:
        return as_sets(itertools.product(*options), len(options))
    present = [rows[0] for rows in options]
    alone = as_sets(
        ((*present[:i], row, *present[i + 1 :]) for i, rows in enumerate(options) for row in rows),
        len(options),
    )
    left = max(0, most - len(alone))
    drawn = np.stack([rng.choice(rows, size=left) for rows in options], axis=1)
    return np.concatenate([alone, drawn])
