"""The scenario format, ``gm-ompl-scenario/1``: which keys there are and what each may hold.

Lengths, masses and forces are in whatever consistent units the scenario uses; angles carry
their unit and are radians here. ``docs/scenario-format.md`` explains every key by example.
"""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, TypeAlias

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
    WordOr,
)
from gm_ompl.scenario.goals import AnyGoal, FreeModel

FORMAT = "gm-ompl-scenario/1"
MAX_FINGERS = 5
MAX_COUNT = 1_000_000
"""No lattice axis and no grid side is longer than this."""

Count: TypeAlias = Annotated[Whole, Field(ge=1, le=MAX_COUNT)]


class ObjectModel(Strict):
    """What is manipulated; uniform unless centre_of_mass and inertia are given."""

    shape: Shape
    mass: Positive
    centre_of_mass: Vector | None = Field(None, description="in the shape's own coordinates")
    inertia: Matrix | None = Field(None, description="3x3, about the centre of mass")


class FrictionModel(Strict):
    """Coulomb coefficients."""

    environment: NotNegative
    finger: OneOrMany[NotNegative]


FaceName: TypeAlias = WordOr[Text, Whole]


class Placed(Strict):
    """One fingertip placement."""

    face: FaceName
    cell: Annotated[tuple[Annotated[Whole, Field(ge=0)], ...], Field(min_length=2, max_length=2)]


Hand: TypeAlias = WordOr[Literal["any"], tuple[WordOr[Literal["any"], Placed], ...]]


class PlacementsModel(Strict):
    """The grid of placements on the object's faces."""

    grid: Annotated[tuple[Count, ...], Field(min_length=2, max_length=2)] = (7, 7)
    faces: WordOr[Literal["all"], Annotated[tuple[FaceName, ...], Field(min_length=1)]] = "all"
    margin: NotNegative | None = Field(default=None, description="least distance from a face's rim")
    smallest_face: Annotated[NotNegative, Field(lt=1)] | None = Field(
        default=None,
        description="faces with less than this part of the surface get no placements",
    )


class FingersModel(Strict):
    """The hand."""

    count: Annotated[Whole, Field(ge=0, le=MAX_FINGERS)]
    radius: OneOrMany[Positive]
    max_normal_force: OneOrMany[Positive]
    soft: OneOrMany[NotNegative] = Field(
        default=0.0,
        description="length L: pressing with f, a soft fingertip turns with up to mu L f as well",
    )
    placements: PlacementsModel = PlacementsModel()
    start: Hand = "any"
    goal: Hand = "any"
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

    floor: Flag = True
    obstacles: dict[str, TurnedObstacle] = Field(default_factory=dict)


class SlideModel(Strict):
    """A translation."""

    by: Vector


class TumbleModel(Strict):
    """A rotation about the bottom edge on one side."""

    towards: Literal["+x", "-x", "+y", "-y"]
    angle: Angle


class PieceModel(Strict):
    """One piece of a path: exactly one of ``slide``, ``tumble``."""

    slide: SlideModel | None = None
    tumble: TumbleModel | None = None


class PlanarModel(Strict):
    """Bounds of a planar motion."""

    x: Interval
    y: Interval
    yaw: AngleInterval


class MotionModel(Strict):
    """Start, and a path, planar degrees of freedom or free motion."""

    start: PoseModel
    path: Annotated[tuple[PieceModel, ...], Field(min_length=1)] | None = None
    planar: PlanarModel | None = None
    free: FreeModel | None = None
    goal: AnyGoal | None = None


class StepsModel(Strict):
    """Lattice steps: ``x``, ``y`` and ``yaw`` of planar motion, the other two of free motion."""

    x: Positive | None = None
    y: Positive | None = None
    yaw: Angle | None = None
    translation: Positive | None = None
    rotation: Angle | None = None

    @property
    def given(self) -> dict[str, float]:
        """The steps that are given, by their keys; angles in rad."""
        values = {key: getattr(self, key) for key in type(self).model_fields}
        return {key: value for key, value in values.items() if value is not None}


class LatticeModel(Strict):
    """How finely the object's motion is divided."""

    segments: OneOrMany[Count] | None = None
    steps: StepsModel | None = None
    depth: Count | None = Field(
        default=None, description="of free motion: at most so many arcs from the start"
    )


class MechanicsModel(Strict):
    """Settings of Sec. 3; defaults are the paper's."""

    cone_edges: Annotated[Whole, Field(ge=3, le=64)] = 6
    directions: Literal[76] = 76
    z_min: NotNegative = 0.5
    backend: Literal["kernel", "highs"] = "kernel"
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

    regrasp: NotNegative = 100.0
    stability: NotNegative = 0.01
    samples_per_arc: Annotated[Whole, Field(ge=1, le=1000)] = 3
    z_floor: Positive | None = Field(
        default=None, description="what a smaller z counts as in the cost; default 0.01 M g"
    )


class ExpectAtModel(Strict):
    """What the plan must look like at one point of the path."""

    s: Annotated[Number, Field(ge=0, le=1)]
    faces: tuple[FaceName, ...] | None = None
    modes: tuple[Literal["position", "force"], ...] | None = None


class ExpectModel(Strict):
    """What must come out; compared by tests, ignored by planners."""

    status: Literal["solved", "infeasible", "budget"] | None = None
    regrasps: Annotated[Whole, Field(ge=0)] | None = None
    regrasp_between: Interval | None = None
    cost: NotNegative | None = None
    at: tuple[ExpectAtModel, ...] = ()


class ScenarioModel(Strict):
    """A whole scenario."""

    format: Literal["gm-ompl-scenario/1"]
    name: Annotated[Text, Field(min_length=1)]
    source: Text = ""
    description: Text = ""
    object: ObjectModel
    friction: FrictionModel
    gravity: NotNegative = 9.8
    fingers: FingersModel
    environment: EnvironmentModel = EnvironmentModel()
    motion: MotionModel
    lattice: LatticeModel
    mechanics: MechanicsModel = MechanicsModel()
    cost: CostModel = CostModel()
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
