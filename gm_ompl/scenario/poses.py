"""Where the object stands at either end, as a scenario writes it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, Tag
from pydantic_core import PydanticCustomError

from gm_ompl.scenario.fields import Angle, AngleInterval, Interval, Number, Strict, word_or
from gm_ompl.scenario.rotations import RotationModel

REST = "rest"
"""Instead of a height: lowered until it touches."""


def _rest(value: object) -> object:
    if value != REST:
        wanted = f"must be a finite number, or {REST} for the height (lowered until it touches)"
        raise PydanticCustomError("place", wanted)
    return value


Place: TypeAlias = Annotated[
    Annotated[Literal["rest"], BeforeValidator(_rest), Tag("<word>")]
    | Annotated[Number, Tag("<number>")],
    word_or("<number>"),
]


class PoseModel(Strict):
    """Position of the centre of mass, and how the object is turned."""

    position: Annotated[tuple[Place, ...], Field(min_length=3, max_length=3)] = Field(
        description="x, y and z; instead of z rest: lowered until it touches"
    )
    yaw: Angle = 0.0
    rotation: RotationModel | None = None

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


class RegionModel(Strict):
    """A planar goal region."""

    x: Interval
    y: Interval
    yaw: Annotated[
        Annotated[Literal["any"], Tag("<word>")] | Annotated[AngleInterval, Tag("<range>")],
        word_or("<range>"),
    ] = "any"


def pose_or_region(value: object) -> str:
    """Tell by the keys; pydantic asks for values already made, too."""
    if isinstance(value, RegionModel):
        return "<region>"
    keys = set(value) if isinstance(value, dict) else set()
    return "<region>" if keys & {"x", "y"} and "position" not in keys else "<pose>"
