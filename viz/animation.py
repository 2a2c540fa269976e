"""A plan laid over time, to be shown: segment by segment what can be seen and read."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import contacts_at
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.looks import LinkLook, looks, poses
from gm_ompl.hand.model import HandModel
from gm_ompl.motion.arc import Moment, Segment
from gm_ompl.planfile.arcs import pose_before
from gm_ompl.planfile.fit import problem_of
from gm_ompl.planfile.model import (
    DisplacementStep,
    PlacementRecord,
    Plan,
    RegraspStep,
    SegmentRecord,
)
from gm_ompl.planfile.words import ChainLink, chain
from gm_ompl.problem import Problem
from gm_ompl.simulation.segments import planned_segments
from gm_ompl.simulation.transit import Transit

ARC_SECONDS: Final = 0.35  # duration of a displacement step of a short plan at speed 1 [s]

LONGEST_DISPLACEMENT: Final = 20.0
"""All displacements together last at most this long at speed 1 [s]."""

REGRASP_SECONDS: Final = 2.0  # duration of a regrasping step at speed 1 [s]

TURN: Final = np.deg2rad(2.0)
"""Between two stored poses the object turns at most this much [rad]; a viewer interpolates."""

POSES: Final = 30  # at most this many poses are stored per segment
HEIGHT: Final = 0.1  # how far a finger is lifted where it can be [D]: enough to be seen
TRANSIT_POINTS: Final = 50  # points stored of a finger's way from one placement to the next, about

MODE_LETTERS: Final = {"position": "P", "force": "F", None: "L"}
"""How control modes are written; a lifted finger has none."""


@dataclass(frozen=True, eq=False)
class ShownSegment:
    """A stretch of time in which modes, forces and z stay the same."""

    start: float  # time at which it begins [s]
    end: float  # time at which it ends [s]
    step: int  # number of the plan's step
    segment: int | None  # number of the step's segment; None in a regrasping step
    record: SegmentRecord | RegraspStep  # what the plan says of it: modes, f_com and z
    # (p, 7), positions and quaternions (w, x, y, z) at equal times, the last at ``end``; one row
    # where the object rests
    poses: Array
    # per finger, where it touches; of a lifted finger where it touched before
    placements: tuple[PlacementRecord, ...]
    middle: Moment  # the instant at which it is judged
    contacts: ContactState  # the environment contacts then, object frame
    # (k, 3), a lifted finger's centre's way in the object frame at equal times
    path: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def modes(self) -> str:
        """One letter per finger, see ``MODE_LETTERS``."""
        return "".join(MODE_LETTERS[mode] for mode in self.record.modes)

    @property
    def regrasp(self) -> RegraspStep | None:
        """The step, where a finger is being moved."""
        return self.record if isinstance(self.record, RegraspStep) else None


@dataclass(frozen=True, eq=False)
class Animation:
    """A plan and its timeline."""

    plan: Plan  # the plan
    problem: Problem  # made from the scenario inside the plan
    # in time order, without gaps; empty where the plan has no steps
    segments: tuple[ShownSegment, ...]
    step_starts: tuple[float, ...]  # time at which each step begins [s]

    @cached_property
    def chain(self) -> tuple[ChainLink, ...]:
        """What the object does and where fingers go, in words; none for planar motion."""
        return chain(self.plan, self.problem)

    @cached_property
    def hand(self) -> HandModel | None:
        """The robot hand, where the plan has joint paths."""
        return _hand_of(self.plan, self.problem)

    @cached_property
    def links(self) -> tuple[LinkLook, ...]:
        """What its links look like; none without a hand."""
        return () if self.hand is None else looks(self.hand)

    def link_poses(self) -> list[Array]:
        """Return per step (m, s, 7), where the links are; none without a hand."""
        if self.hand is None or self.plan.hand is None:
            return []
        return [poses(self.hand, rows) for rows in self.plan.hand.steps]

    @property
    def duration(self) -> float:
        """Length of the whole animation [s]."""
        return self.segments[-1].end if self.segments else 0.0

    @property
    def name(self) -> str:
        """The scenario's name, as its author wrote it."""
        return str(self.plan.scenario.get("name", "scenario"))

    def finger_name(self, finger: int) -> str:
        """Return the finger in words: its number, and its length L where it is soft."""
        L = float(self.problem.fingers.soft[finger])
        return f"soft finger {finger} (L = {L:.4g})" if L > 0.0 else f"finger {finger}"

    def centre(self, finger: int, place: PlacementRecord) -> Array:
        """Return the centre (3,) of fingertip ``finger`` at ``place``, object frame."""
        radius = float(self.problem.fingers.radius[finger])
        return np.asarray(place.point) - radius * np.asarray(place.normal)

    def rest_pose(self) -> Array:
        """Return the pose (7,) at the start of the motion: what is shown without a plan."""
        return pose_row(self.problem.motion.pose(self.problem.start))


