"""A plan segment by segment, and cut where the object stops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.errors import InputError
from gm_ompl.motion.arc import Segment
from gm_ompl.planfile.arcs import arc_of
from gm_ompl.planfile.model import PlacementRecord, Plan, RegraspStep, SegmentRecord, Step
from gm_ompl.problem import Problem

STRAIGHT = 0.99
"""Cosine between the vertices' velocities before and after, below which the object stops."""


@dataclass(frozen=True, eq=False)
class PlannedSegment:
    """One segment of a displacement step."""

    step: int  # number of the step in the plan
    number: int  # of the segment in the step
    part: Segment  # of the arc
    placements: tuple[PlacementRecord, ...]  # per finger
    record: SegmentRecord  # modes, f_com and z as the plan states them


Run: TypeAlias = list[PlannedSegment]
"""Segments that follow each other without a stop: same fingers, modes and direction."""

NumberedRegrasp: TypeAlias = tuple[int, RegraspStep]
"""A regrasp, the object resting, and the number of its step."""


def planned_segments(problem: Problem, number: int, step: Step) -> Run:
    """Return the segments of step ``number`` with their parts of its arc; none of a regrasp."""
    if isinstance(step, RegraspStep):
        return []
    parts = arc_of(step, problem).segments(len(step.segments))
    return [
        PlannedSegment(number, k, part, step.placements, record)
        for k, (part, record) in enumerate(zip(parts, step.segments, strict=True))
    ]


def runs(plan: Plan, problem: Problem) -> list[Run | NumberedRegrasp]:
    """Cut ``plan``, one for ``problem``, into runs and regrasps.

    Raises:
        InputError: the plan has no displacement.
    """
    found: list[Run | NumberedRegrasp] = []
    for number, step in enumerate(plan.steps):
        if isinstance(step, RegraspStep):
            found.append((number, step))
            continue
        for segment in planned_segments(problem, number, step):
            last = found[-1] if found else None
            if isinstance(last, list) and _continues(last[-1], segment, problem.body.vertices):
                last.append(segment)
            else:
                found.append([segment])
    if not any(isinstance(part, list) for part in found):
        raise InputError(f"the plan moves nothing (status {plan.status!r}): nothing to execute")
    return found


def _continues(before: PlannedSegment, after: PlannedSegment, corners: Array) -> bool:
    """Whether the object need not stop between two segments."""
    if (before.record.modes, before.placements) != (after.record.modes, after.placements):
        return False
    old, new = (
        part.arc.twist(t).at(corners @ part.arc.pose(t).rotation.T)
        for part, t in ((before.part, before.part.last), (after.part, after.part.first))
    )
    return bool((old * new).sum() >= STRAIGHT * np.linalg.norm(old) * np.linalg.norm(new))


def commanded(record: SegmentRecord | RegraspStep) -> tuple[BoolArray, Array]:
    """Return per finger whether it is force-controlled, (n,) bool, and f_com, 0 where it is not."""
    return (
        np.array([mode == "force" for mode in record.modes], dtype=bool),
        np.array([force or 0.0 for force in record.f_com]),
    )
