"""A plan told in time: a sequence of beats, each with what can be seen and read during it."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Moment, Segment
from gm_ompl.plan.arcs import arc_of
from gm_ompl.plan.fit import problem_of
from gm_ompl.plan.model import DisplacementStep, PlacementRecord, Plan, RegraspStep
from gm_ompl.plan.record import PoseRecord
from gm_ompl.problem import Problem

from .transit import transit

ARC_SECONDS: Final = 0.35
"""Duration of a displacement step of a short plan at speed 1 [s]."""

LONGEST_DISPLACEMENT: Final = 20.0
"""All displacements together last at most this long at speed 1 [s]."""

REGRASP_SECONDS: Final = 2.0
"""Duration of a regrasping step at speed 1 [s]."""

TURN: Final = np.deg2rad(2.0)
"""Between two stored poses the object turns at most this much [rad]; a viewer interpolates."""

POSES: Final = 30
"""At most this many poses are stored per beat."""

MODE_LETTERS: Final = {"position": "P", "force": "F", None: "L"}
"""How a beat writes control modes; a lifted finger has none."""


@dataclass(frozen=True, eq=False)
class Beat:
    """A stretch of time in which modes, forces and z stay the same.

    Attributes:
        start: time at which it begins [s].
        end: time at which it ends [s].
        step: number of the plan's step.
        segment: number of the step's segment; None in a regrasping step.
        poses: (p, 7), positions and quaternions (w, x, y, z) at equal times, the last at ``end``;
            one row where the object rests.
        modes: one letter per finger, see ``MODE_LETTERS``.
        f_com: per finger, the commanded normal force, or None.
        z: the stability margin.
        placements: per finger, where it touches; of a lifted finger where it touched before.
        lifted: the finger that is moved, or None.
        target: its placement after the move, or None.
        path: (k, 3), its centre's way in the object frame at equal times; empty without one.
        contacts: the environment contacts at the middle, object frame.
    """

    start: float
    end: float
    step: int
    segment: int | None
    poses: Array
    modes: str
    f_com: tuple[float | None, ...]
    z: float
    placements: tuple[PlacementRecord, ...]
    contacts: ContactState
    lifted: int | None = None
    target: PlacementRecord | None = None
    path: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def regrasp(self) -> bool:
        """Whether a finger is being moved."""
        return self.lifted is not None


@dataclass(frozen=True, eq=False)
class Story:
    """A plan and its timeline.

    Attributes:
        plan: the plan.
        problem: made from the scenario inside the plan.
        beats: in time order, without gaps; empty where the plan has no steps.
        step_starts: time at which each step begins [s].
    """

    plan: Plan
    problem: Problem
    beats: tuple[Beat, ...]
    step_starts: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Length of the whole story [s]."""
        return self.beats[-1].end if self.beats else 0.0

    @property
    def name(self) -> str:
        """The scenario's name, as its author wrote it."""
        return str(self.plan.scenario.get("name", "scenario"))

    def centre(self, finger: int, place: PlacementRecord) -> Array:
        """Return the centre (3,) of fingertip ``finger`` at ``place``, object frame."""
        radius = float(self.problem.fingers.radius[finger])
        return np.asarray(place.point) - radius * np.asarray(place.normal)

    def rest_pose(self) -> Array:
        """Return the pose (7,) at the start of the motion: what is shown without a plan."""
        return pose_row(self.problem.motion.pose(self.problem.start))


def tell(plan: Plan) -> Story:
    """Return the story of ``plan``.

    Raises:
        InputError: the scenario inside the plan cannot be used, or the steps do not fit it.
    """
    problem = problem_of(plan)
    arcs = sum(step.kind == "displacement" for step in plan.steps)
    pace = min(ARC_SECONDS, LONGEST_DISPLACEMENT / max(arcs, 1))
    beats: list[Beat] = []
    starts: list[float] = []
    now = 0.0
    for number, step in enumerate(plan.steps):
        starts.append(now)
        if isinstance(step, RegraspStep):
            beats.append(_regrasp(problem, step, number, now))
        else:
            beats.extend(_displacement(problem, step, number, now, pace))
        now = beats[-1].end
    return Story(plan, problem, tuple(beats), tuple(starts))


def _displacement(
    problem: Problem, step: DisplacementStep, number: int, now: float, pace: float
) -> list[Beat]:
    """Return one beat per segment.

    A long arc of a continuous planner lasts as long as the lattice arcs it spans would.
    """
    count = len(step.segments)
    usual = problem.cost.samples_per_arc
    seconds = pace * max(1.0, count / usual) / count
    beats = []
    parts = arc_of(step).segments(count)
    for j, (part, segment) in enumerate(zip(parts, step.segments, strict=True)):
        poses = _poses(part)
        if j == count - 1:
            poses[-1] = _same_side(_recorded(step.pose_to), poses[-1])
        beats.append(
            Beat(
                start=now + j * seconds,
                end=now + (j + 1) * seconds,
                step=number,
                segment=j,
                poses=poses,
                modes="".join(MODE_LETTERS[mode] for mode in segment.modes),
                f_com=segment.f_com,
                z=segment.z,
                placements=step.placements,
                contacts=contacts_at(part.middle, problem.body, problem.environment),
            )
        )
    return beats


def _regrasp(problem: Problem, step: RegraspStep, number: int, now: float) -> Beat:
    pose = problem.motion.pose(step.at)
    return Beat(
        start=now,
        end=now + REGRASP_SECONDS,
        step=number,
        segment=None,
        poses=pose_row(pose)[None],
        modes="".join(MODE_LETTERS[mode] for mode in step.modes),
        f_com=step.f_com,
        z=step.z,
        placements=step.placements,
        lifted=step.finger,
        target=step.to,
        path=transit(problem, pose, step.finger, step.from_, step.to),
        contacts=contacts_at(Moment(pose), problem.body, problem.environment),
    )


def _poses(part: Segment) -> Array:
    """Return poses (p, 7) along a segment, close enough to be interpolated."""
    first, last = pose_row(part.start), pose_row(part.end)
    turned = 2.0 * np.arccos(min(1.0, abs(float(first[3:] @ last[3:]))))
    parts = min(max(1, int(np.ceil(turned / TURN))), POSES - 1)
    rows = [first, *(pose_row(part.pose(k / parts)) for k in range(1, parts)), last]
    for before, row in itertools.pairwise(rows):
        row[:] = _same_side(row, before)
    return np.array(rows)


def pose_row(pose: Pose) -> Array:
    """Return position and quaternion (w, x, y, z) of ``pose``, (7,)."""
    return np.concatenate([pose.position, pose.quaternion()])


def _recorded(pose: PoseRecord) -> Array:
    return np.array([*pose.position, *pose.quaternion])


def _same_side(row: Array, other: Array) -> Array:
    """Return ``row`` with the sign of its quaternion that is nearer to that of ``other``."""
    sign = 1.0 if row[3:] @ other[3:] >= 0 else -1.0
    return np.concatenate([row[:3], sign * row[3:]])
