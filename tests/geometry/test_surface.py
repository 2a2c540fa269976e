from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.errors import GeometryError
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.surface import PlacementTable, placements

RandomHull = Callable[[np.random.Generator, float], ConvexPiece]


def as_set(table: PlacementTable) -> set[tuple[float, ...]]:
    rows = np.hstack([table.points, table.normals]).round(9) + 0.0
    return {tuple(row) for row in rows.tolist()}


def test_box_grid_follows_the_formula() -> None:
    """Rows go by face +x ... -z, then cell; coordinates are ((i + 1/2)/m * 2 - 1) half extents."""
    half = np.array([2.5, 5.0, 1.5])
    table = placements(Body((box(-half, half),)), (3, 4))
    row = 0
    for face, (axis, sign) in enumerate([(0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)]):
        u, v = (k for k in range(3) if k != axis)
        for i in range(3):
            for j in range(4):
                point = np.zeros(3)
                point[axis] = sign * half[axis]
                point[u] = ((i + 0.5) / 3 * 2 - 1) * half[u]
                point[v] = ((j + 0.5) / 4 * 2 - 1) * half[v]
                np.testing.assert_allclose(table.points[row], point, atol=1e-14)
                np.testing.assert_array_equal(table.normals[row], -sign * np.eye(3)[axis])
                assert table.face[row] == face
                assert table.cell[row].tolist() == [i, j]
                row += 1
    assert len(table) == row == 72
    assert table.find("-y", (2, 1)) == 3 * 12 + 9


def test_paper_grid_has_294_placements() -> None:
    """The paper's 7 x 7 grid on six faces."""
    assert len(placements(Body((box([-2, -2, -5], [2, 2, 5]),)), (7, 7))) == 294


@settings(max_examples=30, deadline=None)
@given(
    st.tuples(*[st.floats(0.1, 10.0)] * 3), st.integers(1, 6), st.integers(1, 6), st.integers(0, 99)
)
def test_box_given_as_hull_has_the_same_placements(
    half: tuple[float, float, float], m1: int, m2: int, seed: int
) -> None:
    """A box's corners in any order give the box's points and normals, also where m1 != m2."""
    whole = box([-h for h in half], half)
    shuffled = hull(np.random.default_rng(seed).permutation(whole.vertices))
    first, second = (placements(Body((piece,)), (m1, m2)) for piece in (whole, shuffled))
    assert second.labels == ("0", "1", "2", "3", "4", "5")
    assert as_set(first) == as_set(second)


def test_placements_lie_on_their_faces(random_hull: RandomHull) -> None:
    """On any hull, every placement is on its face's plane and in the body; normals point inward."""
    rng = np.random.default_rng(7)
    for _ in range(10):
        piece = random_hull(rng, 1.0)
        table = placements(Body((piece,)), (6, 5))
        heights = table.points @ piece.face_normals.T - piece.face_offsets
        assert heights.max() < 1e-8
        np.testing.assert_allclose(heights[np.arange(len(table)), table.face], 0, atol=1e-9)
        np.testing.assert_allclose(table.normals, -piece.face_normals[table.face])
        assert (np.diff(table.face * 30 + table.cell @ [5, 1]) > 0).all()


def test_triangle_keeps_the_cells_inside() -> None:
    """On a right triangle with legs 1, 10 of a 4 x 4 grid's centres satisfy x + y <= 1."""
    wedge = hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 5], [1, 0, 5], [0, 1, 5]])
    bottom = str(int(np.argmin(wedge.face_normals[:, 2])))
    table = placements(Body((wedge,)), (4, 4), [bottom])
    assert len(table) == 10
    assert (table.points[:, :2].sum(axis=1) <= 1 + 1e-9).all()
    np.testing.assert_allclose(table.points[table.cell.tolist().index([0, 0])], [0.125, 0.125, 0])


def test_rectangle_has_least_area() -> None:
    """The grid of a turned rectangular face is aligned with its sides, not with the axes."""
    turn = Pose.from_yaw([0, 0, 0], 0.4)
    piece = hull(turn.apply(box([-3, -1, -1], [3, 1, 1]).vertices))
    upright = Body((box([-3, -1, -1], [3, 1, 1]),))
    want = turn.apply(placements(upright, (5, 3), ["+z"]).points)
    top = str(int(np.argmax(piece.face_normals[:, 2])))
    np.testing.assert_allclose(placements(Body((piece,)), (5, 3), [top]).points, want, atol=1e-12)


def test_covered_placements_are_left_out() -> None:
    """Where two pieces of a body meet, neither has placements; elsewhere both keep theirs."""
    body = Body((box([0, 0, 0], [2, 2, 2]), box([2, 0, 0], [4, 1, 2])))
    table = placements(body, (4, 4))
    assert table.labels == tuple(str(k) for k in range(12))
    assert len(table) == 12 * 16 - 8 - 16
    buried = (np.abs(table.points[:, 0] - 2) < 1e-9) & (table.points[:, 1] < 1)
    assert not buried.any()
    assert set(table.piece.tolist()) == {0, 1}


def test_chosen_faces_keep_order_and_unknown_ones_are_refused() -> None:
    """Rows follow the body's face order; a wrong label is named with the valid ones."""
    body = Body((box([-1, -1, -1], [1, 1, 1]),))
    table = placements(body, (2, 2), ["+z", "+x"])
    assert table.face.tolist() == [0] * 4 + [4] * 4
    assert table.labels[4] == "+z"
    with pytest.raises(GeometryError, match=r"no face 'x'.*\+x, -x"):
        placements(body, (2, 2), ["x"])
    with pytest.raises(GeometryError, match="grid"):
        placements(body, (0, 2))
