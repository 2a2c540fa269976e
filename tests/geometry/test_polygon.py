from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gm_ompl.geometry.polygon import Point2, clip, convex_hull, depth_inside, plane_basis

SQUARE: list[Point2] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def area(polygon: list[Point2]) -> float:
    x, y = np.array(polygon).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_hull_agrees_with_qhull() -> None:
    """Random points: the same corners as Qhull's, counter-clockwise."""
    rng = np.random.default_rng(30)
    for _ in range(100):
        points = rng.normal(size=(int(rng.integers(4, 40)), 2))
        found = convex_hull([(x, y) for x, y in points.tolist()], 1e-12)
        assert set(found) == set(ConvexHull(points).vertices.tolist())
        assert area([tuple(points[i]) for i in found]) > 0


@pytest.mark.parametrize("seed", range(20))
def test_noise_changes_no_corner(seed: int) -> None:
    """A square with doubled corners, points on its sides and noise keeps four corners."""
    rng = np.random.default_rng(seed)
    sides = [(0.5, 0.0), (1.0, 0.3), (0.2, 1.0), (0.0, 0.9)]
    noisy = np.array([*SQUARE, *SQUARE, *sides, (0.4, 0.4)]) + rng.normal(size=(13, 2)) * 1e-10
    found = convex_hull([(x, y) for x, y in noisy.tolist()], 1e-8)
    assert sorted(i % 4 for i in found) == [0, 1, 2, 3]
    assert max(found) < 8


def test_points_and_segments_are_told_apart() -> None:
    """All within the tolerance of a point, or of a segment: one or two corners."""
    assert len(convex_hull([(1.0, 1.0)], 1e-9)) == 1
    assert len(convex_hull([(1.0, 1.0), (1.0 + 1e-10, 1.0), (1.0, 1.0 - 1e-10)], 1e-9)) == 1
    line = [(0.0, 0.0), (2.0, 2.0), (1.0, 1.0 + 1e-10), (1.5, 1.5)]
    assert sorted(convex_hull(line, 1e-9)) == [0, 1]
    assert len(convex_hull([*line, (1.0, 1.1)], 1e-9)) == 3


def test_clip_keeps_what_lies_inside() -> None:
    """Clipping keeps the overlap of polygons, segments and points, also along shared sides."""
    shifted = [(x + 0.25, y - 0.5) for x, y in SQUARE]
    assert area(clip(shifted, SQUARE)) == pytest.approx(0.375)
    assert area(clip(SQUARE, SQUARE)) == pytest.approx(1.0)
    assert clip([(0.5, 0.5), (0.5, 3.0)], SQUARE) == [(0.5, 0.5), (0.5, 1.0)]
    assert clip([(0.5, -1.0), (0.5, 3.0)], SQUARE) == [(0.5, 0.0), (0.5, 1.0)]
    assert clip([(2.0, 0.0), (3.0, 1.0)], SQUARE) == []
    assert depth_inside(SQUARE, (0.5, 0.9)) == pytest.approx(0.1)
    assert depth_inside(SQUARE, (0.5, 1.5)) == pytest.approx(-0.5)


def test_plane_basis_is_right_handed() -> None:
    """e1, e2 and the normal are orthonormal and right-handed, for axes and at random."""
    rng = np.random.default_rng(31)
    for normal in [*np.eye(3), *-np.eye(3), *rng.normal(size=(50, 3))]:
        n = normal / np.linalg.norm(normal)
        frame = np.vstack([plane_basis(n), n])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(frame) == pytest.approx(1.0)
