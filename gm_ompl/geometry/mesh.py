"""Meshes read from files: the door to trimesh."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import GeometryError, did_you_mean
from gm_ompl.geometry.triangles import TriangleMesh, checked
from gm_ompl.reading import Kind, check_ordinary

SUFFIXES = (".stl", ".obj", ".ply")
"""The formats that are read."""

MAX_BYTES = 50 * 1024 * 1024
"""Larger files are refused unread: no mesh within ``MAX_FACES`` needs so much."""

KIND = Kind(
    "mesh", ", ".join(SUFFIXES), MAX_BYTES, GeometryError,
    lambda _: "; the path counts from the scenario's folder",
)  # fmt: skip

MAX_FACES = 20_000
"""A mesh with more triangles is refused: plan files carry every one of them."""

FARTHEST = 1e15
"""No coordinate lies farther out: volumes and moments must stay finite."""


LARGE = 1e6
"""Larger coordinates are shrunk to merge vertices: trimesh counts steps of 1e-8, in 64 bits."""


def read_mesh(path: Path, scale: float = 1.0) -> TriangleMesh:
    """Return the closed mesh in a file, its coordinates times ``scale``.

    Vertices that coincide are joined, and triangles are turned outward where they are not.

    Raises:
        GeometryError: the file is missing or no mesh, or the mesh encloses no volume.
    """
    _check_file(path)
    return checked(*_triangles(path, scale))


def _check_file(path: Path) -> None:
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix.lower(), SUFFIXES)
        raise GeometryError(f"a mesh file ends in {', '.join(SUFFIXES)}, not {path.name!r}{hint}")
    check_ordinary(path, KIND)


def _triangles(path: Path, scale: float) -> tuple[Array, IntArray]:
    """Return vertices (v, 3), scaled, and triangles (t, 3), outward where that can be told."""
    import trimesh  # heavy, and needed only where a scenario names a mesh file

    try:
        mesh = trimesh.load_mesh(str(path), file_type=path.suffix[1:].lower(), process=False)
    except ImportError:  # what is no text, trimesh would guess the encoding of
        kind = path.suffix[1:].upper()
        raise GeometryError(
            f"{path}: is no {kind} mesh that can be read: neither its binary nor its text form"
        ) from None
    except Exception as error:  # trimesh raises whatever its parsers raise
        reason = " ".join(str(error).split()) or type(error).__name__
        kind = path.suffix[1:].upper()
        raise GeometryError(f"{path}: is no {kind} mesh that can be read: {reason}") from None
    if isinstance(mesh, trimesh.Scene):
        mesh = mesh.to_mesh()
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise GeometryError(f"{path}: holds no triangles")
    if len(mesh.faces) > MAX_FACES:
        raise GeometryError(
            f"{path}: {len(mesh.faces)} triangles; at most {MAX_FACES} are taken, simplify the mesh"
        )
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    farthest = float(np.abs(vertices).max())
    if not farthest * scale <= FARTHEST:
        raise GeometryError(
            f"{path}: a coordinate is no number, or beyond {FARTHEST:g} in the scenario's units "
            "(scale counted in)"
        )
    shrunk = 2.0 ** max(0, math.frexp(farthest / LARGE)[1])  # a power of two rounds nothing
    mesh.vertices = vertices / shrunk
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if not mesh.is_volume:
        mesh.fix_normals()
    merged = np.asarray(mesh.vertices, dtype=np.float64) * shrunk * scale
    return merged, np.asarray(mesh.faces, dtype=np.int64)
