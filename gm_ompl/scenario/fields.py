"""The kinds of value a scenario holds: numbers, angles, rotations, poses, shapes."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    Tag,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError

ANGLE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(deg|rad)\s*", re.ASCII)

TAGS = frozenset({"<word>", "<other>", "<one>", "<many>", "<angle>", "<pose>", "<region>"})
"""How the kinds of a value that may be of several kinds are told apart."""

W = TypeVar("W")
T = TypeVar("T")


def said(meaning: str, default: Any = ...) -> Any:
    """Return a key's field with its meaning, for the schema; required without a default."""
    return Field(default=default, description=meaning)


class Strict(BaseModel):
    """A mapping whose unknown keys are errors and whose values cannot be changed."""

    # Parts are built with the whole that holds them, not once more by themselves.
    model_config = ConfigDict(
        extra="forbid", frozen=True, protected_namespaces=(), defer_build=True
    )


SHARE = re.compile(r"\s*\+?(\d+\.?\d*|\.\d+)\s*%\s*", re.ASCII)


def _share(value: object) -> object:
    """Return "0.1%" as 0.001, a number as it is."""
    match = SHARE.fullmatch(value) if isinstance(value, str) else None
    if match:
        return float(f"{float(match[1]) / 100.0:.15g}")
    if isinstance(value, str):
        raise PydanticCustomError("share", "must be a share, for example 0.1% or 0.001")
    return value


def _angle(value: object) -> float:
    if isinstance(value, str):
        match = ANGLE.fullmatch(value)
        if match:
            number = float(match[1])
            radians = math.radians(number) if match[2] == "deg" else number
            if math.isfinite(radians):
                return radians
    raise PydanticCustomError("angle", "an angle with its unit, for example 90 deg or 1.57 rad")


Number: TypeAlias = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive: TypeAlias = Annotated[Number, Field(gt=0)]
NotNegative: TypeAlias = Annotated[Number, Field(ge=0)]
Whole: TypeAlias = Annotated[int, Field(strict=True)]
Text: TypeAlias = Annotated[str, Field(strict=True)]
Flag: TypeAlias = Annotated[bool, Field(strict=True)]
Vector: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=3, max_length=3)]
PositiveVector: TypeAlias = Annotated[tuple[Positive, ...], Field(min_length=3, max_length=3)]
Points: TypeAlias = Annotated[tuple[Vector, ...], Field(min_length=4)]
Matrix: TypeAlias = Annotated[tuple[Vector, ...], Field(min_length=3, max_length=3)]
Triangle: TypeAlias = Annotated[
    tuple[Annotated[Whole, Field(ge=0)], ...], Field(min_length=3, max_length=3)
]
Interval: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=2, max_length=2)]
Angle: TypeAlias = Annotated[
    float,
    BeforeValidator(_angle),
    PlainSerializer(lambda angle: f"{angle!r} rad", return_type=str),
    WithJsonSchema(
        {"type": "string", "pattern": r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*(deg|rad)\s*$"}
    ),
]
Share: TypeAlias = Annotated[
    float,
    Field(strict=True, allow_inf_nan=False, ge=1e-6, le=1.0),
    BeforeValidator(_share),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "minimum": 1e-6, "maximum": 1.0},
                {"type": "string", "pattern": r"^\s*\+?[0-9.]+\s*%\s*$"},
            ]
        }
    ),
]
AngleInterval: TypeAlias = Annotated[tuple[Angle, ...], Field(min_length=2, max_length=2)]

OneOrMany: TypeAlias = Annotated[
    Annotated[T, Tag("<one>")] | Annotated[tuple[T, ...], Tag("<many>")],
    Discriminator(lambda value: "<many>" if isinstance(value, (list, tuple)) else "<one>"),
]
WordOr: TypeAlias = Annotated[
    Annotated[W, Tag("<word>")] | Annotated[T, Tag("<other>")],
    Discriminator(lambda value: "<word>" if isinstance(value, str) else "<other>"),
]
"""Text, or another kind of value."""


def per_finger(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    """Return one value per finger from one number or a list."""
    return value if isinstance(value, tuple) else (value,) * count


Quaternion: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=4, max_length=4)]

ROTATIONS = "{axis: [0, 0, 1], angle: 90 deg}, {quaternion: [1, 0, 0, 0]} or {yaw: 30 deg}"


class RotationModel(Strict):
    """A rotation: ``axis`` and ``angle``, or ``quaternion`` (w, x, y, z), or ``yaw``."""

    axis: Vector | None = said("world frame, of any length but 0", None)
    angle: Angle | None = said("about the axis", None)
    quaternion: Quaternion | None = Field(None, description="w, x, y, z; of any length but 0")
    yaw: Angle | None = Field(None, description="about z")

    @model_validator(mode="after")
    def _one_way(self) -> RotationModel:
        """Refuse none or several of the ways to write a rotation, and lengths of 0."""
        given = {key for key in type(self).model_fields if getattr(self, key) is not None}
        if given not in ({"axis", "angle"}, {"quaternion"}, {"yaw"}):
            raise PydanticCustomError("rotation", f"must be one of {ROTATIONS}")
        if not any(self.axis or self.quaternion or (1.0,)):
            raise PydanticCustomError("rotation", "an axis or quaternion must not be all zeros")
        return self


REST = "rest"
"""Instead of a height: lowered until it touches."""


def _rest(value: object) -> object:
    if value != REST:
        wanted = f"must be a finite number, or {REST} for the height (lowered until it touches)"
        raise PydanticCustomError("place", wanted)
    return value


Place: TypeAlias = WordOr[Annotated[Literal["rest"], BeforeValidator(_rest)], Number]


class Located(Strict):
    """Position of the centre of mass."""

    position: Annotated[tuple[Place, ...], Field(min_length=3, max_length=3)] = Field(
        description="x, y and z; instead of z rest: lowered until it touches"
    )

    @property
    def xy(self) -> tuple[float, float]:
        """Its place in the plane."""
        x, y, _ = self.position
        return float(x), float(y)

    @property
    def height(self) -> float | None:
        """Its height; None where it is to be found."""
        z = self.position[2]
        return None if isinstance(z, str) else z


class PoseModel(Located):
    """Position of the centre of mass, and how the object is turned."""

    yaw: Angle = said("about z", 0.0)
    rotation: RotationModel | None = None


class BoxModel(Strict):
    """An axis-parallel box between two corners."""

    min: Vector = said("its least corner")
    max: Vector = said("its greatest corner")


class MeshModel(Strict):
    """A closed triangle mesh in the scenario itself."""

    vertices: Points = said("points")
    faces: Annotated[tuple[Triangle, ...], Field(min_length=4)] = said(
        "corners of triangles, counter-clockwise from outside"
    )


class PartModel(Strict):
    """One convex piece of a shape: exactly one of ``box``, ``hull``."""

    box: BoxModel | None = None
    hull: Points | None = said("points whose convex hull it is", None)


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
    hull: Points | None = said("points whose convex hull it is", None)
    pieces: Parts | None = Field(None, description="convex pieces")
