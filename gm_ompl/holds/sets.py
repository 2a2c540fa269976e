"""Sets of placements: the hand's part of a node.

Interchangeable fingers hold an unordered set of placements, written in one canonical order, so
that exchanging two of them is the same node. A finger in the air is LIFTED: such a set is the
hub through which regrasping passes (all placements of that finger are one hub away).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.problem import Placements

LIFTED: Final = -1
"""Stands for the placement of a finger that does not touch the object."""

CANDIDATES: Final = 300_000
"""Candidates for sets looked at at once, in some 15 MB."""

Groups = tuple[tuple[int, ...], ...]
Clearances = Sequence[Sequence[BoolArray | None]]


@final
class PlacementSets:
    """Canonical placement sets and their numbers, given out as sets are met.

    Args:
        groups: the groups of interchangeable fingers.
    """

    def __init__(self, groups: Groups) -> None:
        self.groups = groups
        self._mixed = [group for group in groups if len(group) > 1]
        self._numbers: dict[Placements, int] = {}
        self._sets: list[Placements] = []

    def __len__(self) -> int:
        return len(self._sets)

    def canonical(self, placements: Placements) -> Placements:
        """Return the set's canonical order: increasing within each group, LIFTED last."""
        if not self._mixed:
            return placements
        ordered = list(placements)
        for group in self._mixed:
            rows = sorted(ordered[i] for i in group)
            if rows[0] == LIFTED:
                rows = rows[1:] + rows[:1]
            for i, row in zip(group, rows, strict=True):
                ordered[i] = row
        return tuple(ordered)

    def canonical_rows(self, sets: IntArray) -> IntArray:
        """Return many sets (L, n), nobody LIFTED, in canonical order."""
        ordered = sets.copy()
        for group in self._mixed:
            columns = list(group)
            ordered[:, columns] = np.sort(ordered[:, columns], axis=1)
        return ordered

    def number(self, canonical: Placements) -> int:
        """Return the number of a canonical set, a new one on first sight."""
        known = self._numbers.setdefault(canonical, len(self._sets))
        if known == len(self._sets):
            self._sets.append(canonical)
        return known

    def placements(self, number: int) -> Placements:
        """Return the canonical set with ``number``."""
        return self._sets[number]

    def hubs(self, canonical: Placements) -> tuple[Placements, ...]:
        """Return per slot the canonical set in which its finger is LIFTED."""
        return tuple(self.replaced(canonical, slot, LIFTED) for slot in range(len(canonical)))

    def replaced(self, canonical: Placements, slot: int, row: int) -> Placements:
        """Return the canonical set in which the finger at ``slot`` is at ``row``."""
        return self.canonical((*canonical[:slot], row, *canonical[slot + 1 :]))


def ordered_sets(
    groups: Groups, allowed: Sequence[BoolArray], keys: Sequence[Array], clear: Clearances
) -> Iterator[tuple[float, Placements]]:
    """Yield (key, canonical set) of all valid sets, keys not decreasing, made on demand.

    A set's key is the largest of its fingers' keys. There may be 10^10 sets: they are made from
    the placements in increasing order of their keys, each joined with those before it.

    Args:
        groups: the groups of interchangeable fingers.
        allowed: per finger, (P,), where it may be; equal within a group.
        keys: per finger, (P,), its key there; +inf leaves a placement out. Equal within a group.
        clear: per pair of fingers, (P, P), whether they do not penetrate each other.
    """
    queue: list[tuple[float, int, int]] = []
    for g, group in enumerate(groups):
        key = keys[group[0]]
        rows = np.flatnonzero(allowed[group[0]] & np.isfinite(key))
        queue.extend((float(key[row]), g, int(row)) for row in rows)
    queue.sort()
    group_of = {finger: g for g, group in enumerate(groups) for finger in group}
    seen: list[list[int]] = [[] for _ in groups]
    for key_now, g, row in queue:
        limits.check()
        first = groups[g][0]
        others = tuple(i for i in group_of if i != first)
        pools = tuple(
            _clear_of(first, row, i, np.array(seen[group_of[i]], dtype=np.int64), clear)
            for i in others
        )
        for rest in _joined(others, pools, group_of, clear):
            yield key_now, _spread(groups, {first: row, **dict(zip(others, rest, strict=True))})
        seen[g].append(row)


