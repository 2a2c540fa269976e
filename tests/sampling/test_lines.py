"""Straight motions: density, piece boundaries, order of judging."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gm_ompl.checking.coordinates import crossed, lattice_steps
from gm_ompl.problem import Problem
from gm_ompl.sampling import lines


@given(st.integers(0, 400))
def test_every_segment_comes_once_in_bisecting_order(count: int) -> None:
    """The order is a permutation, and its first tenth leaves no gap of more than a third."""
    order = lines.coarse_to_fine(count)
    assert sorted(order) == list(range(count))
    if count >= 100:
        met = sorted([-1, *order[: count // 10], count])
        assert max(b - a for a, b in itertools.pairwise(met)) <= count / 3


@pytest.mark.parametrize("name", ["chain", "turn"])
def test_as_dense_as_the_check_demands(name: str, small: Callable[[str], Problem]) -> None:
    """Strides are as many as the lattice steps that the check counts, rounded up."""
    problem, rng = small(name), np.random.default_rng(3)
    low, high = np.array(problem.motion.low), np.array(problem.motion.high)
    for _ in range(100):
        a, b = (tuple(rng.uniform(low, high).tolist()) for _ in range(2))
        b = lines.unwrapped(problem, b, a)
        steps = lattice_steps(problem, a, b)
        assert lines.lattice_steps(problem, a, b) == pytest.approx(steps, abs=1e-9)
        assert lines.strides_needed(problem, a, b) >= math.ceil(steps - 1e-6)


def test_whole_lattice_arcs_have_no_stride_too_many(small: Callable[[str], Problem]) -> None:
    """Between two lattice nodes there are as many strides as steps."""
    problem = small("chain")
    axis = problem.lattice.axes[0].tolist()
    for i in range(0, len(axis), 3):
        for j in range(i + 1, len(axis), 4):
            assert lines.strides_needed(problem, (axis[i],), (axis[j],)) == j - i


def test_no_part_spans_a_piece_boundary(small: Callable[[str], Problem]) -> None:
    """A line over all pieces is split at every boundary, either way."""
    problem = small("chain")
    boundaries = [(value,) for value in problem.motion.breakpoints[0]]
    assert boundaries, "the scenario has several pieces"
    assert lines.split(problem, (0.0,), (1.0,)) == [(0.0,), *boundaries, (1.0,)]
    assert lines.split(problem, (1.0,), (0.0,)) == [(1.0,), *reversed(boundaries), (0.0,)]
    parts = lines.split(problem, (0.01,), boundaries[0])
    assert crossed(problem, parts[0], parts[-1], 1e-9) is None
    assert len(parts) == 2


def test_the_shorter_way_round(small: Callable[[str], Problem]) -> None:
    """A yaw that wraps is brought within half a turn; other coordinates stay."""
    problem = small("turn")
    q = lines.unwrapped(problem, (1.0, 1.0, 3.0), (0.0, 0.0, -3.0))
    assert q == pytest.approx((1.0, 1.0, 3.0 - 2 * math.pi))
    assert lines.same(problem, (0.0, 0.0, math.pi), (0.0, 0.0, -math.pi))
