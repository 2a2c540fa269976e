"""The instants of a plan at which modes and commanded forces must hold, whatever the world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import Instant
from gm_ompl.motion.arc import Moment
from gm_ompl.planfile.arcs import arc_of, pose_before
from gm_ompl.planfile.model import PlacementRecord, Plan, Step
from gm_ompl.problem import Problem
from gm_ompl.reference.statics import Statics
from gm_ompl.tolerance.rims import Rims
from gm_ompl.uncertainty.worlds import World

SAME: Final = 1e-9  # instants that agree to this are one (lengths over D)
MISSING: Final = 1e-6  # by how much a plan's z may miss z_min, relative, as for a check


@dataclass(frozen=True, eq=False)
class Site:
    """An instant with the control that the plan has there.

    Attributes:
        step: number of the step.
        segment: of the segment in it; None while the object rests.
        fingers: those that touch; arrays per finger are of these.
        instant: the nominal contacts, fingers and object.
        modes: per finger.
        f_com: (n,), commanded forces in the scenario's units, 0 under position control.
        z_min: what z must be at least, in the scenario's units.
        diagonal: D of the object.
        room: (n, 2, 2), how far each contact may go along both tangents of its face, backward and
            forward.
        shapes: the mechanics in worlds that differ by friction and positions, as met.
    """

    step: int
    segment: int | None
    fingers: tuple[int, ...]
    instant: Instant
    modes: tuple[ControlMode, ...]
    f_com: Array
    z_min: float
    diagonal: float
    room: Array
    shapes: dict[World, tuple[Statics, Array, Array]] = field(default_factory=dict)

    @cached_property
    def force(self) -> BoolArray:
        """(n,), which fingers are force-controlled."""
        return np.array([mode is ControlMode.FORCE for mode in self.modes], dtype=bool)

    @property
    def position(self) -> frozenset[int]:
        """Which fingers, counted among those that touch, are position-controlled."""
        return frozenset(np.flatnonzero(~self.force).tolist())

    @cached_property
    def key(self) -> tuple[object, ...]:
        """Equal for sites that mechanics cannot tell apart."""
        contacts, D = self.instant.contacts, self.diagonal
        arrays = (
            contacts.points / D, contacts.normals, contacts.slip, contacts.rotation,
            self.instant.points / D, self.instant.normals, contacts.surfaces,
        )  # fmt: skip
        rounded = ((np.round(array / SAME) + 0.0).tobytes() for array in arrays)
        return (*rounded, self.fingers, self.modes, tuple(self.f_com.tolist()), self.z_min)


def sites(plan: Plan, problem: Problem) -> Iterator[Site]:
    """Yield the middle of every segment, and every rest of a regrasp, in the plan's order."""
    rims = Rims(problem.body)
    for number, step in enumerate(plan.steps):
        for segment, moment, modes, f_com in _controlled(plan, number, step, problem):
            fingers = tuple(i for i, mode in enumerate(modes) if mode is not None)
            yield Site(
                step=number,
                segment=segment,
                fingers=fingers,
                instant=instant_at(problem, moment, step.placements, fingers),
                modes=tuple(ControlMode(modes[i]) for i in fingers),
                f_com=np.array([f_com[i] or 0.0 for i in fingers], dtype=np.float64),
                z_min=problem.mechanics.z_min,
                diagonal=problem.body.diagonal,
                room=np.array([rims.room(step.placements[i]) for i in fingers]).reshape(-1, 2, 2),
            )


Controlled = tuple[int | None, Moment, tuple[str | None, ...], tuple[float | None, ...]]


def _controlled(plan: Plan, number: int, step: Step, problem: Problem) -> Iterator[Controlled]:
    """Yield the segments of a step, or its rest: number, instant, modes and commands."""
    if step.kind == "regrasp":
        yield None, Moment(pose_before(plan, number, problem)), step.modes, step.f_com
        return
    middles = arc_of(step, problem).middles(len(step.segments))
    for k, (moment, record) in enumerate(zip(middles, step.segments, strict=True)):
        yield k, moment, record.modes, record.f_com


def instant_at(
    problem: Problem,
    moment: Moment,
    placements: tuple[PlacementRecord, ...],
    fingers: tuple[int, ...],
) -> Instant:
    """Return the nominal instant, fingers where the plan, not the table, says they are."""
    contacts = contacts_at(moment, problem.body, problem.environment)
    return replace(
        problem.instant(contacts, fingers, (0,) * len(fingers)),
        points=np.array([placements[i].point for i in fingers]).reshape(-1, 3),
        normals=np.array([placements[i].normal for i in fingers]).reshape(-1, 3),
    )
