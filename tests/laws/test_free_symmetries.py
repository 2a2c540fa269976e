"""What must not change the optimal cost of free motion: place, direction, handedness, units."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from tests.free_laws import CHANGES, square

Tree = dict[str, Any]

SMALL = (
    ("random/free/3", ()),  # turned and pushed
    ("random/free/5", ()),  # lifted
    ("random/free-clutter/2", ("lattice.depth=3",)),
)
"""Solved in some tenths of a second each."""


@pytest.mark.parametrize(("name", "less"), SMALL)
def test_the_cost_of_free_motion_has_the_worlds_symmetries(
    name: str, less: tuple[str, ...], optimum: Callable[..., float]
) -> None:
    """Moved, turned with its axes, mirrored, in other units, fingers renumbered: the same cost."""
    tree = square(name, *less)
    cost = optimum(tree)
    assert cost < math.inf
    changes = CHANGES if not less else {key: CHANGES[key] for key in ("quarter turn", "units")}
    for change, (changed, scale) in changes.items():
        assert optimum(changed(tree)) == pytest.approx(cost * scale, rel=1e-6), change


def test_the_laws_of_free_motion_can_fail(optimum: Callable[..., float]) -> None:
    """What is no symmetry changes the cost: more friction on the floor."""
    tree = square("random/free/3")
    cost = optimum(tree)
    tree["friction"]["environment"] *= 1.2
    assert optimum(tree) != pytest.approx(cost, rel=1e-6)
