from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.geometry.collision import Scene
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import PlacedPiece, gap
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.surface import placements

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]
RandomPose = Callable[[np.random.Generator, float], Pose]
TOUCHING = 1e-5  # of D: the conventions' contact tolerance
EXACT, COARSE = 1e-9, 1e-6  # of D: the conventions' tolerances for boxes and for hulls
SIZES = [1e-3, 1.0, 1e3]
UPRIGHT = Pose(np.eye(3), np.zeros(3))


def edges_of(piece: ConvexPiece) -> Array:
    """Return the corners' numbers (e, 2) of every edge."""
    pairs = {
        (min(a, b), max(a, b))
        for face in piece.faces
        for a, b in zip(face, (*face[1:], face[0]), strict=True)
    }
    return np.array(sorted(pairs), dtype=np.float64)


def distance_by_edges(piece: ConvexPiece, points: Array) -> Array:
    """Distance from points outside to a polyhedron: the faces they project into, else the edges."""
    edges = edges_of(piece).astype(int)
    tail = piece.vertices[edges[:, 0]]
    along = piece.vertices[edges[:, 1]] - tail
    t = ((points[:, None] - tail) * along).sum(-1) / (along**2).sum(-1)
    nearest = tail + np.clip(t, 0, 1)[..., None] * along
    distance = np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1)
    heights = points @ piece.face_normals.T - piece.face_offsets
    top = heights.argmax(axis=1)
    feet = points - heights.max(axis=1)[:, None] * piece.face_normals[top]
    slack = 1e-12 * np.ptp(piece.vertices)
    over = (feet @ piece.face_normals.T - piece.face_offsets).max(axis=1) <= slack
    result: Array = np.where(over, heights.max(axis=1), distance)
    return result


def random_contact(rng: np.random.Generator, a: ConvexPiece, b: ConvexPiece) -> Pose:
    """Return a pose at which ``a`` touches ``b``: slid along the normal of their gap to zero."""
    pose = Pose.from_quaternion(b.vertices.mean(axis=0), rng.normal(size=4))
    step = rng.normal(size=3)
    step /= np.linalg.norm(step)
    here = PlacedPiece(a, pose)
    differences = (b.vertices[:, None] - here.vertices[None]).reshape(-1, 3)
    far = Pose(pose.rotation, pose.position + step * (differences @ step).max() * 0.9)
    for _ in range(60):
        found = gap(PlacedPiece(a, far), PlacedPiece(b))
        far = Pose(far.rotation, far.position - found.width * found.normal)
        if abs(found.width) < 1e-15 * np.ptp(a.vertices):
            break
    return far


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kinds", ["box box", "hull box", "box hull", "hull hull"])
def test_object_may_touch_but_not_penetrate(
    size: float, kinds: str, random_hull: RandomHull, random_pose: RandomPose
) -> None:
    """Bodies pushed together to exact touching are free; 3 tolerances deeper they are not."""
    rng = np.random.default_rng(10)
    cases = 0
    for _ in range(40):
        a, b = (
            random_hull(rng, size) if kind == "hull" else random_box(rng, size, random_pose)
            for kind in kinds.split()
        )
        pose = random_contact(rng, a, b)
        found = gap(PlacedPiece(a, pose), PlacedPiece(b))
        D = Body((a,)).diagonal
        if abs(found.width) > 1e-12 * D:
            continue  # sliding to contact went round a corner
        cases += 1
        scene = Scene(Body((a,)), [Body((b,))], floor=False)
        tolerance = TOUCHING * D
        for depth, free in ((0.0, True), (0.3, True), (3.0, False)):
            there = Pose(pose.rotation, pose.position - depth * tolerance * found.normal)
            assert scene.object_free(there) == free, (depth, found)
    assert cases >= 25


def random_box(rng: np.random.Generator, size: float, random_pose: RandomPose) -> ConvexPiece:
    half = rng.uniform(0.3, 1.5, size=3) * size
    piece = hull(random_pose(rng, size).apply(box(-half, half).vertices))
    assert piece.is_box
    return piece


