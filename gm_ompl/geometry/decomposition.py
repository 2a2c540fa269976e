"""Exact convex pieces of a closed mesh: its convex hull, cut along the planes of its dents.

The union of the pieces is the mesh itself, up to the tolerance that also merges coplanar
triangles. Approximate decompositions would not do: where a piece bulges out of the surface,
touching bodies penetrate, and where it falls short they do not touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.facets import COPLANAR, facets_of, neighbours_of
from gm_ompl.geometry.solids import Body, ConvexPiece, hull, volume
from gm_ompl.geometry.triangles import TriangleMesh, planar_faces
from gm_ompl.geometry.welding import inside

MAX_DENTS = 256
"""More planes than this along which a mesh is not convex are refused: each is a cut."""

MAX_PIECES = 64
"""More convex pieces than this are refused: every collision query asks each of them."""

KEPT = 8
"""Bodies that are kept."""

SAME_VOLUME = 1e-6
"""The pieces' volumes add up to the mesh's within this, relatively."""


def solid(mesh: TriangleMesh) -> Body:
    """Return the body that a mesh encloses: convex pieces, and the faces of its true surface.

    A convex mesh is one piece, the same as the hull of its vertices. The last few meshes are not
    cut again: one is cut when it is read, to see whether it can be, and is then used.

    Raises:
        GeometryError: the mesh crosses itself, is thinner somewhere than the tolerance, or falls
            into too many pieces.
    """
    return _solid(mesh.vertices.tobytes(), mesh.faces.tobytes())


@lru_cache(maxsize=KEPT)
def _solid(vertices: bytes, faces: bytes) -> Body:
    rows = np.frombuffer(faces, dtype=np.int64).reshape(-1, 3)
    return _cut_up(TriangleMesh(np.frombuffer(vertices).reshape(-1, 3), rows))


def _cut_up(mesh: TriangleMesh) -> Body:
    whole = hull(mesh.vertices)
    dents = _dents(mesh, whole)
    if not dents:
        _check_volume(mesh, (whole,))
        return Body((whole,))
    if dents > MAX_DENTS:
        raise GeometryError(
            f"the mesh is not convex along {dents} planes; at most {MAX_DENTS} are cut"
        )
    faces = planar_faces(mesh)
    planes = [(f.normal, float((f.triangles @ f.normal).mean())) for f in faces]
    fragments = [
        Fragment(triangle, number)
        for number, face in enumerate(faces)
        for triangle in face.triangles
    ]
    root = _Cell(whole, [f for f in fragments if not _on_hull(f.corners, whole, mesh.extent)])
    try:
        cells = _leaves(root, planes, mesh)
    except GeometryError as error:
        raise GeometryError(f"the mesh is too thin somewhere to be cut: {error}") from None
    pieces = _merged(
        [cell for cell in cells if inside(cell.vertices.mean(axis=0), mesh.corners)], mesh.extent
    )
    if len(pieces) > MAX_PIECES:
        raise GeometryError(
            f"the mesh falls into {len(pieces)} convex pieces; at most {MAX_PIECES} are taken"
        )
    _check_volume(mesh, pieces)
    return Body(pieces, faces)


@dataclass(frozen=True, eq=False)
class Fragment:
    """A convex part (k, 3) of a triangle of the surface, and the number of its plane."""

    corners: Array
    plane: int


@dataclass(frozen=True, eq=False)
class _Cell:
    """A convex part of space, and what of the surface runs through its inside."""

    piece: ConvexPiece
    fragments: list[Fragment]


def _dents(mesh: TriangleMesh, whole: ConvexPiece) -> int:
    """Return the number of facets that do not lie on the hull."""
    inner = np.array([not _on_hull(corners, whole, mesh.extent) for corners in mesh.corners])
    if not inner.any():
        return 0
    facets = facets_of(mesh.corners, neighbours_of(mesh.faces), COPLANAR * mesh.extent)
    return sum(bool(inner[rows].any()) for rows in facets)


def _on_hull(corners: Array, whole: ConvexPiece, extent: float) -> bool:
    heights = corners @ whole.face_normals.T - whole.face_offsets
    return bool((heights >= -COPLANAR * extent).all(axis=0).any())


def _leaves(
    root: _Cell, planes: list[tuple[Array, float]], mesh: TriangleMesh
) -> list[ConvexPiece]:
    """Return cells through whose inside no surface runs; together they fill the hull."""
    waiting, leaves = [root], []
    while waiting:
        limits.check()
        cell = waiting.pop()
        if not cell.fragments:
            leaves.append(cell.piece)
            continue
        if len(leaves) + len(waiting) > 8 * MAX_DENTS:
            raise GeometryError(f"more than {8 * MAX_DENTS} parts")
        waiting.extend(_cut(cell, *planes[_best_plane(cell, planes, mesh.extent)], mesh))
    return leaves


def _best_plane(cell: _Cell, planes: list[tuple[Array, float]], extent: float) -> int:
    """Return the plane that splits the fewest fragments; of equals the one with most of them."""
    numbers = sorted({fragment.plane for fragment in cell.fragments})
    corners = np.concatenate([fragment.corners for fragment in cell.fragments])
    ends = np.cumsum([0, *(len(fragment.corners) for fragment in cell.fragments)])[:-1]
    best: tuple[int, int, int] | None = None
    for number in numbers:
        normal, offset = planes[number]
        heights = corners @ normal - offset
        above = np.maximum.reduceat(heights, ends) > COPLANAR * extent
        below = np.minimum.reduceat(heights, ends) < -COPLANAR * extent
        score = (int((above & below).sum()), -int((~above & ~below).sum()), number)
        best = score if best is None or score < best else best
    assert best is not None
    return best[2]


def _cut(cell: _Cell, normal: Array, offset: float, mesh: TriangleMesh) -> list[_Cell]:
    """Return the cell's two parts, or the cell without the fragments that lie in the plane."""
    tolerance = COPLANAR * mesh.extent
    sides = [_half(cell.fragments, sign * normal, sign * offset, tolerance) for sign in (1, -1)]
    heights = cell.piece.vertices @ normal - offset
    if heights.max() <= tolerance or heights.min() >= -tolerance:
        # The plane only touches the cell: what lies in it is on the cell's surface.
        return [_Cell(cell.piece, sides[0] + sides[1])]
    on = np.abs(heights) <= tolerance
    crossings = _snapped(_crossings(cell.piece, normal, offset, tolerance), mesh)
    parts = []
    for side, fragments in zip((heights < 0.0, heights > 0.0), sides, strict=True):
        corners = np.concatenate([cell.piece.vertices[side | on], crossings])
        parts.append(_Cell(hull(corners), fragments))
    return parts


