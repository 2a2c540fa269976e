"""The kinds of value a scenario holds: numbers, vectors, angles, one-or-many, shapes."""

from __future__ import annotations

import math
import re
from typing import Annotated, TypeAlias

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    Tag,
    WithJsonSchema,
)
from pydantic_core import PydanticCustomError

ANGLE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(deg|rad)\s*", re.ASCII)

TAGS = frozenset({
    "<one>", "<many>", "<word>", "<list>", "<name>", "<number>", "<placed>", "<hand>", "<range>",
    "<pose>", "<region>", "<mesh>",
})  # fmt: skip
"""How the kinds of a value that may be of several kinds are told apart."""


class Strict(BaseModel):
    """A mapping whose unknown keys are errors and whose values cannot be changed."""

    # Parts are built with the whole that holds them, not once more by themselves.
    model_config = ConfigDict(
        extra="forbid", frozen=True, protected_namespaces=(), defer_build=True
    )


def _angle(value: object) -> float:
    if isinstance(value, str):
        match = ANGLE.fullmatch(value)
        if match:
            number = float(match[1])
            radians = math.radians(number) if match[2] == "deg" else number
            if math.isfinite(radians):
                return radians
    raise PydanticCustomError("angle", "an angle with its unit, for example 90 deg or 1.57 rad")


def _one_or_many(value: object) -> str:
    return "<many>" if isinstance(value, (list, tuple)) else "<one>"


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
AngleInterval: TypeAlias = Annotated[tuple[Angle, ...], Field(min_length=2, max_length=2)]

OneOrManyPositive: TypeAlias = Annotated[
    Annotated[Positive, Tag("<one>")] | Annotated[tuple[Positive, ...], Tag("<many>")],
    Discriminator(_one_or_many),
]
OneOrManyNotNegative: TypeAlias = Annotated[
    Annotated[NotNegative, Tag("<one>")] | Annotated[tuple[NotNegative, ...], Tag("<many>")],
    Discriminator(_one_or_many),
]


def per_finger(value: float | tuple[float, ...], count: int) -> tuple[float, ...]:
    """Return one value per finger from one number or a list."""
    return value if isinstance(value, tuple) else (value,) * count


def word_or(tag: str) -> Discriminator:
    """Tell a single word (``all``, ``any``) from the kind named by ``tag``."""
    return Discriminator(lambda value: "<word>" if isinstance(value, str) else tag)
