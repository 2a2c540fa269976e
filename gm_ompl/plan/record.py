"""What the parts of a plan file have in common, and poses."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict

Vector: TypeAlias = tuple[float, float, float]
_Quaternion: TypeAlias = tuple[float, float, float, float]


class Record(BaseModel):
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


class PoseRecord(Record):
    """Where the object is.

    Attributes:
        position: the centre of mass, world frame.
        quaternion: unit, (w, x, y, z), object to world.
    """

    position: Vector
    quaternion: Annotated[_Quaternion, AfterValidator(not_zero)]
