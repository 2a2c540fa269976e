from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.errors import GeometryError
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull, shifted

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]
RandomPose = Callable[[np.random.Generator, float], Pose]


def assert_sound(piece: ConvexPiece) -> None:
    size = float(np.ptp(piece.vertices, axis=0).max())
    edges = set()
    for face, normal, offset in zip(
        piece.faces, piece.face_normals, piece.face_offsets, strict=True
    ):
        ring = piece.vertices[list(face)]
        assert np.abs(ring @ normal - offset).max() <= 2e-7 * size
        turns = np.cross(np.roll(ring, -1, axis=0) - ring, np.roll(ring, -2, axis=0) - ring)
        assert (turns @ normal > 0).all(), "a face is not convex and counter-clockwise"
        edges |= set(zip(face, (*face[1:], face[0]), strict=True))
    assert (piece.vertices @ piece.face_normals.T <= piece.face_offsets + 2e-7 * size).all()
    assert {(b, a) for a, b in edges} == edges
    assert len(piece.vertices) - len(edges) // 2 + len(piece.faces) == 2
    assert len(piece.labels) == len(piece.faces)


def test_box_faces_come_in_the_stated_order() -> None:
    """A box's faces are +x, -x, +y, -y, +z, -z, with offsets of the two corners."""
    piece = box([-1, -2, -3], [4, 5, 6])
    assert_sound(piece)
    assert piece.labels == ("+x", "-x", "+y", "-y", "+z", "-z")
    np.testing.assert_array_equal(
        piece.face_normals,
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]],
    )
    np.testing.assert_array_equal(piece.face_offsets, [4, 1, 5, 2, 6, 3])
    assert piece.is_box


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_hulls_are_closed_convex_and_counter_clockwise(
    size: float, random_hull: RandomHull
) -> None:
    """Every hull satisfies Euler's formula, has convex counter-clockwise faces and contains all."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        assert_sound(random_hull(rng, size))


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_hull_of_a_grid_in_any_pose_is_a_box(size: float, random_pose: RandomPose) -> None:
    """Points inside, on faces and on edges vanish; a turned box is recognised as one."""
    rng = np.random.default_rng(2)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3), axis=-1).reshape(-1, 3)
    for _ in range(5):
        sides = rng.uniform(0.2, 2.0, size=3) * size
        piece = hull(random_pose(rng, 3 * size).apply(grid * sides))
        assert_sound(piece)
        assert (len(piece.vertices), len(piece.faces), len(piece.edge_directions)) == (8, 6, 3)
        assert piece.is_box


def test_sheared_box_is_no_box() -> None:
    """A parallelepiped with one slanted side is not taken for a box."""
    corners = np.array(box([0, 0, 0], [1, 1, 1]).vertices)
    corners[:, 0] += 1e-4 * corners[:, 2]
    piece = hull(corners)
    assert len(piece.faces) == 6
    assert not piece.is_box


def test_single_precision_cylinder_keeps_its_26_faces() -> None:
    """Rounding to float32, as mesh files do, does not break the caps into slivers."""
    angle = np.arange(24) * 2 * np.pi / 24
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = [np.column_stack([ring, np.full(24, z)]) for z in (0.1, 1.3)]
    turned = Pose.from_quaternion([0.3, 0.2, 0.1], [1, 2, 3, 4]).apply(np.concatenate(points))
    piece = hull(turned.astype(np.float32))
    assert_sound(piece)
    assert (len(piece.faces), len(piece.vertices)) == (26, 48)


def test_hull_does_not_depend_on_the_order_of_points(random_hull: RandomHull) -> None:
    """Shuffling the points changes neither the faces' order nor their planes."""
    rng = np.random.default_rng(3)
    first = random_hull(rng, 1.0)
    second = hull(rng.permutation(first.vertices))
    np.testing.assert_allclose(first.face_normals, second.face_normals, atol=1e-12)
    np.testing.assert_allclose(first.face_offsets, second.face_offsets, atol=1e-12)


def test_shifted_moves_vertices_and_planes_together() -> None:
    """A shifted body is the same shape elsewhere."""
    body = shifted(Body((box([0, 0, 0], [1, 2, 3]), hull(np.eye(4, 3)))), [5.0, -1.0, 2.0])
    for piece in body.pieces:
        assert_sound(piece)
    np.testing.assert_allclose(body.vertices.min(axis=0), [5, -1, 2])
    assert body.diagonal == pytest.approx(np.sqrt(14))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: box([0, 0, 0], [1, 0, 1]), "positive"),
        (lambda: box([0, 0, 0], [1, -1, 1]), "positive"),
        (lambda: box([0, 0, 0], [1, np.nan, 1]), "finite"),
        (lambda: box([0, 0], [1, 1]), "3 numbers"),
        (lambda: hull([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), "at least 4"),
        (lambda: hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), "one plane"),
        (lambda: hull(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1e-7]])), "one plane"),
        (lambda: hull([[1, 1, 1]] * 5), "coincide"),
        (lambda: hull([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3]]), "one plane"),
        (lambda: hull(np.array([[0, 0, 0], [1, 0, np.inf], [0, 1, 0], [0, 0, 1]])), "point 1"),
        (lambda: hull([[0, 0], [1, 0], [0, 1], [1, 1]]), "3 numbers"),
    ],
)
def test_unusable_shapes_are_refused(make: Callable[[], ConvexPiece], message: str) -> None:
    """Flat, empty or not finite shapes raise an error that says so."""
    with pytest.raises(GeometryError, match=message):
        make()
