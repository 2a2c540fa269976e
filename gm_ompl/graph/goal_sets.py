"""Which sets of placements a plan of free motion can end with: it ends near one pose.

Fingertips must be free there. Where the object hangs in the air there, nothing but fingers holds it
in the middle of the plan's last segment, which is no farther from there than half a step's.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.contact.poses import SAME
from gm_ompl.feasibility.aloft import Aloft
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.geometry.collision import EXACT
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.arc import INSIDE
from gm_ompl.motion.free import SLACK, FreeMotion, angle_between

DISCS: Final = 6
"""A disc is covered by one of half its radius in the middle and so many around it."""

PARTS: Final = 3
"""A range of angles is covered by so many."""

PARALLEL: Final = 1e-12
"""Unit vectors are parallel where their product is as near to 1 as this."""

UP: Final = np.array([0.0, 0.0, 1.0])


@final
class GoalSets:
    """What the goal asks of sets of placements.

    Args:
        judge: of a problem of free motion; ``may_end`` wants the kernel's back end.
    """

    def __init__(self, judge: Judge) -> None:
        motion = judge.problem.motion
        assert isinstance(motion, FreeMotion)
        self._judge, self._motion = judge, motion
        goal, low, high = motion.goal, motion.goal.low, motion.goal.high
        # A plan that is no motion at all ends where it begins, whatever the goal asks.
        rotation = None if goal.contains(motion.start) else goal.rotation
        self._pose = None if rotation is None else Pose(rotation, (low + high) / 2.0)
        self._off = goal.distance + float(np.linalg.norm(high - low)) / 2.0
        self._turns = None if rotation is None else _turns(motion, rotation)

    def free(self) -> tuple[BoolArray, ...]:
        """Return per finger which placements (P,) may be free at the goal."""
        judge, hand = self._judge, self._judge.problem.fingers
        if self._pose is None:
            return (np.ones(len(hand.placements), dtype=bool),) * hand.count
        turned = 2.0 * math.sin(min(self._motion.goal.angle, math.pi) / 2.0)
        masks: dict[float, BoolArray] = {}
        for i, radius in enumerate(hand.radius.tolist()):
            if radius not in masks:
                centres, piece = judge.centres(i), hand.placements.piece
                far = float(np.linalg.norm(centres, axis=1).max(initial=0.0))
                least = radius - self._off - turned * far
                # No more than that is left of the fingertip: nothing, and all of it is elsewhere.
                masks[radius] = np.ones(len(centres), dtype=bool)
                if least > EXACT * judge.problem.body.diagonal:
                    masks[radius] = judge.scene.free_placements(self._pose, centres, least, piece)
        return tuple(masks[radius] for radius in hand.radius.tolist())

    def may_end(self, rows: IntArray) -> BoolArray:
        """Return which sets (L, n) may hold the object at the end (L,).

        Raises:
            LimitError: a limit in force is reached.
        """
        if self._aloft is None:
            return np.ones(len(rows), dtype=bool)
        assert self._turns is not None
        return self._aloft.may_hold(rows, *self._turns.parts(self._half_a_segment()))

    @cached_property
    def _aloft(self) -> Aloft | None:
        """Who answers for the hand, where nothing else is near enough to touch."""
        judge, motion, problem = self._judge, self._motion, self._judge.problem
        if self._pose is None or self._turns is None or problem.uncertainty:
            return None
        half, D = self._half_a_segment(), problem.body.diagonal
        far = float(np.linalg.norm(problem.body.vertices, axis=1).max())
        # Lines of contact are off the object by no more than the contact tolerance; a node stands
        # for all poses near it.
        near, steps = (problem.environment.contact_tolerance + SAME) * D, motion.steps
        way = half * max(steps.translation, steps.rotation * (far + near))
        room = motion.region[1] - motion.region[0] + 2.0 * SLACK * D
        shifts = self._off + near + np.minimum(way, room) + far * self._turns.sway(half)
        around = Pose(self._turns.centre, self._pose.position)
        if not judge.scene.stays_clear(around, shifts):
            return None
        assert isinstance(judge.backend, KernelBackend)
        return Aloft(problem, judge.backend.tips)

    def _half_a_segment(self) -> float:
        """Return how much of a step the object may still go from where it is judged last."""
        motion, parts = self._motion, self._judge.problem.cost.samples_per_arc
        return max(1.0 / (2 * parts), INSIDE) if motion.ends else 1.0 / (2 * parts)


class _Turns(NamedTuple):
    """How the object may be turned near the goal.

    Attributes:
        centre: (3, 3), a rotation.
        axis: (3,), unit, all others are turned from there about this; None: about any.
        angle: by how much at the goal [rad].
        step: of rotations [rad]; 0 where there are none.
    """

    centre: Array
    axis: Array | None
    angle: float
    step: float

    def sway(self, share: float) -> Array:
        """Return how far points at arm 1 may go along the world's axes (3,) in a share of a step.

        Counted from where the centre of mass is.
        """
        across = np.ones(3) if self.axis is None else np.sqrt(np.maximum(1.0 - self.axis**2, 0.0))
        return (self.angle + share * self.step) * across

    def parts(self, share: float) -> tuple[Array, float]:
        """Return rotations (K, 3, 3), and how far gravity may be from that at one of them [rad].

        A share of a step before the goal.
        """
        angle, end = self.angle + share * self.step, self.centre
        if self.axis is not None:
            tilts = [rotation_about(self.axis, k * angle * 2.0 / PARTS) for k in (0, -1, 1)]
            return tilts @ end, angle / PARTS * float(np.hypot(*self.axis[:2]))
        around = [2.0 * np.pi * k / DISCS for k in range(DISCS)]
        lines = [np.array([math.cos(a), math.sin(a), 0.0]) for a in around]
        tilts = [rotation_about(line, angle * math.sqrt(3.0) / 2.0) for line in lines]
        return np.array([np.eye(3), *tilts]) @ end, angle / 2.0


def _turns(motion: FreeMotion, goal: Array) -> _Turns:
    """Return how the object may be turned where it arrives, close to the goal's rotation (3, 3)."""
    axes, start, steps = motion.steps.rotate, motion.start.rotation, motion.steps
    if axes is not None and not len(axes):
        return _Turns(start, UP, 0.0, 0.0)
    if axes is None or (np.abs(axes @ axes[0]) < 1.0 - PARALLEL).any():
        return _Turns(goal, None, motion.goal.angle + SAME, steps.rotation)
    axis, turn = axes[0], goal @ start.T
    # The angle about the axis that comes nearest to the goal.
    twice = turn - turn.T
    sine = float(axis @ np.array([twice[2, 1], twice[0, 2], twice[1, 0]]))
    nearest = math.atan2(sine, float(np.trace(turn) - axis @ turn @ axis))
    centre = rotation_about(axis, nearest) @ start
    angle = motion.goal.angle + angle_between(centre, goal) + SAME
    return _Turns(centre, axis, angle, steps.rotation)
