"""A plan cut into beats: what happens between two stops of the object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Moment, Segment
from gm_ompl.plan.arcs import arc_of
from gm_ompl.plan.model import DisplacementStep, PlacementRecord, Plan, RegraspStep
from gm_ompl.problem import Problem

STRAIGHT = 0.99
"""Cosine between the vertices' velocities before and after, below which the object stops."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """One segment of a displacement arc.

    Attributes:
        step: number of the step in the plan.
        segment: number of the segment in the step.
        part: of the arc.
        f_com: per finger, commanded normal force, 0 under position control.
        z: the stability margin that the plan states.
        length: the way of the object's fastest vertex, chord.
    """

    step: int
    segment: int
    part: Segment
    f_com: Array
    z: float
    length: float


@dataclass(frozen=True, eq=False)
class Run:
    """Stretches that follow each other without a stop: same fingers, modes and direction.

    Attributes:
        placements: per finger.
        force: (n,) bool, which fingers are force-controlled.
        stretches: in order.
    """

    placements: tuple[PlacementRecord, ...]
    force: tuple[bool, ...]
    stretches: tuple[Stretch, ...]


@dataclass(frozen=True, eq=False)
class Move:
    """A regrasp: one finger goes elsewhere, the object rests.

    Attributes:
        step: number of the step in the plan.
        pose: of the object.
        finger: the one that moves.
        placements: per finger, before.
        target: the moving finger's placement after.
        force: per finger, whether force-controlled meanwhile (False for the moving one).
        f_com: per finger, 0 where not force-controlled.
        z: the stability margin that the plan states for the rest.
    """

    step: int
    pose: Pose
    finger: int
    placements: tuple[PlacementRecord, ...]
    target: PlacementRecord
    force: tuple[bool, ...]
    f_com: Array
    z: float


Beat: TypeAlias = Run | Move


def beats(plan: Plan, problem: Problem) -> tuple[Beat, ...]:
    """Cut ``plan``, whose steps fit ``problem``, into runs and regrasps.

    Raises:
        InputError: the plan has no displacement.
    """
    found: list[Beat] = []
    for number, step in enumerate(plan.steps):
        if isinstance(step, RegraspStep):
            found.append(_move(number, step, problem))
            continue
        for run in _runs(number, step, problem.body.vertices):
            last = found[-1] if found else None
            if isinstance(last, Run) and _continues(last, run, problem.body.vertices):
                found[-1] = Run(last.placements, last.force, (*last.stretches, *run.stretches))
            else:
                found.append(run)
    if not any(isinstance(beat, Run) for beat in found):
        raise InputError(f"the plan moves nothing (status {plan.status!r}): nothing to execute")
    return tuple(found)


def _move(number: int, step: RegraspStep, problem: Problem) -> Move:
    return Move(
        step=number,
        pose=problem.motion.pose(step.at),
        finger=step.finger,
        placements=step.placements,
        target=step.to,
        force=tuple(mode == "force" for mode in step.modes),
        f_com=np.array([force or 0.0 for force in step.f_com]),
        z=step.z,
    )


def _runs(number: int, step: DisplacementStep, corners: Array) -> list[Run]:
    parts = arc_of(step).segments(len(step.segments))
    runs = []
    for k, (part, segment) in enumerate(zip(parts, step.segments, strict=True)):
        way = part.end.apply(corners) - part.start.apply(corners)
        stretch = Stretch(
            step=number,
            segment=k,
            part=part,
            f_com=np.array([force or 0.0 for force in segment.f_com]),
            z=segment.z,
            length=float(np.linalg.norm(way, axis=1).max()),
        )
        force = tuple(mode == "force" for mode in segment.modes)
        runs.append(Run(step.placements, force, (stretch,)))
    return runs


def _continues(before: Run, after: Run, corners: Array) -> bool:
    """Whether the object need not stop between two runs."""
    if before.force != after.force or before.placements != after.placements:
        return False
    first, second = before.stretches[-1].part, after.stretches[0].part
    old = _velocities(first.arc.moment(first.last), corners)
    new = _velocities(second.arc.moment(second.first), corners)
    return bool((old * new).sum() >= STRAIGHT * np.linalg.norm(old) * np.linalg.norm(new))


def _velocities(moment: Moment, corners: Array) -> Array:
    assert moment.twist is not None
    return moment.twist.at(corners @ moment.pose.rotation.T)
