"""What the parts of a plan file have in common, poses, and how a plan file states an arc."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    PlainSerializer,
    Strict,
    Tag,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)
from pydantic_core import PydanticKnownError

Vector: TypeAlias = tuple[float, float, float]
_Quaternion: TypeAlias = tuple[float, float, float, float]


class PlanPart(BaseModel):
    """What all parts of a plan share: frozen, strictly typed, no unknown key, no NaN."""

    model_config = ConfigDict(
        frozen=True,
        strict=True,
        extra="forbid",
        allow_inf_nan=False,
        validate_by_name=True,
        defer_build=True,  # a plan of one kind of arc needs no other
    )


def not_zero(value: tuple[float, ...]) -> tuple[float, ...]:
    """Return ``value``; refuse one that has no direction."""
    if not any(value):
        raise ValueError("must not be all zeros")
    return value


def _or_none(value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
    """Return coordinates; none of them for null."""
    if value == []:
        least = {"field_type": "List", "min_length": 1, "actual_length": 0}
        raise PydanticKnownError("too_short", least)
    return () if value is None or value == () else handler(value)


def _null_for_none(value: tuple[float, ...]) -> list[float] | None:
    return list(value) or None


CoordinatesRecord: TypeAlias = Annotated[
    tuple[Annotated[float, Strict()], ...],
    Field(strict=False),  # a wrapped validator is given JSON's lists as lists
    WrapValidator(_or_none),
    PlainSerializer(_null_for_none, return_type=Annotated[list[float], Field(min_length=1)] | None),
]
"""Object coordinates; empty where the motion has none, which the file states as null."""


class PoseRecord(PlanPart):
    """Where the object is.

    Attributes:
        position: the centre of mass, world frame.
        quaternion: unit, (w, x, y, z), object to world.
    """

    position: Vector
    quaternion: Annotated[_Quaternion, AfterValidator(not_zero)]


class TranslationArc(PlanPart):
    """The object moves without turning.

    Attributes:
        translation: the whole way, world frame.
    """

    translation: Vector


class Turn(PlanPart):
    """A turn about a line fixed in the world.

    Attributes:
        point: of the line.
        axis: unit, the line's direction.
        angle: the whole turn about ``axis`` [rad].
    """

    point: Vector
    axis: Annotated[Vector, AfterValidator(not_zero)]
    angle: float


class RotationArc(PlanPart):
    """The object turns about a line.

    Attributes:
        rotation: the turn.
    """

    rotation: Turn


class StraightLine(PlanPart):
    """A straight line in x, y and yaw [rad].

    Attributes:
        from_: where it begins (``from`` in the file).
        to: where it ends.
    """

    from_: Vector = Field(validation_alias="from", serialization_alias="from")
    to: Vector


class StraightArc(PlanPart):
    """Position in the plane and yaw change linearly at once.

    Attributes:
        straight: from where to where.
    """

    straight: StraightLine


KINDS = ("translation", "rotation", "straight")


def _kind(value: Any) -> str | None:
    """Return the tag of an arc's kind; tags must not look like keys of the file."""
    for kind in KINDS:
        if kind in value if isinstance(value, dict) else hasattr(value, kind):
            return f"arc: {kind}"
    return None


ArcRecord: TypeAlias = Annotated[
    Annotated[TranslationArc, Tag("arc: translation")]
    | Annotated[RotationArc, Tag("arc: rotation")]
    | Annotated[StraightArc, Tag("arc: straight")],
    Discriminator(
        _kind,
        custom_error_type="arc_kind",
        custom_error_message="must have one of the keys " + ", ".join(KINDS),
    ),
]
"""One arc: exactly one kind."""