@pytest.mark.parametrize("reach", [1.0, 30.0, 1000.0])
def test_object_free_agrees_with_the_separating_axes(reach: float, random_hull: RandomHull) -> None:
    """FCL's clear cases agree with the exact gap, also for obstacles far larger than the object."""
    rng = np.random.default_rng(11)
    outcomes = []
    for _ in range(30):
        a, b = random_hull(rng, 0.5), random_hull(rng, reach)
        scene = Scene(Body((a,)), [Body((b,))], floor=False)
        for _ in range(10):
            face = int(rng.integers(len(b.faces)))
            ring = b.vertices[list(b.faces[face])]
            spot = rng.dirichlet(np.ones(len(ring))) @ ring
            spot = spot + b.face_normals[face] * rng.uniform(-0.5, 2.0)
            pose = Pose.from_quaternion(spot, rng.normal(size=4))
            width = gap(PlacedPiece(a, pose), PlacedPiece(b)).width
            assert scene.object_free(pose) == (width >= -TOUCHING * Body((a,)).diagonal)
            outcomes.append(width > 0)
    assert 0.1 < np.mean(outcomes) < 0.9


@pytest.mark.parametrize("size", SIZES)
def test_floor_is_exact(size: float) -> None:
    """A box standing, tilted or on a corner may touch the floor, not lie 3 tolerances below."""
    rng = np.random.default_rng(12)
    body = Body((box(np.array([-1, -2, -3]) * size, np.array([1, 2, 3]) * size),))
    scene = Scene(body, [], floor=True)
    for quaternion in [[1, 0, 0, 0], [1, 0.3, 0, 0], *rng.normal(size=(20, 4))]:
        flat = Pose.from_quaternion([0, 0, 0], quaternion)
        low = flat.apply(body.vertices)[:, 2].min()
        for depth, free in ((0.0, True), (3 * TOUCHING * body.diagonal, False)):
            assert scene.object_free(Pose(flat.rotation, np.array([0, 0, -low - depth]))) == free


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("reach", [0.5, 30.0])
@pytest.mark.parametrize("kind", ["box", "hull"])
def test_fingertip_may_touch_but_not_penetrate(
    size: float, reach: float, kind: str, random_hull: RandomHull, random_pose: RandomPose
) -> None:
    """Fingertips touching an edge or corner of an obstacle are free, 3 tolerances deeper not."""
    rng = np.random.default_rng(13)
    body = Body((box([-size] * 3, [size] * 3),))
    tolerance = (EXACT if kind == "box" else COARSE) * body.diagonal
    radius = 0.4 * size
    for _ in range(8):
        extent = reach * size
        piece = random_hull(rng, extent) if kind == "hull" else random_box(rng, extent, random_pose)
        scene = Scene(body, [Body((piece,))], floor=False)
        spots, outward = points_on_edges(rng, piece, 60)
        for depth, free in ((0.0, True), (3 * tolerance, False)):
            centres = spots + (radius - depth) * outward
            found = scene.free_placements(UPRIGHT, centres, radius, np.zeros(60, dtype=np.int64))
            assert (found == free).all()


def points_on_edges(
    rng: np.random.Generator, piece: ConvexPiece, count: int
) -> tuple[Array, Array]:
    """Return points on edges, a fifth of them corners, and unit normals to the body there."""
    edges = edges_of(piece).astype(int)[rng.integers(len(edges_of(piece)), size=count)]
    t = np.where(np.arange(count) % 5, rng.uniform(size=count), 0.0)[:, None]
    spots = (1 - t) * piece.vertices[edges[:, 0]] + t * piece.vertices[edges[:, 1]]
    meeting = np.array([
        [k for k, face in enumerate(piece.faces) if set(edge) <= set(face)]
        for edge in edges.tolist()
    ])  # fmt: skip
    w = rng.uniform(0.05, 0.95, size=(count, 1))
    outward = w * piece.face_normals[meeting[:, 0]] + (1 - w) * piece.face_normals[meeting[:, 1]]
    return spots, outward / np.linalg.norm(outward, axis=1, keepdims=True)


