"""Judges a hand's joint paths: limits, continuity, fingertips in place, links clear, motors."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.checking.motors import MotorCheck
from gm_ompl.checking.report import Findings
from gm_ompl.checking.second_hand import SecondHand
from gm_ompl.geometry.pose import Pose
from gm_ompl.motion.arc import Arc
from gm_ompl.planfile.model import (
    DisplacementStep,
    HandRecord,
    JointRow,
    PlacementRecord,
    RegraspStep,
)
from gm_ompl.problem import Problem

Rows: TypeAlias = tuple[JointRow, ...]


@dataclass(frozen=True)
class JointTolerances:
    """How far joint paths may be from what holds.

    Attributes:
        angle: beyond a limit, or between two rows that must be the same [rad].
        jump: the most that a hinge turns between two rows of a displacement [rad].
        row: how far a touching fingertip is from its placement in a row, over D.
        between: and halfway between two rows.
        touch: how deep a fingertip's link seems to be in the object, over its radius: a mesh has
            facets. What lies ``between`` comes on top.
        depth: how deep other links seem to be in anything, over D.
        look: between two looks at a way through the air [rad].
    """

    angle: float = 1e-9
    jump: float = 0.5
    row: float = 1e-5
    between: float = 2e-3
    touch: float = 2e-2
    depth: float = 1e-5
    look: float = 0.02


class JointCheck:
    """Judges a plan's joint paths, asked about its steps in their order.

    Args:
        problem: with a hand.
        record: the plan's joint paths.
    """

    def __init__(self, problem: Problem, record: HandRecord) -> None:
        assert problem.hand is not None
        environment = problem.environment
        obstacles = [obstacle.body for obstacle in environment.obstacles]
        self._problem, self._record, self._hand = problem, record, problem.hand
        self._second = SecondHand(problem.hand, problem.body, obstacles, environment.floor)
        self._allowed, self._D = JointTolerances(), problem.body.diagonal
        self._touch = self._allowed.touch * problem.fingers.radius
        self._motors = MotorCheck(problem, self._second)

    def whole(self, steps: int, found: Findings) -> bool:
        """Judge the paths' form, and their ends; return whether steps can be judged."""
        hand, record = self._hand, self._record
        names = record.joints == hand.joints
        wanted = f"joints are {list(record.joints)}; the hand's are {list(hand.joints)}"
        rows = [*record.approach, *record.retreat, *(row for s in record.steps for row in s)]
        lengths = all(len(row) == len(hand.joints) for row in rows)
        count = len(record.steps) == steps
        if not (
            found.check("joints", names, wanted)
            and found.check("joints", lengths, f"each row must have {len(hand.joints)} angles")
            and found.check("joints", count, f"{len(record.steps)} paths for {steps} steps")
        ):
            return False
        standing = len(self._problem.fingers.standing) == self._problem.fingers.count
        if not standing:
            self._same(record.approach[0], hand.home, "the approach begins", found)
        self._same(record.retreat[-1], hand.home, "the retreat ends", found)
        return True

    def _same(self, row: JointRow, wanted: JointRow | Array, where: str, found: Findings) -> None:
        off = float(np.abs(np.subtract(row, wanted)).max())
        text = f"{where} {off:.3g} rad from where it must"
        found.check("joints", off <= self._allowed.angle, text)

    def displacement(
        self, number: int, step: DisplacementStep, arc: Arc | None, found: Findings
    ) -> None:
        """Judge the rows along a displacement."""
        rows = self._joined(number, found)
        if arc is None:
            return
        turned = float(np.abs(np.diff(rows, axis=0)).max())
        text = f"a hinge turns {turned:.3g} rad between two rows"
        found.check("joints", turned <= self._allowed.jump, text)
        centres, parts = self._centres(step.placements), 2 * (len(rows) - 1)
        for k in range(parts + 1):
            q = (rows[k // 2] + rows[(k + 1) // 2]) / 2.0
            off = self._allowed.between if k % 2 else self._allowed.row
            pose = arc.pose(k / parts)
            self._stands(q, pose, pose.apply(centres), off, found)

        self._motors.displacement(step, arc, rows, found)

    def regrasp(
        self,
        number: int,
        step: RegraspStep,
        pose: Pose | None,
        after: tuple[PlacementRecord, ...],
        found: Findings,
    ) -> None:
        """Judge the rows of a regrasp, whose fingers are at ``after`` in the end."""
        rows, finger = self._joined(number, found), step.finger
        if pose is None:
            return
        self._motors.regrasp(step, pose, rows, found)
        before, there = (pose.apply(self._centres(hand)) for hand in (step.placements, after))
        self._stands(rows[0], pose, before, self._allowed.row, found)
        self._stands(rows[-1], pose, there, self._allowed.row, found)
        self._through_air(rows, pose, before, (finger,), found)

    def approach(
        self, pose: Pose, placements: tuple[PlacementRecord, ...], found: Findings
    ) -> None:
        """Judge the way from home."""
        self._air_to(np.array(self._record.approach), pose, placements, found)

    def retreat(self, pose: Pose, placements: tuple[PlacementRecord, ...], found: Findings) -> None:
        """Judge the way home."""
        last = self._record.steps[-1][-1]
        self._same(self._record.retreat[0], last, "the retreat begins", found)
        self._air_to(np.array(self._record.retreat)[::-1], pose, placements, found)

    def _air_to(
        self, rows: Array, pose: Pose, placements: tuple[PlacementRecord, ...], found: Findings
    ) -> None:
        targets = pose.apply(self._centres(placements))
        self._stands(rows[-1], pose, targets, self._allowed.row, found)
        everyone = tuple(range(len(placements)))
        self._through_air(rows, pose, targets, everyone, found)

    def _joined(self, number: int, found: Findings) -> Array:
        """Return a step's rows after judging that they begin where the last ones ended."""
        steps = self._record.steps
        last = steps[number - 1][-1] if number else self._record.approach[-1]
        self._same(steps[number][0], last, "the path begins", found)
        return np.array(steps[number])

    def _centres(self, placements: tuple[PlacementRecord, ...]) -> Array:
        points = np.array([record.point for record in placements])
        normals = np.array([record.normal for record in placements])
        centres: Array = points - self._problem.fingers.radius[:, None] * normals
        return centres

    def _through_air(
        self, rows: Array, pose: Pose, held: Array, moving: tuple[int, ...], found: Findings
    ) -> None:
        """Judge the ways between rows: who holds stays, nothing is in anything."""
        holding = [i for i in range(len(held)) if i not in moving]
        for a, b in itertools.pairwise(rows):
            looks = max(2, int(np.ceil(np.abs(b - a).max() / self._allowed.look)))
            for k in range(looks + 1):
                q = a + k / looks * (b - a)  # who holds may follow an arm
                off = self._allowed.between if 0 < k < looks else self._allowed.row
                self._stands(q, pose, held, off, found, holding)

    def _stands(
        self,
        q: Array,
        pose: Pose,
        targets: Array,
        off: float,
        found: Findings,
        touching: list[int] | None = None,
    ) -> None:
        """Judge one configuration: limits, fingertips on their placements, links clear."""
        hand, angle = self._hand, self._allowed.angle
        outside = np.maximum(hand.low - q, q - hand.high)
        worst = int(outside.argmax())
        text = f"{hand.joints[worst]} is {outside[worst]:.3g} rad outside its limits"
        found.check("limits", bool(outside[worst] <= angle), text)
        self._second.place(q)
        who = list(range(len(targets))) if touching is None else touching
        away = np.linalg.norm(self._second.tips()[who] - targets[who], axis=1).max(initial=0.0)
        text = f"a fingertip is {away:.3g} from its placement, allowed {off * self._D:.3g}"
        found.check("fingertips", bool(away <= off * self._D), text)
        touch = self._touch + self._allowed.between * self._D
        depth, which = self._second.deepest(pose, touch)
        text = f"{which}, {depth:.3g} deep"
        found.check("links", depth <= self._allowed.depth * self._D, text)
