"""Meshes: what is refused, exact convex pieces, faces of the true surface, mass properties."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from gm_ompl.arrays import Array
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.decomposition import solid
from gm_ompl.geometry.mesh import read_triangles
from gm_ompl.geometry.solids import Body, box, hull, mass_properties, volume
from gm_ompl.geometry.surface import face_areas, placements
from gm_ompl.geometry.triangles import TriangleMesh, checked, planar_faces
from gm_ompl.geometry.usage import MAX_FACES, Usage, shape_of

PROFILE = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 5), (0, 5))
"""An L in x and z."""


def l_bracket(depth: float = 3.0) -> tuple[Array, Array]:
    """Vertices and faces of the L drawn out along y."""
    n = len(PROFILE)
    vertices = [(x, y, z) for y in (0.0, depth) for x, z in PROFILE]
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [*caps, *((n + a, n + c, n + b) for a, b, c in caps)]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, n + j, j), (i, n + i, n + j)]
    return np.array(vertices), np.array(faces)


def from_trimesh(mesh: trimesh.Trimesh) -> TriangleMesh:
    return checked(mesh.vertices, mesh.faces)


def read_mesh(path: Path, scale: float = 1.0) -> TriangleMesh:
    """Return the one body in a file, as it is."""
    (mesh,) = shape_of(*read_triangles(path, scale), Usage()).meshes
    return mesh


def ring(sections: int) -> TriangleMesh:
    return from_trimesh(trimesh.creation.annulus(r_min=1, r_max=2, height=1, sections=sections))


def test_an_l_bracket_is_two_boxes() -> None:
    """One dent, one cut: two boxes that share the corner's wall, and eight faces outside."""
    body = solid(checked(*l_bracket()))
    assert len(body.pieces) == 2
    assert all(piece.is_box for piece in body.pieces)
    assert len(body.surface) == 8
    assert sorted(round(face.area, 9) for face in body.surface) == [3, 3, 8, 8, 9, 12, 12, 15]


MESHES: dict[str, Callable[[], TriangleMesh]] = {
    "l": lambda: checked(*l_bracket()),
    "ring of 12": lambda: ring(12),
    "ring of 40": lambda: ring(40),
    "ball": lambda: from_trimesh(trimesh.creation.icosphere(subdivisions=2)),
    "cone": lambda: from_trimesh(trimesh.creation.cone(1.0, 3.0, sections=17)),
}


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_pieces_fill_the_mesh_exactly(name: str, scale: float) -> None:
    """Volume, centre of mass and inertia of the pieces are the mesh's own (trimesh, by surface).

    Random points lie in a piece exactly where they lie in the mesh (by winding number).
    """
    mesh = MESHES[name]()
    mesh = checked(mesh.vertices * scale, mesh.faces)
    body = solid(mesh)
    found = mass_properties(body, 2.0)
    other = trimesh.Trimesh(mesh.vertices / scale, mesh.faces, process=False)
    other.density = 2.0 / other.volume
    assert found.volume == pytest.approx(other.volume * scale**3, rel=1e-9)
    np.testing.assert_allclose(found.centre, other.center_mass * scale, atol=1e-9 * scale)
    np.testing.assert_allclose(found.inertia, other.moment_inertia * scale**2, atol=1e-8 * scale**2)
    assert sum(volume(piece) for piece in body.pieces) == pytest.approx(mesh.volume, rel=1e-9)
    rng = np.random.default_rng(1)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = rng.uniform(low, high, size=(200, 3))
    in_piece = np.zeros(len(points), dtype=bool)
    for piece in body.pieces:
        in_piece |= (points @ piece.face_normals.T <= piece.face_offsets).all(axis=1)
    np.testing.assert_array_equal(in_piece, _winding(points, mesh) > 0.5)


def _winding(points: Array, mesh: TriangleMesh) -> Array:
    numbers = []
    for point in points:
        a, b, c = (mesh.corners - point).transpose(1, 0, 2)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        numbers.append(2.0 * np.arctan2(top, under).sum() / (4.0 * np.pi))
    return np.array(numbers)


