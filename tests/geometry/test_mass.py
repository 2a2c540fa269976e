from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece, at_centre_of_mass, box, hull, mass_properties

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]
RandomPose = Callable[[np.random.Generator, float], Pose]


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_box_against_the_textbook(scale: float) -> None:
    """A box a x b x c has J = M/12 diag(b^2 + c^2, a^2 + c^2, a^2 + b^2) about its middle."""
    a, b, c = np.array([5.0, 10.0, 4.0]) * scale
    offset = np.array([7.0, -3.0, 2.0]) * scale
    found = mass_properties(Body((box(offset, offset + np.array([a, b, c])),)), 2.0)
    assert found.volume == pytest.approx(a * b * c, rel=1e-13)
    np.testing.assert_allclose(found.centre, offset + np.array([a, b, c]) / 2, rtol=1e-13)
    want = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * 2.0 / 12.0
    np.testing.assert_allclose(found.inertia, want, rtol=1e-12, atol=1e-13 * want.max())


def test_right_tetrahedron_against_the_textbook() -> None:
    """The corner tetrahedron of the unit cube: V = 1/6, J_xx = 3/40 M, J_xy = +1/80 M.

    From the integrals of x^2 (1/60) and x y (1/120) over it, moved to the centre (1/4, 1/4, 1/4).
    """
    found = mass_properties(Body((hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),)), 1.0)
    assert found.volume == pytest.approx(1 / 6, rel=1e-13)
    np.testing.assert_allclose(found.centre, [0.25] * 3, rtol=1e-13)
    want = (3 / 40 - 1 / 80) * np.eye(3) + np.full((3, 3), 1 / 80)
    np.testing.assert_allclose(found.inertia, want, rtol=1e-12)


def test_pieces_add_up_to_the_whole() -> None:
    """An L of two boxes has the mass properties of its 3 unit cubes summed by hand."""
    body = Body((box([0, 0, 0], [2, 1, 1]), box([0, 1, 0], [1, 2, 1])))
    found = mass_properties(body, 3.0)
    cubes = np.array([[0.5, 0.5, 0.5], [1.5, 0.5, 0.5], [0.5, 1.5, 0.5]])
    arms = cubes - cubes.mean(axis=0)
    want = sum(np.eye(3) / 6 + (r @ r) * np.eye(3) - np.outer(r, r) for r in arms)
    assert found.volume == pytest.approx(3.0)
    np.testing.assert_allclose(found.centre, cubes.mean(axis=0))
    np.testing.assert_allclose(found.inertia, want, atol=1e-13)


def test_inertia_turns_with_the_body(random_hull: RandomHull, random_pose: RandomPose) -> None:
    """Moving a body by (R, p) moves its centre along and turns J into R J R^T."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        piece, pose = random_hull(rng, 1.0), random_pose(rng, 2.0)
        here = mass_properties(Body((piece,)), 1.5)
        there = mass_properties(Body((hull(pose.apply(piece.vertices)),)), 1.5)
        assert there.volume == pytest.approx(here.volume, rel=1e-10)
        np.testing.assert_allclose(there.centre, pose.apply(here.centre), atol=1e-10)
        turned = pose.rotation @ here.inertia @ pose.rotation.T
        np.testing.assert_allclose(there.inertia, turned, atol=1e-10)


def test_second_opinion_by_sampling(random_hull: RandomHull) -> None:
    """Volume and centre agree with counting random points inside, to sampling error."""
    rng = np.random.default_rng(5)
    piece = random_hull(rng, 1.0)
    low, high = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
    points = rng.uniform(low, high, size=(200_000, 3))
    inside = points[(points @ piece.face_normals.T <= piece.face_offsets).all(axis=1)]
    found = mass_properties(Body((piece,)), 1.0)
    assert found.volume == pytest.approx(len(inside) / len(points) * np.prod(high - low), rel=0.01)
    np.testing.assert_allclose(found.centre, inside.mean(axis=0), atol=0.02)
    np.testing.assert_allclose(
        np.trace(found.inertia) / 2 * np.eye(3) - found.inertia, np.cov(inside.T), atol=0.02
    )


def test_centred_body_has_its_centre_of_mass_at_the_origin(random_hull: RandomHull) -> None:
    """Shifting to the centre of mass leaves it at the origin and reports where it was."""
    body = Body((random_hull(np.random.default_rng(6), 2.0),))
    centred, centre = at_centre_of_mass(body)
    np.testing.assert_allclose(mass_properties(centred, 1.0).centre, 0.0, atol=1e-12)
    np.testing.assert_allclose(centred.vertices + centre, body.vertices, atol=1e-12)