@pytest.mark.parametrize("kind", ["box", "hull"])
def test_free_placements_agree_with_distances(
    kind: str, random_hull: RandomHull, random_pose: RandomPose
) -> None:
    """Every placement's verdict equals comparing the exact distance of its centre, any pose."""
    rng = np.random.default_rng(14)
    body = Body((box([-1, -1, -2], [1, 1, 2]),))
    table = placements(body, (5, 5))
    centres = table.centres(0.3)
    shares = []
    for _ in range(20):
        pieces = [
            random_hull(rng, 0.7) if kind == "hull" else random_box(rng, 1.0, random_pose)
            for _ in range(3)
        ]
        scene = Scene(body, [Body(tuple(pieces))], floor=True)
        pose = random_pose(rng, 1.0)
        world = pose.apply(centres)
        want = world[:, 2] >= 0.3
        for piece in pieces:
            outside = (world @ piece.face_normals.T - piece.face_offsets).max(axis=1) > 0
            want &= outside & (distance_by_edges(piece, world) >= 0.3)
        found = scene.free_placements(pose, centres, 0.3, table.piece)
        np.testing.assert_array_equal(found, want)
        shares.append(found.mean())
    assert 0.1 < np.mean(shares) < 0.9


def test_fingertips_in_a_corner_of_the_object_are_blocked() -> None:
    """On an L of two boxes, a tip may touch the other box but not reach into it."""
    body = Body((box([0, 0, 0], [4, 1, 1]), box([0, 1, 0], [1, 4, 1])))
    table = placements(body, (8, 1))
    radius = 0.75
    found = Scene(body, [], floor=False).free_placements(
        UPRIGHT, table.centres(radius), radius, table.piece
    )
    inner = (table.piece == 0) & (table.normals[:, 1] == -1)
    for row in np.flatnonzero(inner):
        assert found[row] == (table.points[row, 0] - 1 >= radius)
    assert np.count_nonzero(inner & found) == 5
    assert np.count_nonzero(inner & ~found) == 1
    assert found[table.normals[:, 2] != 0].all()


@pytest.mark.parametrize("size", SIZES)
def test_fingertips_may_touch_each_other(size: float) -> None:
    """Tips of unequal radii are apart down to touching and refused 3e-9 D below."""
    body = Body((box([-size] * 3, [size] * 3),))
    scene = Scene(body, [], floor=False)
    rng = np.random.default_rng(15)
    first = rng.normal(size=(40, 3)) * size
    steps = rng.normal(size=(40, 3))
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    for depth, apart in ((0.0, True), (3e-9 * body.diagonal, False)):
        second = first + (0.7 * size - depth) * steps
        found = scene.tips_apart(first, 0.3 * size, second, 0.4 * size)
        assert found.shape == (40, 40)
        assert (np.diag(found) == apart).all()
    between = np.linalg.norm(first[:, None] - first[None], axis=-1)
    np.testing.assert_array_equal(
        scene.tips_apart(first, 0.3 * size, first, 0.4 * size), between >= 0.7 * size
    )


def test_far_obstacles_and_no_placements() -> None:
    """No obstacles, no placements and obstacles out of reach are all fine."""
    body = Body((box([-1] * 3, [1] * 3),))
    scene = Scene(body, [Body((box([50] * 3, [60] * 3),))], floor=False)
    assert scene.object_free(UPRIGHT)
    none = np.zeros((0, 3))
    assert scene.free_placements(UPRIGHT, none, 1.0, np.zeros(0, dtype=np.int64)).shape == (0,)
    assert Scene(body, [], floor=False).object_free(UPRIGHT)
