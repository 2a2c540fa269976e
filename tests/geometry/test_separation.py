from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import Axis, PlacedPiece, gap, penetrates
from gm_ompl.geometry.solids import ConvexPiece, box

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]
RandomPose = Callable[[np.random.Generator, float], Pose]


def test_gap_of_aligned_boxes_is_the_face_distance() -> None:
    """Boxes apart, touching and overlapping along z: the gap is the z distance, normal +z."""
    below = PlacedPiece(box([-5, -5, -1], [5, 5, 0]))
    for height in (0.25, 0.0, -0.125):
        above = PlacedPiece(box([-1, -1, height], [1, 1, height + 2]))
        found = gap(above, below, tie=1e-9)
        assert found.width == height
        np.testing.assert_array_equal(found.normal, [0, 0, 1])
        assert found.axis is Axis.SECOND


def test_gap_of_crossed_edges_is_their_common_perpendicular() -> None:
    """Two cubes, each on an edge, one across the other: the gap lies between the two edges."""
    cube = box([-1, -1, -1], [1, 1, 1])
    ridge = Pose.from_quaternion([0, 0, 0], [np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0])
    valley = ridge.turned([0, 0, 0], [0, 0, 1], np.pi / 2).rotation
    upper = Pose(valley, np.array([0, 0, 2 * np.sqrt(2) + 0.01]))
    found = gap(PlacedPiece(cube, upper), PlacedPiece(cube, ridge))
    assert found.axis is Axis.EDGES
    assert found.width == pytest.approx(0.01, abs=1e-12)
    np.testing.assert_allclose(found.normal, [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_gap_agrees_with_the_minkowski_difference(
    size: float, random_hull: RandomHull, random_pose: RandomPose
) -> None:
    """The depth is the origin's below the hull of all vertex differences, another route.

    Apart, edges that are no face of that hull can only show more of the distance.
    """
    rng = np.random.default_rng(8)
    signs = []
    for _ in range(60):
        a, b = random_hull(rng, size), random_hull(rng, size)
        here, there = PlacedPiece(a, random_pose(rng, 1.5 * size)), PlacedPiece(b)
        steps = (here.vertices[:, None] - there.vertices[None]).reshape(-1, 3) / size
        want = ConvexHull(steps).equations[:, 3].max() * size
        found = gap(here, there)
        if want <= 0:
            assert found.width == pytest.approx(want, abs=1e-9 * size)
        else:
            nearest = np.linalg.norm(steps, axis=1).min() * size
            assert want - 1e-9 * size <= found.width <= nearest
        along = (here.vertices @ found.normal).min() - (there.vertices @ found.normal).max()
        assert along == pytest.approx(found.width, abs=1e-12 * size)
        assert penetrates(here, there, 0.0) == (want < 0)
        signs.append(want < 0)
    assert 0.1 < np.mean(signs) < 0.9, "both outcomes occur"


def test_gap_moves_along_with_the_world(random_hull: RandomHull, random_pose: RandomPose) -> None:
    """A rigid motion of both pieces leaves the gap and turns the normal; swapping flips it."""
    rng = np.random.default_rng(9)
    for _ in range(30):
        a, b, pose, world = (
            random_hull(rng, 1.0), random_hull(rng, 1.0), random_pose(rng, 2.0),
            random_pose(rng, 5.0),
        )  # fmt: skip
        moved = Pose(world.rotation @ pose.rotation, world.apply(pose.position))
        first = gap(PlacedPiece(a, pose), PlacedPiece(b))
        second = gap(PlacedPiece(a, moved), PlacedPiece(b, world))
        swapped = gap(PlacedPiece(b), PlacedPiece(a, pose))
        assert second.width == pytest.approx(first.width, abs=1e-12)
        np.testing.assert_allclose(second.normal, world.rotation @ first.normal, atol=1e-9)
        assert swapped.width == pytest.approx(first.width, abs=1e-14)
        np.testing.assert_allclose(swapped.normal, -first.normal, atol=1e-9)
