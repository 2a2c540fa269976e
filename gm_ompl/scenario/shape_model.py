"""Shapes in a scenario: boxes, hulls, meshes and convex pieces."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Tag

from gm_ompl.scenario.fields import (
    Points,
    Positive,
    PositiveVector,
    Strict,
    Text,
    Triangle,
    Vector,
    word_or,
)


class BoxModel(Strict):
    """An axis-parallel box between two corners."""

    min: Vector
    max: Vector


class MeshModel(Strict):
    """A closed triangle mesh in the scenario itself."""

    vertices: Points
    faces: Annotated[tuple[Triangle, ...], Field(min_length=4)]


MeshOrFile: TypeAlias = Annotated[
    Annotated[Text, Tag("<word>")] | Annotated[MeshModel, Tag("<mesh>")],
    word_or("<mesh>"),
]


class PartModel(Strict):
    """One convex piece of a shape: exactly one of ``box``, ``hull``."""

    box: BoxModel | None = None
    hull: Points | None = None


Parts: TypeAlias = Annotated[tuple[PartModel, ...], Field(min_length=1, max_length=64)]


class Shape(Strict):
    """The object's shape: exactly one of ``box``, ``hull``, ``mesh``, ``pieces``."""

    box: PositiveVector | None = Field(None, description="size along x, y, z; centred")
    hull: Points | None = Field(None, description="points whose convex hull is the shape")
    mesh: MeshOrFile | None = Field(None, description="an STL, OBJ or PLY file, or a mesh itself")
    scale: Positive | None = Field(None, description="factor from the mesh file's units")
    pieces: Parts | None = Field(None, description="convex pieces that do not overlap")


class ObstacleModel(Strict):
    """A fixed body: exactly one of ``box``, ``hull``, ``mesh``, ``pieces``."""

    box: BoxModel | None = None
    hull: Points | None = None
    mesh: MeshOrFile | None = Field(None, description="an STL, OBJ or PLY file, or a mesh itself")
    scale: Positive | None = Field(None, description="factor from the mesh file's units")
    pieces: Parts | None = Field(None, description="convex pieces")
