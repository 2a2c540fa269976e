"""Planar motion: x, y, yaw, and its lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gm_ompl.motion.planar import FULL_TURN, PlanarMotion, planar_lattice

HALF = math.pi


def whole_turn() -> PlanarMotion:
    return PlanarMotion([-2, -10, -HALF], [20, 10, HALF], 2.5)


coordinates = st.tuples(st.floats(-2, 20), st.floats(-10, 10), st.floats(-HALF, HALF))
directions = st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3))


@given(q=coordinates, dq=directions)
def test_velocity_is_the_derivative_of_the_pose(
    q: tuple[float, ...], dq: tuple[float, ...]
) -> None:
    """velocity(q, dq) is the derivative along dq: corners move as central differences say."""
    motion, step = whole_turn(), 1e-6
    arms = np.array([[1.0, 2.0, -2.5], [-3.0, 0.5, 2.5]])
    ahead, behind, here = (
        motion.pose([a + k * step * b for a, b in zip(q, dq, strict=True)]) for k in (1, -1, 0)
    )
    by_differences = (ahead.apply(arms) - behind.apply(arms)) / (2 * step)
    twist = motion.velocity(q, dq)
    np.testing.assert_allclose(twist.at(arms @ here.rotation.T), by_differences, atol=1e-6)


def test_height_stays() -> None:
    """z is the start's everywhere, and the object stays upright."""
    pose = whole_turn().pose([3.0, 4.0, 1.0])
    np.testing.assert_array_equal(pose.position, [3.0, 4.0, 2.5])
    np.testing.assert_array_equal(pose.rotation[2], [0, 0, 1])


@pytest.mark.parametrize(
    ("low", "high", "period"),
    [(-HALF, HALF, FULL_TURN), (0.0, 2 * HALF, FULL_TURN), (-1.0, 1.0, None), (0.0, 6.0, None)],
)
def test_yaw_wraps_only_over_a_full_turn(low: float, high: float, period: float | None) -> None:
    """Yaw has a period exactly where its range is 360 degrees."""
    assert PlanarMotion([0, 0, low], [1, 1, high], 0.0).periods == (None, None, period)


def test_periodic_yaw_has_no_repeated_node_and_wraps_both_ways() -> None:
    """In 5 degree steps a full turn has 72 nodes; from the last a step leads to the first."""
    lattice = planar_lattice(whole_turn(), (0.5, 0.5, math.radians(5)))
    assert lattice.shape == (45, 41, 72)
    last = lattice.find((0.0, 0.0, math.radians(175)))
    first = lattice.find((0.0, 0.0, -HALF))
    assert last is not None
    assert first is not None
    assert lattice.find((0.0, 0.0, HALF)) == first
    there = dict(lattice.neighbours(last))
    assert there[first][2] == pytest.approx(HALF)  # unwrapped: it continues from 175 degrees
    back = dict(lattice.neighbours(first))
    assert back[last][2] == pytest.approx(math.radians(-185))


@given(
    nx=st.integers(1, 30),
    step=st.floats(1e-4, 1e3),
    origin=st.floats(-1e3, 1e3),
    rest=st.floats(0.01, 0.99),
)
def test_lattice_is_anchored_at_low(nx: int, step: float, origin: float, rest: float) -> None:
    """Nodes are low + k step up to high; high itself only where it is a whole number of steps."""
    even = PlanarMotion([origin, 0, -1], [origin + nx * step, 1, 1], 0.0)
    assert planar_lattice(even, (step, 1.0, 1.0)).shape[0] == nx + 1
    uneven = PlanarMotion([origin, 0, -1], [origin + (nx + rest) * step, 1, 1], 0.0)
    lattice = planar_lattice(uneven, (step, 1.0, 1.0))
    assert lattice.shape[0] == nx + 1
    assert lattice.axes[0][0] == origin


def test_a_start_off_the_lattice_is_not_found() -> None:
    """What lies between nodes has no node number."""
    lattice = planar_lattice(whole_turn(), (0.5, 0.5, math.radians(5)))
    assert lattice.find((0.0, 0.0, 0.0)) is not None
    assert lattice.find((0.2, 0.0, 0.0)) is None
    assert lattice.find((0.0, 0.0, math.radians(2))) is None


def test_inner_nodes_have_six_neighbours_and_relations_are_mutual() -> None:
    """One step in one coordinate either way; whoever is my neighbour has me as one."""
    lattice = planar_lattice(whole_turn(), (4.0, 5.0, math.radians(60)))
    for node in range(lattice.size):
        neighbours = [other for other, _ in lattice.neighbours(node)]
        assert len(set(neighbours)) == len(neighbours)
        assert all(node in dict(lattice.neighbours(other)) for other in neighbours)
    middle = lattice.find((6.0, 0.0, 0.0))
    assert middle is not None
    assert len(list(lattice.neighbours(middle))) == 6


@given(yaw=st.floats(-30, 30))
def test_wrap_brings_yaw_into_its_range(yaw: float) -> None:
    """Wrapping changes a periodic yaw by whole turns only."""
    motion = whole_turn()
    wrapped = motion.wrap((0, 0, yaw))[2]
    assert -HALF <= wrapped <= HALF
    turns = (wrapped - yaw) / FULL_TURN
    assert turns == pytest.approx(round(turns), abs=1e-9)
