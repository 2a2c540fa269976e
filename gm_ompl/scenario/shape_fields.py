"""Shapes as a scenario writes them: boxes, hulls, meshes and how they are used, pieces."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from gm_ompl.scenario.fields import (
    NotNegative,
    Points,
    Positive,
    PositiveVector,
    RotationModel,
    Strict,
    Text,
    Triangle,
    Vector,
    Whole,
    WordOr,
)


class BoxModel(Strict):
    """An axis-parallel box between two corners."""

    min: Vector
    max: Vector


class MeshModel(Strict):
    """A closed triangle mesh in the scenario itself."""

    vertices: Points
    faces: Annotated[tuple[Triangle, ...], Field(min_length=4)]


class PartModel(Strict):
    """One convex piece of a shape: exactly one of ``box``, ``hull``."""

    box: BoxModel | None = None
    hull: Points | None = None


Parts: TypeAlias = Annotated[tuple[PartModel, ...], Field(min_length=1, max_length=64)]

Bodies: TypeAlias = WordOr[
    Literal["all"], Annotated[tuple[Annotated[Whole, Field(ge=0)], ...], Field(min_length=1)]
]


class FrameModel(Strict):
    """How a mesh file's axes lie in the scenario's."""

    rotation: RotationModel


class MeshUse(Strict):
    """A mesh, and how it is used."""

    mesh: WordOr[Text, MeshModel] | None = Field(
        None, description="an STL, OBJ, PLY, OFF or GLB file, or a mesh itself"
    )
    scale: Positive | None = Field(None, description="factor from the mesh file's units")
    frame: FrameModel | None = Field(None, description="turns the mesh, for example from y up")
    weld: NotNegative | None = Field(None, description="vertices so close (a length) are one")
    flat: NotNegative | None = Field(
        None, description="triangles within this length of a plane are one face"
    )
    bodies: Bodies | None = Field(None, description="which bodies of a file with several, or all")
    simplify: Annotated[Whole, Field(ge=4)] | None = Field(
        None, description="at most so many triangles"
    )
    convex: Literal["exact", "hull", "decompose"] | None = Field(
        None, description="the mesh as it is, its convex hull, or convex pieces near it"
    )
    deviation: NotNegative | None = Field(
        None, description="written by a plan: how far its surface is from the file's"
    )


class Shape(MeshUse):
    """The object's shape: exactly one of ``box``, ``hull``, ``mesh``, ``pieces``."""

    box: PositiveVector | None = Field(None, description="size along x, y, z; centred")
    hull: Points | None = Field(None, description="points whose convex hull is the shape")
    pieces: Parts | None = Field(None, description="convex pieces that do not overlap")


class ObstacleModel(MeshUse):
    """A fixed body: exactly one of ``box``, ``hull``, ``mesh``, ``pieces``."""

    box: BoxModel | None = None
    hull: Points | None = None
    pieces: Parts | None = Field(None, description="convex pieces")
