"""The scenario format, ``gm-ompl-scenario/1``: which keys there are and what each may hold.

Lengths, masses and forces are in whatever consistent units the scenario uses; angles carry
their unit and are radians here. ``docs/reference/scenario.md`` explains every key by example.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import Field

from gm_ompl.geometry.separation import TOUCHING
from gm_ompl.scenario.fields import (
    Angle,
    AngleInterval,
    Flag,
    Interval,
    Matrix,
    NotNegative,
    Number,
    ObstacleModel,
    OneOrMany,
    PoseModel,
    Positive,
    RotationModel,
    Shape,
    Strict,
    Text,
    Vector,
    Whole,
    said,
)
from gm_ompl.scenario.goals import AnyGoal, FreeModel
from gm_ompl.scenario.hand_model import RobotModel
from gm_ompl.scenario.placements import Count, FaceName, Hand, PlacementsModel
from gm_ompl.scenario.uncertain import UncertaintyModel

FORMAT = "gm-ompl-scenario/1"
MAX_FINGERS = 5


class ObjectModel(Strict):
    """What is manipulated; uniform unless centre_of_mass and inertia are given."""

    shape: Shape
    mass: Positive = said("at least 1e-15")
    centre_of_mass: Vector | None = Field(None, description="in the shape's own coordinates")
    inertia: Matrix | None = Field(None, description="3x3, about the centre of mass")


class FrictionModel(Strict):
    """Coulomb coefficients."""

    environment: NotNegative = said("of all contacts with floor and obstacles, 0 to 10,000")
    finger: OneOrMany[NotNegative] = said("of the fingertips: one for all, or one each")


class FingersModel(Strict):
    """The hand."""

    count: Annotated[Whole, Field(ge=0, le=MAX_FINGERS)] = said("how many fingertips")
    radius: OneOrMany[Positive] = said("of the spherical fingertips")
    max_normal_force: OneOrMany[Positive] = said("f_max; at most 100,000 times the object's weight")
    soft: OneOrMany[NotNegative] = Field(
        default=0.0,
        description="length L: pressing with f, a soft fingertip turns with up to mu L f as well",
    )
    placements: PlacementsModel = PlacementsModel()
    start: Hand = said("placements at the start, per finger", "any")
    goal: Hand = said("placements at the goal, per finger", "any")
    transit: Flag = Field(
        default=True,
        description="whether fingers need a way through the air to first touches and regrasps",
    )
    leave: Flag = Field(
        default=False, description="whether every finger needs a way off at the goal"
    )
    clearance: OneOrMany[Positive] | None = Field(
        default=None,
        description="a gap wider than a fingertip by this counts; half its radius",
    )


class TurnedObstacle(ObstacleModel):
    """An obstacle, and how it is turned where it stands."""

    rotation: RotationModel | None = Field(
        default=None, description="about the middle of its bounding box"
    )


class EnvironmentModel(Strict):
    """Floor and obstacles."""

    floor: Flag = said("whether z < 0 is solid", True)
    obstacles: dict[str, TurnedObstacle] = Field(
        default_factory=dict, description="fixed bodies, by their names"
    )


class SlideModel(Strict):
    """A translation."""

    by: Vector = said("the whole way, world frame")


class TumbleModel(Strict):
    """A rotation about the bottom edge on one side."""

    towards: Literal["+x", "-x", "+y", "-y"] = said(
        "the side of the bottom edge that it turns about"
    )
    angle: Angle = said("the whole turn")


class PieceModel(Strict):
    """One piece of a path: exactly one of ``slide``, ``tumble``."""

    slide: SlideModel | None = None
    tumble: TumbleModel | None = None


class PlanarModel(Strict):
    """Bounds of a planar motion."""

    x: Interval = said("least and greatest")
    y: Interval = said("least and greatest")
    yaw: AngleInterval = said("least and greatest; wraps where that is a full turn")


class MotionModel(Strict):
    """Start, and a path, planar degrees of freedom or free motion."""

    start: PoseModel
    path: Annotated[tuple[PieceModel, ...], Field(min_length=1)] | None = said(
        "pieces in a row: one degree of freedom, 0 to 1", None
    )
    planar: PlanarModel | None = None
    free: FreeModel | None = None
    goal: AnyGoal | None = None


class StepsModel(Strict):
    """Lattice steps: ``x``, ``y`` and ``yaw`` of planar motion, the other two of free motion."""

    x: Positive | None = said("of planar motion", None)
    y: Positive | None = said("of planar motion", None)
    yaw: Angle | None = said("of planar motion; divides 360 deg where yaw wraps", None)
    translation: Positive | None = said("of free motion, from 1e-4 of the object's size", None)
    rotation: Angle | None = said("of free motion, from 1e-4 rad to 180 deg", None)

    @property
    def given(self) -> dict[str, float]:
        """The steps that are given, by their keys; angles in rad."""
        values = {key: getattr(self, key) for key in type(self).model_fields}
        return {key: value for key, value in values.items() if value is not None}


class LatticeModel(Strict):
    """How finely the object's motion is divided."""

    segments: OneOrMany[Count] | None = said(
        "arcs per piece of a path: one number, or one each", None
    )
    steps: StepsModel | None = None
    depth: Count | None = Field(
        default=None, description="of free motion: at most so many arcs from the start"
    )


