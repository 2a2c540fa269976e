"""Shapes: from a scenario's box, hull, mesh or pieces to bodies; meshes read into the scenario."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TypeVar

import numpy as np

from gm_ompl.errors import GeometryError
from gm_ompl.geometry.decomposition import solid
from gm_ompl.geometry.separation import PlacedPiece, penetrates
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.triangles import checked
from gm_ompl.scenario.document import Document, Path
from gm_ompl.scenario.fields import BoxModel, MeshModel, ObstacleModel, PartModel, Shape
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel

OVERLAP = 1e-6
"""Pieces that overlap by more than this, relative to D, are refused: mass would count twice."""

AnyShape = TypeVar("AnyShape", Shape, ObstacleModel)


def body_of(shape: Shape | ObstacleModel) -> Body:
    """Return the body that ``shape`` describes; meshes are already read.

    Raises:
        GeometryError: the shape is degenerate, or its pieces overlap.
    """
    if isinstance(shape.box, BoxModel):
        return Body((box(shape.box.min, shape.box.max),))
    if shape.box is not None:
        half = np.array(shape.box) / 2
        return Body((box(-half, half),))
    if shape.hull is not None:
        return Body((hull(np.array(shape.hull)),))
    if isinstance(shape.mesh, MeshModel):
        return solid(checked(shape.mesh.vertices, shape.mesh.faces))
    assert shape.pieces is not None
    return _joined([_piece(part) for part in shape.pieces])


def _piece(part: PartModel) -> ConvexPiece:
    if part.box is not None:
        return box(part.box.min, part.box.max)
    return hull(np.array(part.hull))


def _joined(pieces: list[ConvexPiece]) -> Body:
    body = Body(tuple(pieces))
    for i, piece in enumerate(pieces):
        for j in range(i):
            if penetrates(PlacedPiece(piece), PlacedPiece(pieces[j]), OVERLAP * body.diagonal):
                raise GeometryError(
                    f"pieces {j} and {i} overlap; they may touch, so that volume counts once"
                )
    return body


def with_meshes(model: ScenarioModel, document: Document) -> ScenarioModel:
    """Return ``model`` with every mesh file replaced by the mesh in it.

    Raises:
        ScenarioError: one line per file that is no usable mesh.
    """
    notes = Notes(document)
    shape = _read(model.object.shape, ("object", "shape"), notes)
    obstacles = {
        name: _read(obstacle, ("environment", "obstacles", name), notes)
        for name, obstacle in model.environment.obstacles.items()
    }
    notes.stop()
    return model.model_copy(
        update={
            "object": model.object.model_copy(update={"shape": shape}),
            "environment": model.environment.model_copy(update={"obstacles": obstacles}),
        }
    )


def _read(shape: AnyShape, path: Path, notes: Notes) -> AnyShape:
    if not isinstance(shape.mesh, str):
        return shape
    folder, name, scale = notes.document.folder, shape.mesh, shape.scale or 1.0
    mesh = notes.attempt((*path, "mesh"), lambda: _mesh(folder, name, scale))
    return shape.model_copy(update={"mesh": mesh, "scale": None})


def _mesh(folder: FilePath | None, name: str, scale: float) -> MeshModel:
    from gm_ompl.geometry.mesh import read_mesh  # trimesh loads on demand

    if folder is None:
        raise GeometryError(
            f"no file {name!r} can be looked up from here; give the mesh's vertices and faces"
        )
    found = read_mesh(folder / name, scale)
    return MeshModel(
        vertices=tuple(map(tuple, found.vertices.tolist())),
        faces=tuple(map(tuple, found.faces.tolist())),
    )
