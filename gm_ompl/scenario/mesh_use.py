"""A scenario's mesh or hull -> the shape that is used, as a plan file keeps it."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import GeometryError
from gm_ompl.geometry.hulls import clean_hull, flattened, hull_mesh
from gm_ompl.geometry.triangles import EMPTY, TriangleMesh
from gm_ompl.geometry.usage import NOTHING, Usage, Used
from gm_ompl.geometry.welding import resolution
from gm_ompl.scenario.fields import MeshModel, MeshUse, ObstacleModel, PartModel, Shape
from gm_ompl.scenario.motions import rotation_matrix

AnyShape = TypeVar("AnyShape", Shape, ObstacleModel)

KEYS = ("scale", "frame", "weld", "flat", "bodies", "simplify", "convex")

PLATE = 1e-3
"""The thickness offered for what has none, relative to its longest side."""


def resolved_shape(shape: AnyShape, folder: Path | None) -> AnyShape:
    """Return the shape with its mesh read and used as its keys say, its hull's facets plane.

    Args:
        shape: with a ``mesh`` or a ``hull``.
        folder: where files are looked for.

    Raises:
        GeometryError: no usable mesh; with what would make it one.
    """
    if shape.mesh is None:
        return _resolved_hull(shape)
    vertices, faces, finest = _triangles(shape, folder)
    try:
        used = _used(shape, vertices, faces, finest)
    except GeometryError as error:
        if _has_volume(vertices):
            raise
        raise GeometryError(f"{error}; {_plate(shape, vertices)}") from None
    if _as_given(shape, used):
        return shape
    change: dict[str, object] = dict.fromkeys(KEYS)
    change["deviation"] = used.deviation
    if len(used.meshes) == 1:
        change["mesh"] = _model(used.meshes[0])
    else:
        change["mesh"] = None
        change["pieces"] = tuple(PartModel(hull=_points(mesh.vertices)) for mesh in used.meshes)
    return shape.model_copy(update=change)


def usage_of(shape: MeshUse) -> Usage:
    """Return how the shape's keys want its mesh used."""
    return Usage(
        weld=shape.weld,
        flat=shape.flat,
        bodies=shape.bodies,
        convex=shape.convex or "exact",
        simplify=shape.simplify,
        turn=isinstance(shape.mesh, str),
    )


def _used(shape: MeshUse, vertices: Array, faces: IntArray, finest: float) -> Used:
    from gm_ompl.geometry.remedies import shape_or_remedy

    return shape_or_remedy(vertices, faces, finest, usage_of(shape))


def _triangles(shape: MeshUse, folder: Path | None) -> tuple[Array, IntArray, float]:
    """Return vertices and triangles in the scenario's units and axes, and their resolution."""
    if isinstance(shape.mesh, MeshModel):
        vertices, faces = np.array(shape.mesh.vertices), np.array(shape.mesh.faces)
        if faces.max() >= len(vertices):
            raise GeometryError(
                f"a face names vertex {faces.max()}; there are {len(vertices)}, numbered from 0"
            )
        finest = resolution(vertices)
    else:
        from gm_ompl.geometry.mesh import read_triangles  # trimesh loads on demand

        assert shape.mesh is not None
        if folder is None:
            raise GeometryError(
                f"no file {shape.mesh!r} can be looked up from here; "
                "give the mesh's vertices and faces"
            )
        vertices, faces, finest = read_triangles(folder / shape.mesh, shape.scale or 1.0)
    if shape.frame is not None:
        vertices = vertices @ rotation_matrix(shape.frame.rotation).T
    return vertices, faces, finest


def _has_volume(vertices: Array) -> bool:
    try:
        whole = hull_mesh(vertices)
    except GeometryError:
        return False
    return whole.volume > EMPTY * whole.extent**3


def _plate(shape: AnyShape, vertices: Array) -> str:
    """Return the box to write instead of a mesh that is flat."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    size = np.maximum(high - low, PLATE * (high - low).max())
    if not size.all():
        return "give a mesh with a volume"
    if isinstance(shape, Shape):
        return f"give it a thickness: {{box: [{', '.join(f'{side:.6g}' for side in size)}]}}"
    corners = [
        ", ".join(f"{value:.6g}" for value in (low + high + sign * size) / 2) for sign in (-1, 1)
    ]
    return f"give it a thickness: {{box: {{min: [{corners[0]}], max: [{corners[1]}]}}}}"


def _resolved_hull(shape: AnyShape) -> AnyShape:
    points = np.array(shape.hull)
    flat = resolution(points) if shape.flat is None else shape.flat
    try:
        mesh = hull_mesh(points)
    except GeometryError as error:
        raise GeometryError(f"{error}; {_plate(shape, points)}") from None
    plane = flattened(mesh, flat)
    moved = float(np.linalg.norm(plane.vertices - mesh.vertices, axis=1).max())
    if moved <= NOTHING * mesh.extent:
        return shape.model_copy(update={"flat": None})
    corners = clean_hull(mesh, flat).vertices
    return shape.model_copy(update={"hull": _points(corners), "flat": None, "deviation": moved})


def _as_given(shape: MeshUse, used: Used) -> bool:
    """Whether a mesh in the scenario itself is used just as it stands there."""
    if not isinstance(shape.mesh, MeshModel) or any(getattr(shape, key) for key in KEYS):
        return False
    given, made = shape.mesh, used.meshes[0]
    return (
        len(used.meshes) == 1
        and np.array_equal(given.vertices, made.vertices)
        and np.array_equal(given.faces, made.faces)
    )


def _model(mesh: TriangleMesh) -> MeshModel:
    return MeshModel(vertices=_points(mesh.vertices), faces=tuple(map(tuple, mesh.faces.tolist())))


def _points(cloud: Array) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, cloud.tolist()))
