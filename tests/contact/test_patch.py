from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull, HalfspaceIntersection

from gm_ompl.arrays import Array
from gm_ompl.contact.patch import contact_patch
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, gap
from gm_ompl.geometry.solids import ConvexPiece, box

Touching = Callable[[np.random.Generator, str, float], Any]
TOL = 1e-7


def mismatch(first: Array, second: Array) -> float:
    """Hausdorff distance of two point sets."""
    apart = np.linalg.norm(first[:, None] - second[None], axis=-1)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))


def coal_patch(coal: ModuleType, pair: Any, press: float) -> Array:
    """The patch's points as coal finds them after pressing the bodies together a little."""

    def shape(piece: ConvexPiece) -> Any:
        points = coal.StdVec_Vec3s()
        for vertex in piece.vertices:
            points.append(np.array(vertex))
        return coal.Convex.convexHull(points, True, "Qt")

    request = coal.CollisionRequest()
    request.num_max_contacts = 1
    request.gjk_tolerance = request.epa_tolerance = 1e-9
    request.gjk_max_iterations = request.epa_max_iterations = 500
    at = coal.Transform3s(np.array(pair.pose.rotation), pair.pose.position - press * pair.normal)
    base = coal.Transform3s(np.array(pair.base.rotation), np.array(pair.base.position))
    upper, lower, result = shape(pair.upper), shape(pair.lower), coal.CollisionResult()
    assert coal.collide(upper, at, lower, base, request, result)
    patches = coal.ContactPatchResult()
    ask = coal.ContactPatchRequest(1, 6, 1e-4)
    coal.computeContactPatch(upper, at, lower, base, result, ask, patches)
    patch = patches.getContactPatch(0)
    return np.array([patch.getPoint(i) for i in range(patch.size())])


@pytest.mark.parametrize(
    "kinds", ["face face", "edge face", "vertex face", "face edge", "face vertex"]
)
def test_patches_agree_with_coal(coal: ModuleType, touching: Touching, kinds: str) -> None:
    """400 random contacts of each kind: the same points as coal's, to its tolerance of 1e-4."""
    rng = np.random.default_rng(20)
    sizes = set()
    for _ in range(400):
        pair = touching(rng, kinds, 1.0)
        patch = contact_patch(
            PlacedPiece(pair.upper, pair.pose), PlacedPiece(pair.lower, pair.base), TOL
        )
        assert patch is not None
        np.testing.assert_allclose(patch.normal, pair.normal, atol=1e-9)
        assert mismatch(patch.points, coal_patch(coal, pair, 1e-6)) < 1e-4
        sizes.add(len(patch.points))
    want = {"edge": {2}, "vertex": {1}}
    odd = [want[kind] for kind in kinds.split() if kind != "face"]
    assert sizes == odd[0] if odd else sizes >= {3, 4, 5, 6}


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_faces_agree_with_qhull(touching: Touching, size: float) -> None:
    """Face on face: the vertices of the intersection of both faces' half planes, to 1e-9 D."""
    rng = np.random.default_rng(21)
    for _ in range(150):
        pair = touching(rng, "face face", size)
        a, b = PlacedPiece(pair.upper, pair.pose), PlacedPiece(pair.lower, pair.base)
        patch = contact_patch(a, b, TOL * size)
        assert patch is not None
        inside = patch.points.mean(axis=0)
        # Cut both bodies by planes a little to either side of the contact plane.
        planes = np.vstack([
            np.column_stack([body.normals, -body.offsets + body.normals @ inside])
            for body in (a, b)
        ])  # fmt: skip
        across = np.abs(planes[:, :3] @ patch.normal) < 1 - 1e-9
        flat = planes[across, :3] - np.outer(planes[across, :3] @ patch.normal, patch.normal)
        axes = np.linalg.svd(patch.normal[None])[2][1:]
        reach = np.linalg.norm(flat, axis=1, keepdims=True)
        halves = np.hstack([flat @ axes.T / reach, planes[across, 3:] / reach / size])
        cut = HalfspaceIntersection(halves, np.zeros(2)).intersections
        cut = cut[ConvexHull(cut).vertices]
        assert mismatch((patch.points - inside) @ axes.T / size, cut) < 1e-6
        ring = np.roll(patch.points, -1, axis=0) - patch.points
        turns = np.cross(ring, np.roll(ring, -1, axis=0)) @ patch.normal
        assert (turns > 0).all(), "vertices go counter-clockwise about the normal"


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_crossed_edges_touch_in_one_point(touching: Touching, size: float) -> None:
    """Edge across edge: one point on both edges, the normal their cross product."""
    rng = np.random.default_rng(22)
    for _ in range(300):
        pair = touching(rng, "edge edge", size)
        a, b = PlacedPiece(pair.upper, pair.pose), PlacedPiece(pair.lower, pair.base)
        if gap(a, b).width < -1e-12 * size:
            continue  # the bodies overlap elsewhere: no contact was made
        patch = contact_patch(a, b, TOL * size)
        assert patch is not None
        assert patch.points.shape == (1, 3)
        np.testing.assert_allclose(patch.normal, pair.normal, atol=1e-9)
        for body in (a, b):
            depths = np.sort(body.offsets - body.normals @ patch.points[0])
            assert np.abs(depths[:2]).max() < 1e-9 * size, "on two faces of each body"