class MechanicsModel(Strict):
    """Settings of Sec. 3; defaults are the paper's."""

    cone_edges: Annotated[Whole, Field(ge=3, le=64)] = said(
        "s, edges of a friction cone's pyramid", 6
    )
    directions: Literal[76] = said("of the disturbances that z is measured in", 76)
    z_min: NotNegative = said("the least stability margin, a force; 0: equilibrium is enough", 0.5)
    backend: Literal["kernel", "highs"] = said("compiled, or the reference (slow)", "kernel")
    margin: Literal["nominal", "strong"] = said(
        "what reaches z_min and enters (9): z, or z_strong", "nominal"
    )
    contact_tolerance: Annotated[Number, Field(ge=1e-9, le=1e-3)] = Field(
        default=TOUCHING,
        description="a gap or overlap of at most this, relative to the object's size, is a contact",
    )
    patch_points: Annotated[Whole, Field(ge=0, le=8)] | None = Field(
        default=None,
        description="how finely contact patches are filled with points where they turn",
    )


class CostModel(Strict):
    """Settings of Sec. 4.3; defaults are the paper's."""

    regrasp: NotNegative = said("X_regr of (10), a length", 100.0)
    stability: NotNegative = said("X_stab of (9), a force, far below z_min", 0.01)
    samples_per_arc: Annotated[Whole, Field(ge=1, le=1000)] = said(
        "P: segments of an arc that are judged", 3
    )
    samples_at: Literal["middles", "ends"] = said("of P equal parts, or of the arc", "middles")
    z_floor: Positive | None = Field(
        default=None, description="what a smaller z counts as in the cost; default 0.01 M g"
    )


class ExpectAtModel(Strict):
    """What the plan must look like at one point of the path."""

    s: Annotated[Number, Field(ge=0, le=1)] = said("where on the path")
    faces: tuple[FaceName, ...] | None = said("of the fingers, in any order", None)
    modes: tuple[Literal["position", "force"], ...] | None = said(
        "of the fingers, in any order", None
    )


class ExpectModel(Strict):
    """What must come out; compared by tests, ignored by planners."""

    status: Literal["solved", "infeasible", "budget"] | None = said("how planning ends", None)
    regrasps: Annotated[Whole, Field(ge=0)] | None = said("how many", None)
    regrasp_between: Interval | None = said("s of every regrasp", None)
    cost: NotNegative | None = said("of the plan", None)
    at: tuple[ExpectAtModel, ...] = ()


class ScenarioModel(Strict):
    """A whole scenario."""

    format: Literal["gm-ompl-scenario/1"] = said("always this text")
    name: Annotated[Text, Field(min_length=1)] = said("a shipped scenario's is its file's")
    source: Text = said("where the numbers come from", "")
    description: Text = said("what it shows", "")
    object: ObjectModel
    friction: FrictionModel
    gravity: NotNegative = said("along -z", 9.8)
    fingers: FingersModel
    hand: RobotModel | None = Field(None, description="the robot hand behind the fingertips")
    environment: EnvironmentModel = EnvironmentModel()
    motion: MotionModel
    lattice: LatticeModel
    mechanics: MechanicsModel = MechanicsModel()
    cost: CostModel = CostModel()
    uncertainty: UncertaintyModel | None = Field(
        default=None, description="ranges of what is not known exactly; z is then the worst case's"
    )
    expect: ExpectModel = ExpectModel()


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the format.

    It knows every key and each value's kind; what keys must satisfy together, only ``load``
    checks.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": FORMAT,
        **ScenarioModel.model_json_schema(),
    }


def json_schema_text() -> str:
    """Return the JSON Schema as the text of the shipped file ``scenario.schema.json``."""
    return json.dumps(json_schema(), indent=2, sort_keys=False) + "\n"
