"""The order in which fingers are regrasped: what plans of cells have in common."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gm_ompl.holds.sets import Groups


@dataclass(frozen=True)
class Skeleton:
    """Which finger is regrasped when; a placement is chosen for each *spot*.

    Attributes:
        legs: per leg, the spot of each finger. The first n spots are those at the start.
        lifted: per regrasp, the finger.
        alike: spots that may be exchanged: those of interchangeable fingers never regrasped.
    """

    legs: tuple[tuple[int, ...], ...]
    lifted: tuple[int, ...]
    alike: Groups

    @property
    def spots(self) -> int:
        """Number of spots."""
        return len(self.legs[0]) + len(self.lifted)

    def finger(self, spot: int) -> int:
        """Return whose spot it is."""
        n = len(self.legs[0])
        return spot if spot < n else self.lifted[spot - n]

    def stays(self, spot: int) -> tuple[int, int]:
        """Return the first and the last leg on which its finger is there."""
        on = [m for m, leg in enumerate(self.legs) if spot in leg]
        return on[0], on[-1]

    def is_last(self, spot: int) -> bool:
        """Whether its finger ends there."""
        return spot in self.legs[-1]


def skeletons(groups: Groups, regrasps: int) -> Iterator[Skeleton]:
    """Yield all ways to regrasp so often; of interchangeable fingers the first ones come first."""
    group_of = {finger: group for group in groups for finger in group}
    n = len(group_of)
    for lifted in itertools.product(range(n), repeat=regrasps):
        met: set[int] = set()
        for finger in lifted:
            fresh = next((i for i in group_of[finger] if i not in met), finger)
            if finger not in met and finger != fresh:
                break
            met.add(finger)
        else:
            alike = tuple(tuple(i for i in group if i not in met) for group in groups)
            kept = tuple(group for group in alike if len(group) > 1)
            yield Skeleton(_legs(n, lifted), lifted, kept)


def _legs(n: int, lifted: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Return per leg the spot of each finger."""
    legs = [tuple(range(n))]
    for k, finger in enumerate(lifted):
        leg = list(legs[-1])
        leg[finger] = n + k
        legs.append(tuple(leg))
    return tuple(legs)
