"""Which sets of placements may hold the object where it touches nothing but fingertips.

There z depends on the direction of gravity alone, as the object sees it. A wrench y bounds it (see
``mechanics.cuts``): under each load q within an angle of one whose bound was asked for

    z <= (max_q q . y + sum_i T_i) / h_P(y).
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.cores import share_out
from gm_ompl.mechanics import columns
from gm_ompl.mechanics.batch import States, decide_rows, unanswered
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.stability import BALANCED
from gm_ompl.problem import Problem

AT_ONCE: Final = 20_000
"""Sets asked about between two looks at the limits."""

NO_COLUMNS: Final = np.zeros((0, 6))
FIRST: Final = np.zeros(2, dtype=np.int64)
"""A contact state without contacts."""


@final
class Aloft:
    """The hand and the object in the air.

    Args:
        problem: what is held; without uncertainty.
        tips: (n, P, s, 6), the fingers' columns for unit normal force at all placements.
    """

    def __init__(self, problem: Problem, tips: Array) -> None:
        self._tips, scale = tips, problem.force_scale
        self._f_max = problem.fingers.max_normal_force / scale
        self._weight = problem.mass * problem.mechanics.gravity / scale
        self._U = columns.wrench_norm(problem.mass, problem.inertia)
        self._z_min = problem.mechanics.z_min / scale

    def may_hold(self, rows: IntArray, rotations: Array, angle: float) -> BoolArray:
        """Return which sets (L,) are not proven to fall short of z_min.

        Args:
            rows: (L, n), the sets.
            rotations: (K, 3, 3), of the object.
            angle: the direction of gravity is within this of that at one of them [rad].

        Raises:
            LimitError: a limit in force is reached.
        """
        left = np.arange(len(rows))
        for rotation in rotations:
            load = columns.load(rotation, self._weight, self._U)
            left = left[self._bounds(rows[left], load, angle) < self._z_min - BALANCED]
        may = np.ones(len(rows), dtype=bool)
        may[left] = False
        return may

    def _bounds(self, rows: IntArray, load: Array, angle: float) -> Array:
        """Return upper bounds (L,) on z over force_scale under all loads so near to ``load``."""
        found = np.empty(len(rows))
        states = States(NO_COLUMNS, FIRST, load[None], self._tips, self._f_max, DIRECTIONS)

        def work(part: slice) -> None:
            some = rows[part]
            answers = unanswered(*some.shape)
            decide_rows(states, self._z_min, np.zeros(len(some), dtype=np.int64), some, answers)
            found[part] = self._bound(some, answers.wrenches, load, angle)

        share_out(work, len(rows), most=AT_ONCE)
        return found

    def _bound(self, rows: IntArray, wrenches: Array, load: Array, angle: float) -> Array:
        weight, force = np.linalg.norm(load), np.linalg.norm(wrenches[:, :3], axis=1)
        off = np.arctan2(
            np.linalg.norm(np.cross(wrenches[:, :3], load[:3]), axis=1), wrenches @ load
        )
        most = weight * force * np.cos(np.maximum(off - angle, 0.0))
        for i, f_max in enumerate(self._f_max):
            along = np.einsum("lsk,lk->ls", self._tips[i, rows[:, i]], wrenches)
            most += f_max * np.maximum(along.max(axis=1), 0.0)
        reach = (wrenches @ DIRECTIONS.T).max(axis=1)
        return np.where(reach > 0.0, most / np.maximum(reach, 1e-300), np.inf)
