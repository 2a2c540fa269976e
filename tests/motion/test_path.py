"""Paths: slides and tumbles that follow each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gm_ompl.arrays import Array
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.solids import Body, box, hull
from gm_ompl.motion.path import PathMotion, path_lattice, tumble_towards
from gm_ompl.motion.screw import Piece, Slide, Tumble

X = np.array([1.0, 0.0, 0.0])
CUBOID = Body((box([-2.5, -2.5, -5.0], [2.5, 2.5, 5.0]),))


def chain(scale: float = 1.0, yaw: float = 0.0) -> PathMotion:
    """Slide, tumble, slide, all towards +x, of a cuboid of the given scale."""
    body = Body((box(np.array([-2.5, -2.5, -5]) * scale, np.array([2.5, 2.5, 5]) * scale),))
    start = Pose.from_yaw([0.3 * scale, -0.2 * scale, 5 * scale], yaw)
    pieces: list[Piece] = [Slide(np.array([4.0, 1.0, 0.0]) * scale)]
    pose = pieces[0].pose(start, 1.0)
    pieces.append(tumble_towards(body, pose, X, math.pi / 2))
    pieces.append(Slide(np.array([0.0, 3.0, 0.0]) * scale))
    return PathMotion(start, pieces)


def twist_by_differences(motion: PathMotion, s: float, step: float) -> tuple[Array, Array]:
    """The pose's derivative at s, from poses step ahead and behind: another route to velocity."""
    ahead, behind, here = motion.pose([s + step]), motion.pose([s - step]), motion.pose([s])
    linear = (ahead.position - behind.position) / (2 * step)
    spin = (ahead.rotation - behind.rotation) / (2 * step) @ here.rotation.T
    return linear, np.array([spin[2, 1], spin[0, 2], spin[1, 0]])


@given(s=st.floats(0.001, 0.999), ds=st.sampled_from([-2.0, -1.0, 1.0, 0.5]))
def test_velocity_is_the_derivative_of_the_pose(s: float, ds: float) -> None:
    """Away from piece boundaries velocity(s, ds) = ds * d pose / ds, by central differences."""
    motion = chain()
    step = 1e-6
    if min(abs(s - b) for b in (1 / 3, 2 / 3)) < 2 * step:
        return
    linear, angular = twist_by_differences(motion, s, step)
    twist = motion.velocity([s], [ds])
    np.testing.assert_allclose(twist.linear, ds * linear, atol=1e-6)
    np.testing.assert_allclose(twist.angular, ds * angular, atol=1e-6)


@pytest.mark.parametrize("boundary", [1 / 3, 2 / 3])
def test_pose_is_continuous_where_pieces_meet(boundary: float) -> None:
    """The pose has no jump at a breakpoint, which is where the motion says it is."""
    motion = chain()
    assert any(math.isclose(boundary, b) for b in motion.breakpoints[0])
    before, after = motion.pose([boundary - 1e-9]), motion.pose([boundary + 1e-9])
    np.testing.assert_allclose(before.position, after.position, atol=1e-6)
    np.testing.assert_allclose(before.rotation, after.rotation, atol=1e-6)


def test_velocity_at_a_breakpoint_is_that_of_the_piece_ahead() -> None:
    """Forwards at s = 1/3 the object tumbles, backwards it slides back."""
    motion = chain()
    forwards, backwards = motion.velocity([1 / 3], [1.0]), motion.velocity([1 / 3], [-1.0])
    np.testing.assert_allclose(forwards.angular, [0, 3 * math.pi / 2, 0], atol=1e-12)
    np.testing.assert_allclose(backwards.linear, [-12, -3, 0], atol=1e-12)
    np.testing.assert_array_equal(backwards.angular, np.zeros(3))


@given(s=st.floats(0, 1))
def test_bounds_and_ends(s: float) -> None:
    """s = 0 is the start pose exactly, s = 1 the last knot exactly; every rotation is proper."""
    motion = chain()
    assert motion.pose([0.0]) is motion.start
    assert motion.pose([1.0]) is motion.knots[-1]
    rotation = motion.pose([s]).rotation
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) > 0


def test_paper_tumble_ends_on_its_side() -> None:
    """The 5 x 5 x 10 cuboid about its +x bottom edge: the centre ends at (7.5, 0, 2.5)."""
    start = Pose.from_yaw([0, 0, 5])
    piece = tumble_towards(CUBOID, start, X, math.pi / 2)
    np.testing.assert_allclose(piece.pivot[[0, 2]], [2.5, 0.0], atol=1e-12)
    end = piece.pose(start, 1.0)
    np.testing.assert_allclose(end.position, [7.5, 0.0, 2.5], atol=1e-12)
    np.testing.assert_allclose(end.rotation, rotation_about([0, 1, 0], math.pi / 2), atol=1e-12)


