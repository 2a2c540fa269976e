"""A hand's joint paths over time: in the air hinges lead fingertips, on the object they follow."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.hand.inverse import InverseKinematics
from gm_ompl.hand.model import HandModel
from gm_ompl.planfile.model import HandRecord
from gm_ompl.problem import Problem
from gm_ompl.simulation.timeline import PHASES, Timeline, progress

LIFT: Final = PHASES.index("lift")

SPEED: Final = 0.5
"""How fast the fastest hinge turns in the air, of what it may."""

STRAIGHT: Final = 1.05
"""So near its placement, in its radius, a fingertip goes straight up or down."""

AHEAD: Final = 0.98
"""Cosine between a way's parts, from which on it leads straight on."""

RISE: Final = 0.15
"""Time to reach that speed [s]."""

ROUNDING: Final = 0.05
"""Time over which hinges turn from one part of a way into the next that leads straight on [s]."""

FADE: Final = 0.1
"""Time constant in which a lifted fingertip forgets how far it rolled [s]."""

RETURN: Final = 7.0 * FADE
"""Time in which it does so, standing off its placement, before it goes elsewhere [s]."""

NOTHING: Final = 1e-7  # a roll that is none [m]


class AirWay(NamedTuple):
    """A way through the air over time, K instants.

    Attributes:
        joints: (K, k).
        tips: (K, n, 3), the fingertips' centres, world frame.
    """

    joints: Array
    tips: Array


