"""Orders of regrasps: each comes once, of interchangeable fingers the first ones first."""

from __future__ import annotations

import itertools

import pytest

from gm_ompl.graph.skeletons import skeletons


def renamed(lifted: tuple[int, ...], groups: tuple[tuple[int, ...], ...]) -> tuple[int, ...]:
    """Return an order with interchangeable fingers renamed in the order in which they come."""
    names: dict[int, int] = {}
    for finger in lifted:
        if finger not in names:
            group = next(g for g in groups if finger in g)
            names[finger] = group[sum(other in group for other in names)]
    return tuple(names[finger] for finger in lifted)


@pytest.mark.parametrize("groups", [((0, 1),), ((0,), (1,)), ((0, 2), (1,)), ((0, 1, 2, 3),)])
def test_every_order_comes_once(groups: tuple[tuple[int, ...], ...]) -> None:
    """The orders are all those that differ by more than a renaming."""
    n = sum(len(group) for group in groups)
    for k in range(4):
        found = [skeleton.lifted for skeleton in skeletons(groups, k)]
        every = {renamed(order, groups) for order in itertools.product(range(n), repeat=k)}
        assert len(found) == len(set(found))
        assert set(found) == every


def test_legs_follow_the_regrasps() -> None:
    """A regrasp gives its finger a new spot; those who stay keep theirs."""
    (skeleton,) = (s for s in skeletons(((0, 1, 2),), 2) if s.lifted == (0, 1))
    assert skeleton.legs == ((0, 1, 2), (3, 1, 2), (3, 4, 2))
    assert [skeleton.finger(spot) for spot in range(skeleton.spots)] == [0, 1, 2, 0, 1]
    assert [skeleton.is_last(spot) for spot in range(5)] == [False, False, True, True, True]
    assert skeleton.alike == ()
    assert next(skeletons(((0, 1, 2),), 1)).alike == ((1, 2),)
