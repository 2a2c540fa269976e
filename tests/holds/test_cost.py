"""Eqs. (9) and (10)."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gm_ompl.holds.cost import displacement_cost, stability_factor

LENGTH = st.floats(0.0, 10.0)
MARGIN = st.floats(0.01, 1e4)


def test_by_hand() -> None:
    """Two fingers, two segments, X_stab = 1: the first finger's 2 (1 + 1/2) + 3 (1 + 1/4)."""
    cost = displacement_cost([[2.0, 3.0], [0.0, 4.0]], [2.0, 4.0], 1.0, 0.1)
    assert cost == pytest.approx(2.0 * 1.5 + 3.0 * 1.25)


@given(st.lists(st.tuples(LENGTH, LENGTH), min_size=1, max_size=4), MARGIN, MARGIN, LENGTH)
def test_between_travel_and_the_worst_factor(
    lengths: list[tuple[float, float]], z1: float, z2: float, X_stab: float
) -> None:
    """(9) is at least the largest travel, and at most that times the larger factor."""
    cost = displacement_cost(lengths, [z1, z2], X_stab, 0.01)
    furthest = max(a + b for a, b in lengths)
    assert furthest <= cost * (1 + 1e-12)
    assert cost <= furthest * stability_factor(min(z1, z2), X_stab, 0.01) * (1 + 1e-12)


def test_limits_of_the_factor() -> None:
    """No weight on unbounded margins; small ones count as z_floor; no equilibrium, no cost."""
    assert stability_factor(math.inf, 3.0, 0.5) == 1.0
    assert stability_factor(0.0, 3.0, 0.5) == stability_factor(0.5, 3.0, 0.5) == 7.0
    assert stability_factor(-math.inf, 0.0, 0.5) == math.inf
    assert displacement_cost([[0.0]], [-math.inf], 3.0, 0.5) == math.inf
