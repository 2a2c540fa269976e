"""The key ``hand``: what a scenario may say of the robot hand behind the fingertips."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from gm_ompl.scenario.fields import (
    Angle,
    AngleInterval,
    OneOrMany,
    Positive,
    RotationModel,
    Strict,
    Text,
    Vector,
    said,
)


class TipModel(Strict):
    """Where a fingertip's sphere sits."""

    link: Text = said("the link's name in the hand's file")
    offset: Vector = said("the sphere's centre in the link's frame", (0.0, 0.0, 0.0))


class BaseModel(Strict):
    """Where the hand's base is."""

    position: Vector = said("of the base's origin", (0.0, 0.0, 0.0))
    rotation: RotationModel | None = None


class RobotModel(Strict):
    """A robot hand: ``model`` or ``file``. Lengths are metres, masses kilograms then."""

    model: Text | None = said("a shipped hand: trifinger, arm-hand", None)
    file: Text | None = said("a URDF or MJCF; beside the scenario's file", None)
    packages: dict[str, Text] = Field(
        default_factory=dict, description="folders by the names that package:// paths begin with"
    )
    files: dict[str, Text] = Field(
        default_factory=dict,
        description="file and all that it names, as a plan keeps them, compressed",
    )
    tips: Annotated[tuple[TipModel, ...], Field(min_length=1)] | None = said(
        "the fingertips, in finger order", None
    )
    base: BaseModel = BaseModel()
    home: dict[str, Angle] | None = said("by joint: where the hand waits", None)
    limits: dict[str, AngleInterval] = Field(
        default_factory=dict, description="by joint, narrower than the file's: least and greatest"
    )
    torque: OneOrMany[Positive] | None = said(
        "that a joint's motor gives at most: one for all, or one each", None
    )
    speed: OneOrMany[Positive] | None = said("of a joint at most, rad per time; likewise", None)

    @model_validator(mode="after")
    def _one_source(self) -> RobotModel:
        """Refuse none or both of the ways to name a hand."""
        if (self.model is None) == (self.file is None):
            raise PydanticCustomError("hand", "must have model (a shipped hand) or file, not both")
        if self.files and self.file not in self.files:
            raise PydanticCustomError("hand", "files must have the one that file names")
        return self
