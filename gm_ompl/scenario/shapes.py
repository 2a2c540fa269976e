"""Shapes: from a scenario's box, hull, mesh or pieces to bodies; meshes read into the scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull
from gm_ompl.geometry.triangles import checked
from gm_ompl.scenario.document import Document, Path
from gm_ompl.scenario.fields import BoxModel, MeshModel, ObstacleModel, PartModel, Shape
from gm_ompl.scenario.messages import Notes
from gm_ompl.scenario.model import ScenarioModel

if TYPE_CHECKING:
    from gm_ompl.scenario.mesh_use import AnyShape


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
        from gm_ompl.geometry.decomposition import solid  # most shapes are boxes

        return solid(checked(shape.mesh.vertices, shape.mesh.faces))
    assert shape.pieces is not None
    pieces = tuple(_piece(part) for part in shape.pieces)
    if shape.deviation is None:
        from gm_ompl.geometry.usage import check_apart

        check_apart(pieces, "pieces")
    return Body(pieces)


def _piece(part: PartModel) -> ConvexPiece:
    if part.box is not None:
        return box(part.box.min, part.box.max)
    return hull(np.array(part.hull))


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
    if shape.deviation is not None or not (shape.mesh or shape.hull):
        return shape
    key = "mesh" if shape.mesh else "hull"
    from gm_ompl.scenario.mesh_use import resolved_shape

    made = notes.attempt((*path, key), lambda: resolved_shape(shape, notes.document.folder))
    return made or shape


def is_mesh(shape: Shape) -> bool:
    """Whether the shape comes from a mesh, and not from a drawing board."""
    return shape.mesh is not None or (shape.pieces is not None and shape.deviation is not None)
