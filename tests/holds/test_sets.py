"""Placement sets: canonical order, numbers, and their enumeration in order of keys."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.arrays import Array
from gm_ompl.holds.sets import LIFTED, PlacementSets, ordered_sets

GROUPS = st.sampled_from([
    ((0,),), ((0, 1),), ((0,), (1,)), ((0, 1, 2),), ((0, 2), (1,)), ((0, 1), (2, 3)),
])  # fmt: skip


@given(GROUPS, st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_every_valid_set_comes_once_and_in_order(
    groups: tuple[tuple[int, ...], ...], seed: int
) -> None:
    """Enumeration equals filtering all assignments, each unordered set once, keys sorted."""
    rng = np.random.default_rng(seed)
    n, P = sum(len(g) for g in groups), 6
    allowed = [np.ones(P, dtype=bool)] * n
    keys: list[Array] = [np.zeros(P)] * n
    for group in groups:
        mask, key = rng.random(P) < 0.8, rng.integers(0, 4, P).astype(float)
        key[rng.random(P) < 0.1] = np.inf
        for i in group:
            allowed[i], keys[i] = mask, key
    pair = rng.random((P, P)) < 0.8
    pair = pair & pair.T
    np.fill_diagonal(pair, False)
    clear = [[None if i == j else pair for j in range(n)] for i in range(n)]

    sets = PlacementSets(groups)
    expected = {}
    for rows in itertools.product(range(P), repeat=n):
        most = max(float(keys[i][row]) for i, row in enumerate(rows))
        fits = all(allowed[i][row] for i, row in enumerate(rows)) and all(
            pair[a, b] for a, b in itertools.combinations(rows, 2)
        )
        if fits and most < np.inf:
            expected[sets.canonical(rows)] = most
    found = list(ordered_sets(groups, allowed, keys, clear))
    assert len(found) == len(expected)
    assert {rows: key for key, rows in found} == expected
    assert [key for key, _ in found] == sorted(key for key, _ in found)


def test_enumeration_is_lazy() -> None:
    """The first of 10^10 sets come at once."""
    P, n = 294, 5
    apart = ~np.eye(P, dtype=bool)
    clear = [[None if i == j else apart for j in range(n)] for i in range(n)]
    sets = ordered_sets(
        (tuple(range(n)),), [np.ones(P, dtype=bool)] * n, [np.arange(P, dtype=float)] * n, clear
    )
    first = [next(sets) for _ in range(3)]
    assert first[0] == (4.0, (0, 1, 2, 3, 4))
    assert [key for key, _ in first] == [4.0, 5.0, 5.0]


@given(st.permutations(range(5)), st.integers(-1, 4))
def test_exchanging_equal_fingers_is_the_same_set(order: list[int], slot: int) -> None:
    """All orders of interchangeable fingers have one number; a lifted one comes last."""
    sets = PlacementSets(((0, 1, 2), (3, 4)))
    rows = [7, 3, 5, 2, 9]
    if slot >= 0:
        rows[slot] = LIFTED
    within = [*sorted(range(3), key=lambda i: order[i]), *sorted((3, 4), key=lambda i: order[i])]
    canonical = sets.canonical(tuple(rows))
    mixed = sets.canonical(tuple(rows[i] for i in within))
    assert sets.number(canonical) == sets.number(mixed)
    assert sets.placements(sets.number(mixed)) == canonical
    for group in sets.groups:
        touching = [canonical[i] for i in group if canonical[i] != LIFTED]
        assert touching == sorted(touching)
        assert [canonical[i] for i in group][: len(touching)] == touching


def test_unequal_fingers_keep_their_places() -> None:
    """Exchanging unequal fingers is another set."""
    sets = PlacementSets(((0,), (1,)))
    assert sets.number(sets.canonical((1, 2))) != sets.number(sets.canonical((2, 1)))
    assert len(sets) == 2


@pytest.mark.parametrize("slot", [0, 1])
def test_replacing_keeps_the_order(slot: int) -> None:
    """A set with a finger replaced is canonical again."""
    sets = PlacementSets(((0, 1),))
    assert sets.replaced((3, 8), slot, LIFTED) == ((8, LIFTED) if slot == 0 else (3, LIFTED))
    assert sets.replaced((3, LIFTED), 1, 1) == (1, 3)
