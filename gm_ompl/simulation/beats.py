"""A plan cut into beats: what happens between two stops of the object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError
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
        start: object coordinates (d,) where it begins.
        end: where it ends.
        f_com: per finger, commanded normal force, 0 under position control.
        z: the stability margin that the plan states.
        length: the way of the object's fastest vertex, chord.
    """

    step: int
    segment: int
    start: Array
    end: Array
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
        at: object coordinates.
        finger: the one that moves.
        placements: per finger, before.
        target: the moving finger's placement after.
        force: per finger, whether force-controlled meanwhile (False for the moving one).
        f_com: per finger, 0 where not force-controlled.
        z: the stability margin that the plan states for the rest.
    """

    step: int
    at: Array
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
            found.append(_move(number, step))
            continue
        for run in _runs(number, step, problem):
            last = found[-1] if found else None
            if isinstance(last, Run) and _continues(last, run, problem):
                found[-1] = Run(last.placements, last.force, (*last.stretches, *run.stretches))
            else:
                found.append(run)
    if not any(isinstance(beat, Run) for beat in found):
        raise InputError(f"the plan moves nothing (status {plan.status!r}): nothing to execute")
    return tuple(found)


def _move(number: int, step: RegraspStep) -> Move:
    return Move(
        step=number,
        at=np.array(step.at),
        finger=step.finger,
        placements=step.placements,
        target=step.to,
        force=tuple(mode == "force" for mode in step.modes),
        f_com=np.array([force or 0.0 for force in step.f_com]),
        z=step.z,
    )


def _runs(number: int, step: DisplacementStep, problem: Problem) -> list[Run]:
    cuts = np.linspace(step.from_, step.to, len(step.segments) + 1)
    corners = [problem.motion.pose(q).apply(problem.body.vertices) for q in cuts]
    runs = []
    for k, segment in enumerate(step.segments):
        stretch = Stretch(
            step=number,
            segment=k,
            start=cuts[k],
            end=cuts[k + 1],
            f_com=np.array([force or 0.0 for force in segment.f_com]),
            z=segment.z,
            length=float(np.linalg.norm(corners[k + 1] - corners[k], axis=1).max()),
        )
        force = tuple(mode == "force" for mode in segment.modes)
        runs.append(Run(step.placements, force, (stretch,)))
    return runs


def _continues(before: Run, after: Run, problem: Problem) -> bool:
    """Whether the object need not stop between two runs."""
    if before.force != after.force or before.placements != after.placements:
        return False
    first, second = before.stretches[-1], after.stretches[0]
    # Close to the joint, not on it: there a path of pieces answers for the next piece alone.
    old = _direction(first.end - 1e-3 * (first.end - first.start), first, problem)
    new = _direction(second.start + 1e-3 * (second.end - second.start), second, problem)
    return bool((old * new).sum() >= STRAIGHT * np.linalg.norm(old) * np.linalg.norm(new))


def _direction(q: Array, stretch: Stretch, problem: Problem) -> Array:
    twist = problem.motion.velocity(q, stretch.end - stretch.start)
    return twist.at(problem.body.vertices @ problem.motion.pose(q).rotation.T)