class HandWays:
    """A plan's joint paths, to be laid over time.

    Args:
        record: the joint paths.
        problem: the plan's.
        dt: time step [s].
    """

    def __init__(self, record: HandRecord, problem: Problem, dt: float) -> None:
        assert problem.hand is not None
        self._record, self._dt, self.spec = record, dt, problem.hand
        environment = problem.environment
        obstacles = [obstacle.body for obstacle in environment.obstacles]
        self._model = HandModel(problem.hand, problem.body, obstacles, environment.floor)
        self._solver = InverseKinematics(self._model)
        self._radius = problem.fingers.radius

    def approach(self) -> AirWay:
        """Return the way from home to where the fingertips stand off their placements."""
        rows = np.array(self._record.approach)
        tips = self._tips(rows)
        return self._timed(rows[: self._last(tips[::-1], len(rows))])

    def retreat(self) -> AirWay:
        """Return the way home, from where the fingertips stand off."""
        rows = np.array(self._record.retreat)
        return self._timed(rows[self._first(self._tips(rows)) :])

    def regrasp(self, step: int) -> AirWay:
        """Return a lifted finger's way from where it stands off to where it does so again."""
        rows = np.array(self._record.steps[step])
        tips = self._tips(rows)
        return self._timed(rows[self._first(tips) : self._last(tips[::-1], len(rows))])

    def along(self, step: int, share: float) -> Array:
        """Return the hinges (k,) after ``share`` of a displacement's arc."""
        rows = np.array(self._record.steps[step])
        at = share * (len(rows) - 1)
        k = min(int(at), len(rows) - 2)
        return np.asarray(rows[k] + (at - k) * (rows[k + 1] - rows[k]))

    def first(self, step: int) -> Array:
        """Return the hinges (k,) at the beginning of a step."""
        return np.array(self._record.steps[step][0])

    def last(self, step: int) -> Array:
        """Return the hinges (k,) at the end of a step."""
        return np.array(self._record.steps[step][-1])

    def home(self) -> Array:
        """Return the hinges (k,) where the plan begins."""
        return np.array(self._record.approach[0])

    def _first(self, tips: Array) -> int:
        """Return the last row up to which all fingertips stay near where they begin."""
        away = np.linalg.norm(tips - tips[0], axis=2) > STRAIGHT * self._radius
        beyond = np.flatnonzero(away.any(axis=1))
        return max(int(beyond[0]) - 1, 0) if len(beyond) else len(tips) - 1

    def _last(self, backwards: Array, count: int) -> int:
        """Return the end of the rows before fingertips come down, from their rows backwards."""
        return count - self._first(backwards)

    def _tips(self, rows: Array) -> Array:
        found = []
        for q in rows:
            self._model.place(q)
            found.append(self._model.tips())
        return np.array(found)

    def _timed(self, rows: Array) -> AirWay:
        """Lay time over corners (m, k), at rest in each sharp one; the fastest hinge sets the pace.

        Rows that lead straight on are one way: an arm's are near each other.
        """
        parts, spec = [rows[:1]], self.spec
        for way in _straight_parts(rows):
            lengths = (np.abs(np.diff(way, axis=0)) / spec.speed).max(axis=1)
            ends = np.concatenate([[0.0], np.cumsum(lengths)])
            if ends[-1] > 0.0:
                along = progress(float(ends[-1]), SPEED, RISE, self._dt)
                columns = [np.interp(along, ends, column) for column in way.T]
                parts.append(np.stack(columns, axis=1))
        joints = _rounded(np.concatenate(parts), max(1, round(ROUNDING / self._dt)))
        return AirWay(joints, self._tips(joints))

    def followed(self, line: Timeline) -> Timeline:
        """Return a timeline whose hinges follow the fingertips, which roll.

        Hinges begin from where the plan has them, and so stay on its branch. A fingertip is part
        of its link: as this turns against the object, the sphere rolls over it, and its centre,
        which the plan has fixed on the object, must give way. In the air it comes back.
        """
        joints, centre = line.joints.copy(), line.centre.copy()
        q, rolled = joints[0], np.zeros(line.centre.shape[1:])
        fingers, every = tuple(range(line.fingers)), np.ones(joints.shape[1], dtype=bool)
        spin, dt, giving = line.spin, line.dt, np.zeros_like(rolled)
        for k in range(len(line)):
            centre[k] += rolled
            found = self._solver.follow(joints[k], fingers, centre[k], every)
            new = q if found is None else found
            step = self._rolling(new - q, dt * spin[k], line.normal[k])
            step += np.cross(dt * spin[k], rolled)
            down = line.down[k][:, None]
            held = down | (line.phase[k] == LIFT)  # a finger that still touches would drag
            giving = np.where(held, 0.0, giving - dt * (rolled / FADE + 2.0 * giving) / FADE)
            rolled = rolled + np.where(down, step, dt * giving)
            rolled[np.abs(rolled).max(axis=1) < NOTHING] = 0.0
            joints[k] = q = new
        return replace(line, joints=joints, centre=centre)

    def _rolling(self, turned: Array, spun: Array, normal: Array) -> Array:
        """Return (n, 3), how far spheres roll while hinges turn by ``turned`` (k,).

        The object turns by ``spun`` (3,) [rad]; ``normal`` (n, 3) points into it.
        """
        against = np.array([spun - self._model.turning(i) @ turned for i in range(len(normal))])
        return np.asarray(np.cross(against, self._radius[:, None] * normal))


def _rounded(rows: Array, count: int) -> Array:
    """Return means of so many rows (m, k) after each other; the way begins and ends as it did.

    Where a way bends at full speed, hinges would jump from one rate to another.
    """
    padded = np.concatenate([rows[:1].repeat(count, axis=0), rows, rows[-1:].repeat(count, axis=0)])
    sums = np.cumsum(np.concatenate([np.zeros_like(rows[:1]), padded]), axis=0)
    return np.asarray((sums[count:] - sums[:-count]) / count)


def _straight_parts(rows: Array) -> Iterator[Array]:
    """Yield rows (m, k) in parts that share their ends, cut where the way turns."""
    steps = np.diff(rows, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), np.finfo(float).tiny)
    turns = np.flatnonzero((steps[1:] * steps[:-1]).sum(axis=1) < AHEAD) + 1
    cuts = [0, *turns.tolist(), len(rows) - 1]
    for a, b in itertools.pairwise(cuts):
        yield rows[a : b + 1]
