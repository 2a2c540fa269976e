"""Which sets of placements may hold the object where it touches nothing but fingertips.

There z depends on the direction of gravity alone, as the object sees it. A wrench y bounds it (see
``mechanics.cuts``): under each load q within an angle of one whose bound was asked for

    z <= (max_q q . y + sum_i T_i) / h_P(y).
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl import limits
from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.cores import share_out
from gm_ompl.mechanics import columns
from gm_ompl.mechanics.batch import States, decide_rows, unanswered
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.mechanics.stability import BALANCED
from gm_ompl.problem import Problem

AT_ONCE: Final = 4096
"""Sets that a wrench is tried on at once."""

A_FEW: Final = 256
"""Sets that are decided first; those that fall short leave wrenches that rule out others."""

MOST: Final = 32
"""Wrenches that are tried on all others."""

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
        self._least = self._z_min - BALANCED

    def may_hold(self, rows: IntArray, rotations: Array, angle: float) -> BoolArray:
        """Return which sets (L,) are not proven to fall short of z_min.

        Args:
            rows: (L, n), the sets.
            rotations: (K, 3, 3), of the object.
            angle: the direction of gravity is within this of that at one of them [rad].

        Raises:
            LimitError: a limit in force is reached.
        """
        left, wrenches = np.random.default_rng(0).permutation(len(rows)), np.zeros((0, 6))
        for rotation in rotations:
            load, short = columns.load(rotation, self._weight, self._U), list[IntArray]()
            open_, count = self._without(rows, left, wrenches, (load, angle), short), A_FEW
            while len(open_):
                some, open_, count = open_[:count], open_[count:], 2 * count
                new = self._decide(rows[some], load)
                falls = self._bounds(rows[some], new, load, angle) < self._least
                short.append(some[falls])
                new = new[falls][:MOST]
                open_ = self._without(rows, open_, new, (load, angle), short)
                wrenches = np.concatenate([wrenches, new])
            left = np.concatenate([*short, left[:0]])
        may = np.ones(len(rows), dtype=bool)
        may[left] = False
        return may

    def _decide(self, rows: IntArray, load: Array) -> Array:
        """Return the wrenches (L, 6) that decisions leave."""
        states = States(NO_COLUMNS, FIRST, load[None], self._tips, self._f_max, DIRECTIONS)
        answers = unanswered(*rows.shape)

        def work(part: slice) -> None:
            which = np.zeros(part.stop - part.start, dtype=np.int64)
            decide_rows(states, self._z_min, which, rows[part], answers.part(part))

        share_out(work, len(rows), most=AT_ONCE)
        return answers.wrenches

    def _without(
        self, rows: IntArray, which: IntArray, wrenches: Array, loads: tuple[Array, float],
        short: list[IntArray],
    ) -> IntArray:  # fmt: skip
        """Return those of some sets that none of the wrenches (W, 6) rules out.

        ``loads`` are one and how far others are from it; the sets ruled out go into ``short``.
        """
        constants, reach = self._constants(wrenches, *loads)
        terms = [
            f_max * np.maximum((tips @ wrenches.T).max(axis=1), 0.0) / reach
            for tips, f_max in zip(self._tips, self._f_max, strict=True)
        ]
        for first in range(0, len(wrenches), MOST):
            limits.check()
            part, bounds = slice(first, first + MOST), np.empty(len(which))
            for begin in range(0, len(which), AT_ONCE):
                own = rows[which[begin : begin + AT_ONCE]].T
                each = [term[row, part] for term, row in zip(terms, own, strict=True)]
                bounds[begin : begin + AT_ONCE] = (constants[part] + sum(each)).min(axis=1)
            short.append(which[bounds < self._least])
            which = which[bounds >= self._least]
        return which

    def _bounds(self, rows: IntArray, wrenches: Array, load: Array, angle: float) -> Array:
        """Return upper bounds (L,) on z over force_scale by a wrench each, as the file has them."""
        bounds, reach = self._constants(wrenches, load, angle)
        for tips, row, f_max in zip(self._tips, rows.T, self._f_max, strict=True):
            along = np.einsum("lsk,lk->ls", tips[row], wrenches).max(axis=1)
            bounds += f_max * np.maximum(along, 0.0) / reach
        return bounds

    def _constants(self, wrenches: Array, load: Array, angle: float) -> tuple[Array, Array]:
        """Return max_q q . y / h_P(y) (W,) and h_P(y); wrenches that bound nothing have +inf."""
        force = wrenches[:, :3]
        off = np.arctan2(np.linalg.norm(np.cross(force, load[:3]), axis=1), wrenches @ load)
        most = np.linalg.norm(load) * np.linalg.norm(force, axis=1)
        reach = (wrenches @ DIRECTIONS.T).max(axis=1, initial=0.0)
        bounds = most * np.cos(np.maximum(off - angle, 0.0)) / np.maximum(reach, 1e-300)
        return np.where(reach > 0.0, bounds, np.inf), np.maximum(reach, 1e-300)
