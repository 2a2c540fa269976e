"""How far fingertips are from where free motion must take them."""

from __future__ import annotations

from typing import final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.motion.free import PoseGoal


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
