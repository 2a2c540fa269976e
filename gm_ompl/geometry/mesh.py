"""Meshes read from files, simplified, decomposed: the door to trimesh and coacd."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import GeometryError, MissingExtraError, did_you_mean
from gm_ompl.geometry.welding import resolution
from gm_ompl.reading import Kind, check_ordinary

if TYPE_CHECKING:
    import trimesh

SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb")
"""The formats that are read."""

MAX_BYTES = 50 * 1024 * 1024
"""Larger files are refused unread: no mesh within ``MAX_FACES`` needs so much."""


def _hint(path: Path) -> str:
    near = [other.name for other in path.parent.glob("*") if other.suffix.lower() in SUFFIXES]
    return f"; the path counts from the scenario's folder{did_you_mean(path.name, near)}"


KIND = Kind("mesh", ", ".join(SUFFIXES), MAX_BYTES, GeometryError, _hint)

FILE_BYTES = 12.0
"""What a byte of a mesh file takes while it is read."""

FARTHEST = 1e15
"""No coordinate lies farther out: volumes and moments must stay finite."""

CONCAVITY = (0.05, 0.1, 0.2, 0.4)
"""What coacd may leave unfilled, relative to the extent: finer first, coarser for fewer pieces."""

LISTENING_EVERY = 0.05
"""How long nothing is heard while coacd is at work [s]."""

_Made = TypeVar("_Made")

BEFORE_CUTTING = 2000
"""A mesh is simplified to so many triangles before coacd, whose time grows with them, cuts it."""

MAX_CORNERS = 48
"""Corners of one of coacd's pieces: every collision query asks each of them."""


def read_triangles(path: Path, scale: float = 1.0) -> tuple[Array, IntArray, float]:
    """Return what is in a mesh file: vertices (v, 3), triangles (t, 3), and its resolution.

    Vertices and resolution are times ``scale``.

    Raises:
        GeometryError: the file is missing, is no mesh, or holds numbers beyond all measure.
    """
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix.lower(), SUFFIXES)
        raise GeometryError(
            f"a mesh file ends in {', '.join(SUFFIXES)}, not {path.name!r}{hint}; save it as one"
        )
    check_ordinary(path, KIND)
    size = path.stat().st_size
    limits.claim(FILE_BYTES * size, f"{path}: a mesh file of {size:,} bytes", "simplify it")
    mesh = _loaded(path)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    if not float(np.abs(vertices).max()) * scale <= FARTHEST:
        raise GeometryError(
            f"{path}: a coordinate is no number, or beyond {FARTHEST:g} in the scenario's units "
            "(scale counted in); give a smaller scale, or save the mesh anew"
        )
    finest = resolution(vertices, single=path.suffix.lower() == ".glb")
    return vertices * scale, np.asarray(mesh.faces, dtype=np.int64), finest * scale


def _loaded(path: Path) -> trimesh.Trimesh:
    import trimesh  # heavy, and needed only where a scenario names a mesh file

    kind = path.suffix[1:].upper()
    advice = f"save it as {kind} anew, or name the format by its ending"
    try:
        mesh = trimesh.load_mesh(str(path), file_type=path.suffix[1:].lower(), process=False)
        if isinstance(mesh, trimesh.Scene):
            mesh = mesh.to_mesh()
    except ImportError:  # what is no text, trimesh would guess the encoding of
        raise GeometryError(
            f"{path}: is no {kind} mesh that can be read: neither its binary nor its text form; "
            f"{advice}"
        ) from None
    except Exception as error:  # trimesh raises whatever its parsers raise
        reason = " ".join(str(error).split()) or type(error).__name__
        raise GeometryError(
            f"{path}: is no {kind} mesh that can be read: {reason}; {advice}"
        ) from None
    empty = not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces)
    if empty and kind == "STL":  # it can hold nothing else
        raise GeometryError(
            f"{path}: is no {kind} mesh that can be read: no triangle is found in it; {advice}; "
            "save a surface (no points or lines)"
        )
    if empty:
        raise GeometryError(
            f"{path}: holds no triangles; save a surface (no points, lines or empty scene)"
        )
    return mesh


def turned_outward(vertices: Array, faces: IntArray) -> IntArray:
    """Return the triangles turned so that they face outward, where that can be told."""
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    with np.errstate(all="ignore"):  # trimesh divides by the volume, which may be 0
        if not mesh.is_volume:
            mesh.fix_normals()
    return np.asarray(mesh.faces, dtype=np.int64)


def simplified(vertices: Array, faces: IntArray, most: int) -> tuple[Array, IntArray]:
    """Return a surface of at most ``most`` triangles near the given one (quadric error).

    Raises:
        MissingExtraError: fast-simplification is not installed.
    """
    if len(faces) <= most:
        return vertices, faces
    try:
        import fast_simplification
    except ImportError:
        raise MissingExtraError("fast-simplification", "meshes") from None
    middle = vertices.mean(axis=0)
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    points, triangles = fast_simplification.simplify(
        (vertices - middle) / size, faces.astype(np.int32), target_count=most
    )
    return np.asarray(points, dtype=np.float64) * size + middle, triangles.astype(np.int64)


def _awaited(work: Callable[[], _Made]) -> _Made:
    """Return what work without the interpreter's lock comes to; the limits in force are heard.

    Work that is given up goes on in the background, until it is done or the process ends.

    Raises:
        LimitError: a limit in force is reached.
    """
    made: list[_Made] = []
    failed: list[Exception] = []

    def carry_out() -> None:
        try:
            made.append(work())
        except Exception as error:
            failed.append(error)

    thread = threading.Thread(target=carry_out, daemon=True)
    thread.start()
    while thread.is_alive():
        limits.check()
        thread.join(LISTENING_EVERY)
    if failed:
        raise failed[0]
    return made[0]


def convex_parts(vertices: Array, faces: IntArray, most: int, closed: bool) -> list[Array]:
    """Return the corners of convex pieces that fill a surface about.

    A surface that is not closed is taken as a thin wall. The concavity allowed is the first of
    ``CONCAVITY`` that leads to at most ``most`` pieces.

    Raises:
        MissingExtraError: coacd is not installed.
        GeometryError: it finds no pieces.
    """
    try:
        import coacd
    except ImportError:
        raise MissingExtraError("coacd", "meshes") from None
    coacd.set_log_level("off")
    parts: list[Array] = []
    for threshold in CONCAVITY:
        settings: dict[str, Any] = {
            "threshold": threshold, "merge": False, "seed": 0,
            "preprocess_mode": "off" if closed else "on", "preprocess_resolution": 60,
            "resolution": 500, "mcts_nodes": 8, "mcts_iterations": 30, "mcts_max_depth": 2,
            "decimate": True, "max_ch_vertex": MAX_CORNERS,
        }  # fmt: skip
        found = _awaited(partial(coacd.run_coacd, coacd.Mesh(vertices, faces), **settings))
        parts = [np.asarray(corners, dtype=np.float64) for corners, _ in found]
        if 0 < len(parts) <= most:
            return parts
    raise GeometryError(f"coacd finds {len(parts)} convex pieces; at most {most} are taken")
