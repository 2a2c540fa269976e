"""How far fingertips are from where free motion must take them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.compilation import lean
from gm_ompl.motion.free import PoseGoal


class GoalTips(NamedTuple):
    """Fingertips, and where they must end, as compiled code reads them.

    Attributes:
        tips: (F, P, 3), centres of fingertips of each shape at every placement, object frame.
        at: (F, P, 3), where they end, from the centre of mass; where the heading is left open the
            height alone.
        around: (F, P), how far from the vertical through it, where the heading is left open.
        slack: (F, P), how far from there they may end.
        low: (3,), least coordinates of the centre of mass at the goal.
        high: (3,), greatest.
    """

    tips: Array
    at: Array
    around: Array
    slack: Array
    low: Array
    high: Array


@lean
def way_left(goal: GoalTips, shape: int, row: int, R: Array, p: Array) -> float:
    """Return a lower bound on the way to the goal of a fingertip, as ``distances`` has it."""
    tip, at, level, rise = goal.tips[shape, row], goal.at[shape, row], 0.0, 0.0
    for k in range(3):
        off = R[k, 0] * tip[0] + R[k, 1] * tip[1] + R[k, 2] * tip[2] - at[k]
        way = max(goal.low[k] - p[k] - off, off - (goal.high[k] - p[k]), 0.0)
        if k < 2:
            level += way * way
        else:
            rise = way
    level = max(np.sqrt(level) - goal.around[shape, row], 0.0)
    return float(max(np.hypot(level, rise) - goal.slack[shape, row], 0.0))


@final
class GoalDistance:
    """How far fingertips are from where they must end.

    Args:
        goal: where the object must end.
        tips: (P, 3), their centres, object frame.
    """

    def __init__(self, goal: PoseGoal, tips: Array) -> None:
        self._goal, self._tips = goal, tips
        arms = np.linalg.norm(tips, axis=1)
        # A point of the object that the goal fixes may end so far from there.
        self._slack = goal.distance + 2.0 * np.sin(min(goal.angle, np.pi) / 2.0) * arms
        self._around = np.zeros(len(tips))
        self._at = np.zeros_like(tips)
        if goal.rotation is not None:
            self._at = tips @ goal.rotation.T
        elif goal.up is not None:  # the heading is left open
            self._at[:, 2] = tips @ goal.up
            self._around = np.sqrt(np.maximum(arms**2 - self._at[:, 2] ** 2, 0.0))
        else:
            self._slack += arms

    @staticmethod
    def together(each: Sequence[GoalDistance]) -> GoalTips:
        """Return what compiled code goes by; of fingertips of several shapes, one goal."""
        goal = each[0]._goal
        return GoalTips(
            np.stack([one._tips for one in each]),
            np.stack([one._at for one in each]),
            np.stack([one._around for one in each]),
            np.stack([one._slack for one in each]),
            goal.low.copy(),
            goal.high.copy(),
        )

    def distances(self, rotations: Array, positions: Array) -> Array:
        """Return lower bounds (..., P) on the way to the goal of fingertips.

        Args:
            rotations: (..., 3, 3), of the object.
            positions: (..., 3), of its centre of mass.
        """
        off = self._tips @ rotations.swapaxes(-1, -2) - self._at
        low, high = self._goal.low - positions, self._goal.high - positions
        way = np.maximum(np.maximum(low[..., None, :] - off, off - high[..., None, :]), 0.0)
        level = np.maximum(np.hypot(way[..., 0], way[..., 1]) - self._around, 0.0)
        least: Array = np.maximum(np.hypot(level, way[..., 2]) - self._slack, 0.0)
        return least