@given(
    direction=st.sampled_from([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]),
    quarter=st.integers(0, 3),
    fraction=st.floats(0, 1),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_tumbling_keeps_its_edge_and_never_sinks(
    direction: list[int], quarter: int, fraction: float, scale: float
) -> None:
    """Up to 90 degrees the lowest corners stay at the floor, at every scale and quarter turn."""
    body = Body((box(np.array([-1, -2, -3]) * scale, np.array([1, 2, 3]) * scale),))
    start = Pose.from_yaw([0, 0, 3 * scale], quarter * math.pi / 2)
    piece = tumble_towards(body, start, np.array(direction, dtype=float), math.pi / 2)
    heights = piece.pose(start, fraction).apply(body.vertices)[:, 2]
    assert abs(heights.min()) <= 1e-12 * body.diagonal
    moved = piece.pose(start, fraction).position - start.position
    assert moved @ np.array(direction) >= 0


def test_second_tumble_turns_about_the_edge_where_it_starts() -> None:
    """Two tumbles in a row: the second pivots about the far end of the box that now lies."""
    start = Pose.from_yaw([0, 0, 5])
    first = tumble_towards(CUBOID, start, X, math.pi / 2)
    lying = first.pose(start, 1.0)
    second = tumble_towards(CUBOID, lying, X, math.pi / 2)
    np.testing.assert_allclose(second.pivot[[0, 2]], [12.5, 0.0], atol=1e-9)
    np.testing.assert_allclose(second.pose(lying, 1.0).position, [15, 0, 5], atol=1e-9)


@pytest.mark.parametrize("degrees", [1, 30, 45])
def test_no_edge_across_the_direction_is_refused(degrees: float) -> None:
    """A box turned away from the direction would tip over a corner: an error."""
    start = Pose.from_yaw([0, 0, 5], math.radians(degrees))
    with pytest.raises(GeometryError, match="single point"):
        tumble_towards(CUBOID, start, X, math.pi / 2)


def test_tetrahedron_tips_over_an_edge_but_not_over_a_corner() -> None:
    """A hull with a triangular base has a bottom edge on one side and a corner on the other."""
    body = Body((hull([[0, 0, 0], [3, -1, 0], [3, 1, 0], [2, 0, 2]]),))
    pose = Pose.from_yaw([0, 0, 0])
    assert tumble_towards(body, pose, X, 1.0).pivot[0] == pytest.approx(3)
    with pytest.raises(GeometryError):
        tumble_towards(body, pose, -X, 1.0)


def test_a_path_without_pieces_is_refused() -> None:
    """A path has at least one piece."""
    with pytest.raises(GeometryError, match="at least one piece"):
        PathMotion(Pose.from_yaw([0, 0, 0]), [])


def test_tumble_axis_is_made_unit() -> None:
    """An axis of any length gives the same rotation."""
    start = Pose.from_yaw([0, 0, 1])
    long, short = (Tumble(np.zeros(3), np.array([0, k, 0]), 1.0) for k in (5.0, 1.0))
    np.testing.assert_allclose(long.pose(start, 1).rotation, short.pose(start, 1).rotation)


@given(segments=st.lists(st.integers(1, 12), min_size=1, max_size=4))
def test_piece_boundaries_are_lattice_nodes(segments: list[int]) -> None:
    """Piece p of m has its own number of equal arcs in [p/m, (p+1)/m]; ends are nodes."""
    lattice = path_lattice(segments)
    m = len(segments)
    assert lattice.size == sum(segments) + 1
    nodes = lattice.axes[0]
    assert nodes[0] == 0.0
    assert nodes[-1] == 1.0
    for p, count in enumerate(segments):
        inside = nodes[(nodes >= p / m - 1e-12) & (nodes <= (p + 1) / m + 1e-12)]
        np.testing.assert_allclose(np.diff(inside), 1 / (m * count), rtol=1e-9)
        assert len(inside) == count + 1
        assert lattice.find((p / m,)) is not None


@given(segments=st.lists(st.integers(1, 9), min_size=1, max_size=3))
def test_path_neighbours_are_one_step_either_way(segments: list[int]) -> None:
    """Each node's neighbours are the nodes before and after; the ends have one."""
    lattice = path_lattice(segments)
    for node in range(lattice.size):
        found = sorted(neighbour for neighbour, _ in lattice.neighbours(node))
        assert found == [k for k in (node - 1, node + 1) if 0 <= k < lattice.size]
