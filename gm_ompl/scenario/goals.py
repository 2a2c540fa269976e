"""The kinds of value a goal holds, and those of free motion."""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from gm_ompl.scenario.fields import (
    ANGLE,
    ROTATIONS,
    Angle,
    AngleInterval,
    Interval,
    Located,
    Positive,
    RotationModel,
    Strict,
    WordOr,
    said,
)

ANY = "any"
"""Instead of a rotation: it does not matter."""


def _any(value: object) -> object:
    if value != ANY:
        raise PydanticCustomError("rotation", f"must be {ANY}, or one of {ROTATIONS}")
    return value


AnyRotation: TypeAlias = WordOr[Annotated[Literal["any"], BeforeValidator(_any)], RotationModel]


def _heading(value: object) -> str:
    """Tell by the value; pydantic asks for values already made, too."""
    if isinstance(value, str):
        return "<angle>" if ANGLE.fullmatch(value) else "<word>"
    return "<angle>" if isinstance(value, float) else "<other>"


Heading: TypeAlias = Annotated[
    Annotated[Literal["any"], Tag("<word>")]
    | Annotated[Angle, Tag("<angle>")]
    | Annotated[AngleInterval, Tag("<other>")],
    Discriminator(_heading),
]

Axis: TypeAlias = Literal["x", "y", "z"]


def _all_axes(value: object) -> object:
    if value != ANY:
        raise PydanticCustomError("axes", f"must be {ANY}, or a list of axes, for example [y]")
    return value


Axes: TypeAlias = WordOr[Annotated[Literal["any"], BeforeValidator(_all_axes)], tuple[Axis, ...]]
Upward: TypeAlias = Literal["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"]


class WithinModel(Strict):
    """How near to its goal the object must come."""

    position: Positive | None = Field(
        default=None, description="by default 1e-3 of the object's size"
    )
    rotation: Angle = said("by default 0.5 deg", math.radians(0.5))


class GoalModel(Located):
    """A goal at one place."""

    yaw: Angle | None = said("about z; 0 where nothing is said", None)
    rotation: AnyRotation | None = said("in full, or any", None)
    up: Upward | None = Field(None, description="which of the object's axes points up")
    within: WithinModel | None = None


class RegionModel(Strict):
    """A goal that leaves something open."""

    x: Interval | None = said("range; the region's where left out", None)
    y: Interval | None = said("range", None)
    z: Interval | None = said("range", None)
    yaw: Heading | None = said("an angle, a range, or any", None)
    rotation: AnyRotation | None = said("in full, or any", None)
    up: Upward | None = Field(None, description="which of the object's axes points up")
    within: WithinModel | None = None


def turn_of(goal: GoalModel | RegionModel) -> RotationModel | None:
    """Return the rotation that a goal gives; None where it gives none, or any will do."""
    return goal.rotation if isinstance(goal.rotation, RotationModel) else None


def place_or_region(value: object) -> str:
    """Tell by the keys; pydantic asks for values already made, too."""
    if isinstance(value, RegionModel):
        return "<region>"
    keys = set(value) if isinstance(value, dict) else set()
    return "<region>" if keys and "position" not in keys else "<pose>"


AnyGoal: TypeAlias = Annotated[
    Annotated[GoalModel, Tag("<pose>")] | Annotated[RegionModel, Tag("<region>")],
    Discriminator(place_or_region),
]


class RoomModel(Strict):
    """Where the centre of mass may be."""

    x: Interval = said("least and greatest")
    y: Interval = said("least and greatest")
    z: Interval = said("least and greatest")


class FreeModel(Strict):
    """What the object may do on its way from start to goal."""

    region: RoomModel = said("of the centre of mass, all along")
    translate: Annotated[tuple[Axis, ...], Field(min_length=1)] = Field(
        ("x", "y", "z"), description="along which axes it is moved"
    )
    rotate: Axes = Field("any", description="about lines parallel to which axes it is turned")