@pytest.mark.parametrize("kinds", ["vertex vertex", "vertex edge", "edge vertex"])
def test_vertices_on_vertices_and_edges_carry_no_force(touching: Touching, kinds: str) -> None:
    """A corner on a corner or on an edge has no normal: no patch."""
    rng = np.random.default_rng(23)
    for _ in range(200):
        pair = touching(rng, kinds, 1.0)
        a, b = PlacedPiece(pair.upper, pair.pose), PlacedPiece(pair.lower, pair.base)
        assert contact_patch(a, b, TOL) is None


CUBE = box([-1, -1, -1], [1, 1, 1])


@pytest.mark.parametrize(
    ("position", "points"),
    [
        ([2, 0, 2], None),  # along an edge
        ([2, 2, 2], None),  # corner to corner
        ([2, 0, 0], 4),  # side by side
        ([0.5, 0.5, 2], 4),
        ([2 - 1e-9, 0, 2], None),  # overlap thinner than the tolerance
        ([0, 0, 2 + 2e-7], None),  # apart
        ([0, 0, 2 + 0.5e-7], 4),
        ([0, 0, 2 - 0.5e-7], 4),
        ([0, 0, 2 - 2e-7], None),  # too deep
    ],
)
def test_aligned_cubes(position: list[float], points: int | None) -> None:
    """Two equal cubes: faces touch in 4 points, edges along each other and corners in none."""
    patch = contact_patch(
        PlacedPiece(CUBE, Pose(np.eye(3), np.array(position, dtype=float))), PlacedPiece(CUBE), TOL
    )
    assert (None if patch is None else len(patch.points)) == points


def test_edges_along_each_other_carry_no_force() -> None:
    """A tilted cube's edge on the rim of another's top has no normal; a little inwards it has."""
    tilted = Pose(np.eye(3), np.array([0.0, 0.0, 2.0])).turned([1, 0, 1], [0, 1, 0], 0.5)
    on_rim = contact_patch(PlacedPiece(CUBE, tilted), PlacedPiece(CUBE), TOL)
    assert on_rim is None
    inside = Pose(tilted.rotation, tilted.position - [1e-3, 0, 0])
    patch = contact_patch(PlacedPiece(CUBE, inside), PlacedPiece(CUBE), TOL)
    assert patch is not None
    assert mismatch(patch.points, np.array([[0.999, -1, 1], [0.999, 1, 1]])) < 1e-9


@pytest.mark.parametrize("gap_width", [-0.9e-7, 0.0, 0.9e-7])
def test_patches_hold_within_the_tolerance(touching: Touching, gap_width: float) -> None:
    """A gap of up to 1e-7 D either way leaves number, place and normal of the points."""
    rng = np.random.default_rng(24)
    for kinds in ("face face", "edge face", "vertex face", "face vertex"):
        for _ in range(40):
            pair = touching(rng, kinds, 1.0)
            moved = Pose(pair.pose.rotation, pair.pose.position + gap_width * pair.normal)
            b = PlacedPiece(pair.lower, pair.base)
            here, there = (
                contact_patch(PlacedPiece(pair.upper, p), b, TOL) for p in (pair.pose, moved)
            )
            assert here is not None
            assert there is not None
            assert len(here.points) == len(there.points)
            assert mismatch(here.points, there.points) < 1e-6
            np.testing.assert_allclose(here.normal, there.normal, atol=1e-9)