def _crossings(piece: ConvexPiece, normal: Array, offset: float, tolerance: float) -> Array:
    """Return where the piece's edges cross a plane, (k, 3)."""
    starts, spans = piece.edge_ends
    before, after = starts @ normal - offset, (starts + spans) @ normal - offset
    low, high = np.minimum(before, after), np.maximum(before, after)
    cut = (low < -tolerance) & (high > tolerance)
    share = before[cut] / (before[cut] - after[cut])
    points: Array = starts[cut] + share[:, None] * spans[cut]
    return points


def _snapped(points: Array, mesh: TriangleMesh) -> Array:
    """Return ``points``, those at a vertex of the mesh moved onto it."""
    moved = points.copy()
    for i, point in enumerate(points):
        gaps = np.linalg.norm(mesh.vertices - point, axis=1)
        nearest = int(gaps.argmin())
        if gaps[nearest] <= 2.0 * COPLANAR * mesh.extent:
            moved[i] = mesh.vertices[nearest]
    return moved


def _half(
    fragments: list[Fragment], normal: Array, offset: float, tolerance: float
) -> list[Fragment]:
    """Return the parts of ``fragments`` below a plane; what lies in it belongs to neither side."""
    kept = []
    for fragment in fragments:
        heights = fragment.corners @ normal - offset
        if heights.min() >= -tolerance:
            continue
        if heights.max() <= tolerance:
            kept.append(fragment)
            continue
        corners = []
        for i, (point, h) in enumerate(zip(fragment.corners, heights, strict=True)):
            j = (i + 1) % len(heights)
            if h <= 0.0:
                corners.append(point)
            if h * heights[j] < 0.0:
                t = h / (h - heights[j])
                corners.append(point + t * (fragment.corners[j] - point))
        if len(corners) >= 3:
            kept.append(Fragment(np.array(corners), fragment.plane))
    return kept


def _merged(pieces: list[ConvexPiece], extent: float) -> tuple[ConvexPiece, ...]:
    """Return the pieces, neighbours joined where their union is convex."""
    left = pieces.copy()
    i = 0
    while i < len(left):
        for j in range(i + 1, len(left)):
            limits.check()
            joined = _joined(left[i], left[j], extent)
            if joined is not None:
                left[i] = joined
                del left[j]
                i = -1  # a larger piece may suit others now
                break
        i += 1
    return tuple(left)


def _joined(a: ConvexPiece, b: ConvexPiece, extent: float) -> ConvexPiece | None:
    """Return the union of two pieces that do not overlap, or None where it is not convex."""
    opposite = a.face_normals @ b.face_normals.T <= -1.0 + COPLANAR
    same = np.abs(a.face_offsets[:, None] + b.face_offsets) <= 2.0 * COPLANAR * extent
    if not (opposite & same).any():
        return None
    union = hull(np.concatenate([a.vertices, b.vertices]))
    apart = volume(a) + volume(b)
    return union if volume(union) <= apart * (1.0 + 1e-7) else None


def _check_volume(mesh: TriangleMesh, pieces: tuple[ConvexPiece, ...]) -> None:
    total = sum(volume(piece) for piece in pieces)
    if abs(total - mesh.volume) > SAME_VOLUME * abs(mesh.volume):
        raise GeometryError(
            f"the mesh crosses itself, or parts of it overlap: its triangles enclose "
            f"{mesh.volume:.6g}, its convex pieces {total:.6g}"
        )
