"""The plan file as frozen values (format ``gm-ompl-plan/2``).

The types say which keys exist and what type each has, nothing more: whether a plan is *right* is
for ``gm_ompl.check`` to judge, so a plan that claims nonsense in the right form can be loaded.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import ConfigDict, Field, field_validator, model_validator

from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.pictures import notebook_html, notebook_scene
from gm_ompl.planfile import files
from gm_ompl.planfile.record import ArcRecord, CoordinatesRecord, PlanPart, PoseRecord, Vector

FORMAT: Final = "gm-ompl-plan/2"

Status: TypeAlias = Literal["solved", "infeasible", "budget", "interrupted"]
Mode: TypeAlias = Literal["position", "force"]
Json: TypeAlias = dict[str, Any]
Spot: TypeAlias = tuple[str, tuple[int, int] | Vector]


class PlacementRecord(PlanPart):
    """Where a finger touches the object.

    Attributes:
        face: the face's name.
        cell: the grid cell on that face; null where the placement is on no grid.
        point: the contact point on the surface, object frame.
        normal: unit, pointing into the object, object frame.
    """

    face: str
    cell: tuple[int, int] | None
    point: Vector
    normal: Vector

    @property
    def spot(self) -> Spot:
        """What tells it from others: face and cell, face and point where it is on no grid."""
        return self.face, self.point if self.cell is None else self.cell

    @property
    def words(self) -> str:
        """The placement in words: ``+x [3, 2]``, or ``+x (2.5, 0.3, 1)`` on no grid."""
        if self.cell is not None:
            return f"{self.face} {list(self.cell)}"
        return f"{self.face} ({', '.join(f'{round(x, 9) + 0.0:.4g}' for x in self.point)})"

    def row(self, table: PlacementTable) -> int | None:
        """Return its row in a placement table; None where it is not there."""
        if self.cell is None:
            return table.find_point(self.face, self.point)
        return table.find(self.face, self.cell)


class SegmentRecord(PlanPart):
    """One segment of a displacement arc, judged at its midpoint.

    Attributes:
        modes: per finger.
        f_com: per finger, the commanded normal force; None under position control.
        z: the optimum of Problem (6) with these modes and this f_com.
        z_strong: how much of it is strongly held, where the scenario plans with that; then it is
            what enters (9).
    """

    modes: tuple[Mode, ...]
    f_com: tuple[float | None, ...]
    z: float
    z_strong: float | None = None


class DisplacementStep(PlanPart):
    """One arc for displacement of the object, the fingertips fixed on it.

    Attributes:
        from_: object coordinates at the tail (``from`` in the file); with free motion there are
            none, here and below: null in the file.
        to: object coordinates at the head, unwrapped.
        arc: how the object moves from ``pose_from``.
        pose_from: the pose at the tail.
        pose_to: the pose at the head.
        placements: per physical finger.
        segments: parts of the arc, in order.
        cost: Eq. (9).
    """

    kind: Literal["displacement"]
    from_: CoordinatesRecord = Field(validation_alias="from", serialization_alias="from")
    to: CoordinatesRecord
    arc: ArcRecord
    pose_from: PoseRecord
    pose_to: PoseRecord
    placements: tuple[PlacementRecord, ...]
    segments: tuple[SegmentRecord, ...]
    cost: float


class RegraspStep(PlanPart):
    """One arc for regrasping: a finger changes its placement while the object rests.

    Attributes:
        at: object coordinates; with free motion there are none, and the pose is the one that the
            step before ended at.
        finger: the physical finger that is lifted, from 0.
        from_: its placement before (``from`` in the file).
        to: its placement after.
        way: the fingertip's centre on its way through the air, world frame; None where it is not
            planned.
        placements: per physical finger, before the move.
        modes: per finger, None for the lifted one.
        f_com: per finger, None under position control and for the lifted one.
        z: the stability margin of the rest.
        z_strong: as for a segment.
        cost: Eq. (10).
    """

    kind: Literal["regrasp"]
    at: CoordinatesRecord
    finger: int = Field(ge=0)
    from_: PlacementRecord = Field(validation_alias="from", serialization_alias="from")
    to: PlacementRecord
    way: tuple[Vector, ...] | None
    placements: tuple[PlacementRecord, ...]
    modes: tuple[Mode | None, ...]
    f_com: tuple[float | None, ...]
    z: float
    z_strong: float | None = None
    cost: float


Step: TypeAlias = Annotated[DisplacementStep | RegraspStep, Field(discriminator="kind")]


JointRow: TypeAlias = tuple[float, ...]


class HandRecord(PlanPart):
    """What a robot hand's hinges do; angles in rad, a number per joint in every row.

    Attributes:
        joints: the hinges' names, as in the hand's file.
        approach: from home to where all fingertips touch.
        steps: per step; rows of a displacement are evenly spaced along its arc.
        retreat: from the last configuration home.
    """

    joints: tuple[str, ...]
    approach: tuple[JointRow, ...] = Field(min_length=1)
    steps: tuple[Annotated[tuple[JointRow, ...], Field(min_length=2)], ...]
    retreat: tuple[JointRow, ...] = Field(min_length=1)


class Statistics(PlanPart):
    """What the search did; a planner may add keys.

    Attributes:
        time_s: wall time [s].
        expanded: nodes expanded.
        mode_decisions: decisions by Sec. 3.4.
        history: (time_s, cost of the best plan or None, lower bound or None), in time order.
    """

    model_config = ConfigDict(extra="allow")

    time_s: float = Field(ge=0)
    expanded: int = Field(ge=0)
    mode_decisions: int = Field(ge=0)
    history: tuple[tuple[float, float | None, float | None], ...]

    @model_validator(mode="after")
    def _plain_extras(self) -> Statistics:
        """Refuse added keys whose values JSON cannot hold, NaN included."""
        files.plain(self.__pydantic_extra__ or {})
        return self


class Plan(PlanPart):
    """A plan, or the reason why there is none.

    Attributes:
        format: always ``gm-ompl-plan/2``.
        status: "solved", "infeasible", "budget" or "interrupted".
        planner: the planner's name.
        seed: the random seed.
        parameters: the planner's parameters.
        optimal: whether ``cost`` is proven to be within 1e-6 (relative) of the lattice's optimum.
        cost: the sum of the steps' costs; None without a plan.
        lower_bound: no plan on the lattice is cheaper; None where nothing is known.
        regrasps: number of regrasping steps; None without a plan.
        scenario: the whole scenario as resolved.
        statistics: what the search did.
        steps: in order; each starts where the last ended.
        hand: joint paths, where the scenario has a hand.
    """

    format: Literal["gm-ompl-plan/2"]
    status: Status
    planner: str
    seed: int | None
    parameters: Json
    optimal: bool
    cost: float | None
    lower_bound: float | None
    regrasps: Annotated[int, Field(ge=0)] | None
    scenario: Json
    statistics: Statistics
    steps: tuple[Step, ...]
    hand: HandRecord | None = None

    @field_validator("parameters", "scenario")
    @classmethod
    def _plain_json(cls, value: Json) -> Json:
        """Return an independent copy; refuses what JSON cannot hold, NaN included."""
        return files.plain(value)

    @property
    def has_plan(self) -> bool:
        """Whether there is a plan: solved, or interrupted with one in hand."""
        return self.status == "solved" or (self.status == "interrupted" and self.cost is not None)

    def __repr__(self) -> str:
        """Return a line: the scenario, how it ended, what it costs."""
        name = self.scenario.get("name", "scenario")
        if self.cost is None:
            return f"<Plan for {name}: {self.status}>"
        proven = ", optimal" if self.optimal else ""
        return (
            f"<Plan for {name}: {self.status} by {self.planner}, cost {self.cost:.6g}{proven}, "
            f"{len(self.steps)} steps, regrasps: {self.regrasps}>"
        )

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def scene(self) -> Any:
        """Return the plan's scene, to be turned and played where a notebook shows it.

        Raises:
            MissingExtraError: meshcat is not installed.
        """
        return notebook_scene(self)

    @property
    def segments(self) -> tuple[SegmentRecord, ...]:
        """The segments of all displacements, in order."""
        return tuple(
            part for step in self.steps if step.kind == "displacement" for part in step.segments
        )

    @property
    def least_z(self) -> float | None:
        """The smallest stability margin; None without a plan."""
        rests = (step.z for step in self.steps if step.kind == "regrasp")
        return min((*rests, *(part.z for part in self.segments)), default=None)

    @classmethod
    def schema_of_files(cls) -> Json:
        """Return the JSON Schema of plan files, which ``plan.schema.json`` holds."""
        schema = cls.model_json_schema(by_alias=True, mode="serialization")
        return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}

    def to_dict(self) -> Json:
        """Return the plan with the file's keys, lists for sequences."""
        whole = self.model_dump(mode="json", by_alias=True)
        for step in whole["steps"]:
            for part in (step, *step.get("segments", ())):
                if part.get("z_strong", 0.0) is None:
                    del part["z_strong"]
        return whole

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the plan to ``path``, whole or not at all.

        Raises:
            PlanError: the file cannot be written.
        """
        files.write(Path(path), files.dumps(self.to_dict()))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Plan:
        """Read a plan file.

        Raises:
            PlanError: it cannot be read or is no plan; the message names file, line, key,
                value and what would be right.
        """
        return files.read(Path(path), cls, FORMAT)