def _joined(
    fingers: tuple[int, ...],
    pools: tuple[IntArray, ...],
    group_of: Mapping[int, int],
    clear: Clearances,
) -> Iterator[tuple[int, ...]]:
    """Yield rows for ``fingers``, each from its pool, clear of each other.

    Pools are equal within a group; of interchangeable fingers each combination comes once.
    """
    if not fingers:
        yield ()
        return
    finger, others = fingers[0], fingers[1:]
    for k, row in enumerate(pools[0].tolist()):
        limits.check()
        left = tuple(
            _clear_of(
                finger, row, i, pool[k + 1 :] if group_of[i] == group_of[finger] else pool, clear
            )
            for i, pool in zip(others, pools[1:], strict=True)
        )
        if all(len(pool) for pool in left):
            for rest in _joined(others, left, group_of, clear):
                yield (row, *rest)


def beside(hub: Placements, clear: Clearances) -> BoolArray:
    """Return where a hub's lifted finger is clear of the others, (P,); (1,) for a lone finger."""
    pairs = [
        pair[:, row]
        for pair, row in zip(clear[hub.index(LIFTED)], hub, strict=True)
        if pair is not None
    ]
    return np.logical_and.reduce(pairs) if pairs else np.ones(1, dtype=bool)


def staying_of(hub: Placements) -> tuple[tuple[int, int], ...]:
    """Return the fingers that touch at a hub, and the row of each."""
    return tuple((i, row) for i, row in enumerate(hub) if row != LIFTED)


def _clear_of(finger: int, row: int, other: int, pool: IntArray, clear: Clearances) -> IntArray:
    """Return the rows of ``pool`` where ``other`` is clear of ``finger`` at ``row``."""
    pair = clear[finger][other]
    return pool if pair is None else pool[pair[row, pool]]


def _spread(groups: Groups, row_of: Mapping[int, int]) -> Placements:
    if len(groups) == 1:
        return tuple(sorted(row_of.values()))
    placements = [LIFTED] * len(row_of)
    for group in groups:
        for finger, row in zip(group, sorted(row_of[i] for i in group), strict=True):
            placements[finger] = row
    return tuple(placements)


def placement_sets(
    groups: Groups, allowed: Sequence[BoolArray], clear: Clearances, most: int
) -> IntArray | None:
    """Return all valid canonical sets (L, n), or None where some step makes more than ``most``.

    None, too, where they are beyond the memory that may be taken.
    """
    n = len(allowed)
    sets = np.zeros((1, 0), dtype=np.int64)
    group_of = {finger: group for group in groups for finger in group}
    for i in range(n):
        rows = np.flatnonzero(allowed[i])
        if len(sets) * len(rows) > 8 * most:
            return None
        grown, size = [np.zeros((0, i + 1), dtype=np.int64)], 0
        at_once = max(1, CANDIDATES // max(1, len(rows)))
        for first in range(0, len(sets), at_once):
            limits.check()
            some = sets[first : first + at_once]
            left, right = np.divmod(np.arange(len(some) * len(rows)), max(len(rows), 1))
            right = rows[right]
            keep = np.ones(len(left), dtype=bool)
            for j in range(i):
                pair = clear[i][j]
                if pair is not None:
                    keep &= pair[right, some[left, j]]
                if j in group_of[i]:
                    keep &= some[left, j] < right
            grown.append(np.concatenate([some[left[keep]], right[keep, None]], axis=1))
            size += len(grown[-1])
            if size > most or not limits.fits(8.0 * size * (i + 1)):
                return None
        sets = np.concatenate(grown)
    return np.ascontiguousarray(sets)