def test_a_convex_mesh_is_the_hull_of_its_vertices() -> None:
    """Triangles, vertices on edges and in faces leave no trace: one piece, the hull's faces."""
    mesh = from_trimesh(trimesh.creation.box([4, 4, 10]).subdivide())
    body, plain = solid(mesh), hull(trimesh.creation.box([4, 4, 10]).vertices)
    assert len(body.pieces) == 1
    assert body.surface == ()
    assert body.pieces[0].is_box
    np.testing.assert_allclose(body.pieces[0].face_normals, plain.face_normals, atol=1e-12)
    np.testing.assert_allclose(body.pieces[0].face_offsets, plain.face_offsets, atol=1e-12)


def test_placements_lie_on_the_true_surface() -> None:
    """On the L: none on the wall between its pieces, none off an L-shaped face, all on the skin."""
    body = solid(checked(*l_bracket()))
    table = placements(body, (8, 10))
    corner = (table.points[:, 0] > 1.0 + 1e-9) & (table.points[:, 2] > 1.0 + 1e-9)
    assert not corner.any()
    outside = table.points - 1e-3 * table.normals
    for piece in body.pieces:
        inside = (outside @ piece.face_normals.T < piece.face_offsets).all(axis=1)
        assert not inside.any()
    for row, point in zip(table.piece, table.points, strict=True):
        heights = body.pieces[row].face_normals @ point - body.pieces[row].face_offsets
        assert abs(heights.max()) < 1e-12
    ends = [k for k, face in enumerate(body.surface) if abs(face.normal[1]) > 0.5]
    for k in ends:  # 4 x 5 cells of area 0.25 in a face of area 8: 8 x 10 cells of area 1/4
        assert (table.face == k).sum() == 32


def test_holes_and_rims_are_kept_clear() -> None:
    """On a ring's flat face no placement is in the hole or nearer to a rim than the margin."""
    body = solid(ring(24))
    top = [str(k) for k, face in enumerate(body.surface) if face.normal[2] > 0.5]
    assert len(top) == 1
    counts = []
    for margin in (0.0, 0.1, 0.3, 0.49, 0.51):
        table = placements(body, (21, 21), top, margin)
        radius = np.linalg.norm(table.points[:, :2], axis=1)
        narrow = np.cos(np.pi / 24)
        if len(table):
            assert radius.min() >= narrow + margin - 1e-9
            assert radius.max() <= 2.0 - margin * narrow + 1e-9
        counts.append(len(table))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 200 and counts[-1] == 0


def test_a_seam_between_flush_pieces_has_its_placements_once() -> None:
    """Two boxes side by side: a grid point on their seam is one placement, not none and not two."""
    body = Body((box([0, 0, 0], [3, 1, 1]), box([1, 1, 0], [4, 2, 1])))
    table = placements(body, (3, 1))
    assert len(np.unique(table.points.round(9), axis=0)) == len(table)
    flush = Body((box([-2, -1, -1], [0, 1, 1]), box([0, -1, -1], [2, 1, 1])))
    assert len(placements(flush, (2, 2))) == 2 * 4 * 4 + 2 * 4


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_files_are_read_and_scaled(suffix: str, tmp_path: Path) -> None:
    """Each format gives the same body, at the scenario's scale."""
    vertices, faces = l_bracket()
    file = tmp_path / f"part.{suffix}"
    trimesh.Trimesh(vertices, faces).export(file)
    body = solid(read_mesh(file, 0.001))
    assert len(body.pieces) == 2
    assert mass_properties(body, 1.0).volume == pytest.approx(24e-9, rel=1e-6)


def test_an_inside_out_file_is_turned_and_numbers_are_not(tmp_path: Path) -> None:
    """A file's triangles may face inward, all of them or some; vertices and faces must be right."""
    vertices, faces = l_bracket()
    mixed = faces.copy()
    mixed[::2] = mixed[::2, ::-1]
    for k, wrong in enumerate((faces[:, ::-1], mixed)):
        file = tmp_path / f"part{k}.ply"
        trimesh.Trimesh(vertices, wrong, process=False).export(file)
        assert read_mesh(file).volume == pytest.approx(24.0)
        with pytest.raises(GeometryError, match="inside out" if k == 0 else "not watertight"):
            checked(vertices, wrong)


