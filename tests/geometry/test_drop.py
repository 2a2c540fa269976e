"""Bodies lowered until they touch, against casting rays and crossing edges one by one."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.separation import TOUCHING, below, lowered, supports
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull


def height_over(piece: ConvexPiece, x: float, y: float, sign: float) -> float | None:
    """Return the highest (sign 1) or lowest (-1) point of a piece over (x, y), or None."""
    low, high = -np.inf, np.inf
    for normal, offset in zip(piece.face_normals, piece.face_offsets, strict=True):
        rest = offset - normal[0] * x - normal[1] * y
        if normal[2] > 0:
            high = min(high, rest / normal[2])
        elif normal[2] < 0:
            low = max(low, rest / normal[2])
        elif rest < 0:
            return None
    if low > high:
        return None
    return float(high if sign > 0 else low)


def edges(piece: ConvexPiece) -> list[tuple[Array, Array]]:
    starts, spans = piece.edge_ends
    return list(zip(starts, starts + spans, strict=True))


def fall(a: ConvexPiece, b: ConvexPiece) -> float | None:
    """Return the rise at which ``a`` stands on ``b``: the largest over all pairs of features."""
    rises = []
    for x, y, z in a.vertices:
        top = height_over(b, x, y, 1.0)
        rises += [] if top is None else [top - z]
    for x, y, z in b.vertices:
        bottom = height_over(a, x, y, -1.0)
        rises += [] if bottom is None else [z - bottom]
    for p, q in edges(a):
        for r, s in edges(b):
            matrix = np.stack([(q - p)[:2], -(s - r)[:2]], axis=1)
            if abs(np.linalg.det(matrix)) < 1e-9:
                continue
            t, u = np.linalg.solve(matrix, (r - p)[:2])
            if 0 <= t <= 1 and 0 <= u <= 1:
                rises.append(float((r + u * (s - r) - p - t * (q - p))[2]))
    return max(rises, default=None)


def random_piece(rng: np.random.Generator, size: float) -> ConvexPiece:
    return hull(rng.normal(size=(int(rng.integers(5, 14)), 3)) * size)


@pytest.mark.parametrize("seed", range(60))
def test_a_fall_ends_where_features_meet(seed: int) -> None:
    """Hulls onto hulls, floor or no floor: the height is exact to 1e-12."""
    rng = np.random.default_rng(seed)
    pieces = tuple(random_piece(rng, 1.0) for _ in range(int(rng.integers(1, 3))))
    below_it = [random_piece(rng, 2.0) for _ in range(int(rng.integers(1, 4)))]
    turn = rotation_about(rng.normal(size=3), rng.uniform(0, 3))
    pose = Pose(turn, np.array([*rng.normal(size=2), rng.normal() * 5]))
    placed = [hull(pose.apply(piece.vertices)) for piece in pieces]
    floor = bool(seed % 2)
    falls = [fall(a, b) for a in placed for b in below_it]
    if floor:
        falls.append(-min(float(piece.vertices[:, 2].min()) for piece in placed))
    met = [rise for rise in falls if rise is not None]
    obstacles = [(str(k), Body((piece,))) for k, piece in enumerate(below_it)]
    found = lowered(supports(Body(pieces), obstacles, floor, pose, TOUCHING), 1.0)
    if not met:
        assert found is None
    else:
        assert found == pytest.approx(max(met), abs=1e-12)


def test_what_is_flush_beside_the_fall_does_not_hold() -> None:
    """A wall that touches, or overlaps by less than the tolerance, is passed; by more it holds."""
    body = Body((box([-1, -1, -1], [1, 1, 1]),))
    for overlap, height in ((0.0, 1.0), (1e-6, 1.0), (-1e-6, 1.0), (1e-3, 6.0)):
        wall = Body((box([1 - overlap, -9, 0], [3, 9, 5]),))
        found = supports(body, [("wall", wall)], True, Pose.from_yaw([0, 0, 7]), TOUCHING)
        rise = lowered(found, body.diagonal)
        assert rise is not None
        assert 7 + rise == pytest.approx(height, abs=1e-12)


def test_a_shelf_holds_from_above_and_floats_over_what_is_below() -> None:
    """From far above the board stops the fall; from under it the floor is what lies below."""
    body = Body((box([-1, -1, -1], [1, 1, 1]),))
    board = Body((box([-5, -5, 5], [5, 5, 6]),))
    found = supports(body, [("board", board)], True, Pose.from_yaw([0, 0, 2]), TOUCHING)
    assert lowered(found, body.diagonal) == pytest.approx(5.0)
    under = below(found)
    assert under is not None
    assert (under.name, under.stands) == ("the floor", -1.0)