def animate(plan: Plan) -> Animation:
    """Return the animation of ``plan``.

    Raises:
        InputError: the scenario inside the plan cannot be used, or the steps do not fit it.
    """
    problem = problem_of(plan)
    arcs = sum(step.kind == "displacement" for step in plan.steps)
    pace = min(ARC_SECONDS, LONGEST_DISPLACEMENT / max(arcs, 1))
    segments: list[ShownSegment] = []
    starts: list[float] = []
    now, hand = 0.0, _hand_of(plan, problem)
    for number, step in enumerate(plan.steps):
        starts.append(now)
        if isinstance(step, RegraspStep):
            pose = pose_before(plan, number, problem)
            segment = _regrasp(problem, step, pose, number, now)
            if hand is not None and plan.hand is not None:
                tips = _tips(hand, plan.hand.steps[number], step.finger)
                segment = replace(segment, path=pose.to_object(tips))
            segments.append(segment)
        else:
            segments.extend(_displacement(problem, step, number, now, pace))
        now = segments[-1].end
    return Animation(plan, problem, tuple(segments), tuple(starts))


def _hand_of(plan: Plan, problem: Problem) -> HandModel | None:
    if plan.hand is None or problem.hand is None:
        return None
    return HandModel(problem.hand, problem.body)


def _tips(hand: HandModel, rows: Sequence[Sequence[float]], finger: int) -> Array:
    """Return (m, 3), where a fingertip's centre is in joint rows (m, k), world frame."""
    found = []
    for q in rows:
        hand.place(np.array(q))
        found.append(hand.tips()[finger])
    return np.array(found)


def _displacement(
    problem: Problem, step: DisplacementStep, number: int, now: float, pace: float
) -> list[ShownSegment]:
    """Return the step's segments.

    A long arc of a continuous planner lasts as long as the lattice arcs it spans would.
    """
    count = len(step.segments)
    seconds = pace * max(1.0, count / problem.cost.samples_per_arc) / count
    shown = []
    for j, planned in enumerate(planned_segments(problem, number, step)):
        poses = _poses(planned.part)
        if j == count - 1:
            recorded = np.array([*step.pose_to.position, *step.pose_to.quaternion])
            poses[-1] = _same_side(recorded, poses[-1])
        middle = planned.part.middle
        shown.append(
            ShownSegment(
                start=now + j * seconds,
                end=now + (j + 1) * seconds,
                step=number,
                segment=j,
                record=planned.record,
                poses=poses,
                placements=step.placements,
                middle=middle,
                contacts=contacts_at(middle, problem.body, problem.environment),
            )
        )
    return shown


def _regrasp(
    problem: Problem, step: RegraspStep, pose: Pose, number: int, now: float
) -> ShownSegment:
    rest = Moment(pose)
    return ShownSegment(
        start=now,
        end=now + REGRASP_SECONDS,
        step=number,
        segment=None,
        record=step,
        poses=pose_row(rest.pose)[None],
        placements=step.placements,
        middle=rest,
        contacts=contacts_at(rest, problem.body, problem.environment),
        path=transit_path(problem, rest.pose, step),
    )


def transit_path(problem: Problem, pose: Pose, step: RegraspStep) -> Array:
    """Return points (k, 3) of the lifted fingertip's way, object frame, at nearly equal times."""
    corners = pose.to_object(_corners(problem, pose, step))
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    shares = TRANSIT_POINTS * lengths / max(float(lengths.sum()), np.finfo(float).tiny)
    legs = [
        np.linspace(a, b, max(1, round(share)), endpoint=False)
        for a, b, share in zip(corners, corners[1:], shares.tolist(), strict=False)
    ]
    return np.concatenate([*legs, corners[-1:]])


def _corners(problem: Problem, pose: Pose, step: RegraspStep) -> Array:
    """Return the corners of the way, world frame: as planned, else one found here."""
    if step.way is not None:
        return np.array(step.way)
    points, normals = (
        np.array([getattr(place, name) for place in step.placements])
        for name in ("point", "normal")
    )
    transit = Transit(problem, pose, points, normals, HEIGHT * problem.body.diagonal)
    corners, _ = transit.way(step.finger, np.array(step.to.point), np.array(step.to.normal))
    return corners


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


def _same_side(row: Array, other: Array) -> Array:
    """Return ``row`` with the sign of its quaternion that is nearer to that of ``other``."""
    sign = 1.0 if row[3:] @ other[3:] >= 0 else -1.0
    return np.concatenate([row[:3], sign * row[3:]])