def test_unusable_meshes_are_refused_with_the_reason(tmp_path: Path) -> None:
    """Open, flat, crossing, overlapping: the message says which."""
    vertices, faces = l_bracket()
    with pytest.raises(GeometryError, match="not watertight: 3 of its edges"):
        checked(vertices, faces[1:])
    with pytest.raises(GeometryError, match="encloses no volume"):
        checked(vertices * [1, 1, 0], faces)
    with pytest.raises(GeometryError, match="must be finite"):
        checked(vertices * np.nan, faces)
    with pytest.raises(GeometryError, match="shared by more than two"):
        checked(vertices, np.concatenate([faces, faces]))
    twice = np.concatenate([vertices, vertices + 0.5])
    with pytest.raises(GeometryError, match=r"crosses itself, or parts of it overlap"):
        solid(checked(twice, np.concatenate([faces, faces + len(vertices)])))
    with pytest.raises(GeometryError, match="no such file"):
        read_mesh(tmp_path / "missing.stl")
    (tmp_path / "text.stl").write_text("this is no mesh")
    with pytest.raises(GeometryError, match=r"text\.stl"):
        read_mesh(tmp_path / "text.stl")
    (tmp_path / "empty.obj").write_text("")
    with pytest.raises(GeometryError, match=r"empty\.obj"):
        read_mesh(tmp_path / "empty.obj")


def test_too_much_detail_is_refused_with_the_limit(tmp_path: Path) -> None:
    """More triangles or more convex pieces than planning can bear are refused, with the number."""
    fine = trimesh.creation.icosphere(subdivisions=5)
    assert len(fine.faces) > MAX_FACES
    fine.export(tmp_path / "fine.ply")
    with pytest.raises(GeometryError, match=rf"20480 triangles; at most {MAX_FACES}"):
        read_mesh(tmp_path / "fine.ply")
    with pytest.raises(GeometryError, match="72 convex pieces; at most 64"):
        solid(ring(72))
    with pytest.raises(GeometryError, match="not convex along 300 planes"):
        solid(ring(300))


def test_faces_tile_the_surface() -> None:
    """The planar faces' areas add up to the surface's, holes left out."""
    for make in MESHES.values():
        mesh = make()
        want = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).area
        assert sum(face.area for face in planar_faces(mesh)) == pytest.approx(want, rel=1e-9)
        assert face_areas(solid(mesh)).sum() == pytest.approx(want, rel=1e-9)


def test_a_file_that_is_no_mesh_and_one_without_end(tmp_path: Path) -> None:
    """Random bytes are no STL, whatever decoder is missing; huge coordinates are refused."""
    garbage = tmp_path / "part.stl"
    garbage.write_bytes(bytes(range(128, 256)) * 4)
    with pytest.raises(GeometryError, match=r"part\.stl: is no STL mesh that can be read"):
        read_mesh(garbage)
    far = tmp_path / "far.obj"
    corners = "v 0 0 0\nv 1e5 0 0\nv 0 1e5 0\nv 0 0 1e5\n"
    far.write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    with pytest.raises(
        GeometryError, match=r"far\.obj: a coordinate is no number, or beyond 1e\+15"
    ):
        read_mesh(far, scale=1e12)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply"])
@pytest.mark.parametrize("size", [1e-3, 1.0, 2.0**40, 1e14, 1e30, 1e37])
def test_a_file_in_whatever_unit_is_the_same_body(suffix: str, size: float, tmp_path: Path) -> None:
    """Coordinates so large that trimesh would merge them all are merged right, or refused."""
    path, cube = tmp_path / f"cube{suffix}", trimesh.creation.box((1.0, 1.0, 1.0))
    cube.apply_scale(size)
    cube.export(path)
    mesh = read_mesh(path, scale=1.0 / size)
    assert (len(mesh.vertices), len(mesh.faces)) == (8, 12)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([1.0, 1.0, 1.0], rel=1e-6)
    if size > 1e15:
        with pytest.raises(GeometryError, match="beyond"):
            read_mesh(path)
