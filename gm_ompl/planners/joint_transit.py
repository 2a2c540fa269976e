"""A hand's ways through the air: off a surface, by OMPL's RRTConnect, and down again."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.reach import HandReach
from gm_ompl.planners.ompl.joint_space import LONGEST, MOST_LOOKS, joint_way
from gm_ompl.problem import Fingers, Placements, Regrasp

HEIGHTS: Final = (1.0, 0.5, 0.25, 0.1)
"""How far off its placement a fingertip is before it goes elsewhere, in its radius."""

PARTS: Final = 6
"""Rows between a surface and there."""


CLEAR: Final = (0.2, 0.0)
"""How far links other than fingertips' keep from the object in the air, in the least radius: as far
as a robot may go astray, or else just clear."""


class Along(NamedTuple):
    """Which hinges are planned, and what becomes of the others.

    Attributes:
        moving: (k,), those that are planned.
        complete: returns a configuration (k,) with the others where they belong, or None.
        looks: configurations looked at before a way is given up.
    """

    moving: BoolArray
    complete: Callable[[Array], Array | None]
    looks: int = MOST_LOOKS


@final
class Transits:
    """Ways in the space of a hand's hinges.

    Args:
        reach: of the hand.
        fingers: their placements.
        rng: of OMPL's random numbers.
    """

    def __init__(self, reach: HandReach, fingers: Fingers, rng: np.random.Generator) -> None:
        self._reach, self._model, self._fingers = reach, reach.model, fingers
        self._rng, self._all = rng, tuple(range(fingers.count))

    def regrasp(
        self, move: Regrasp, start: Array, end: Array, along: Along | None = None
    ) -> Array | None:
        """Return rows (m, k) from where a finger touches to where it does next, or None.

        Args:
            move: the regrasp.
            start: (k,), where it begins.
            end: (k,), where it ends.
            along: which hinges are planned; the lifted finger's own where None.
        """
        i, own = move.finger, self._model.own[move.finger]
        touch = self._reach.touch.copy()
        touch[i] = 0.0
        rise = self._off(move.pose, (i,), (move.placements[i],), start, own)
        fall = self._off(move.pose, (i,), (move.target,), end, own)
        if rise is None or fall is None:
            return None
        way = self._way(move.pose, (rise[-1], fall[-1]), along or Along(own, _as_it_is), touch)
        return None if way is None else np.concatenate([rise, way[1:-1], fall[::-1]])

    def home(self, pose: Pose, placements: Placements, q: Array) -> Array | None:
        """Return rows (m, k) from home to configuration ``q``, whose fingers touch, or None."""
        every = np.ones(len(q), dtype=bool)
        off = self._off(pose, self._all, placements, q, every)
        if off is None:
            return None
        clear = np.zeros(len(self._all))
        ends = self._model.spec.home, off[-1]
        way = self._way(pose, ends, Along(every, _as_it_is), clear)
        return None if way is None else np.concatenate([way[:-1], off[::-1]])

    def _off(
        self, pose: Pose, fingers: Sequence[int], rows: Sequence[int], q: Array, moving: BoolArray
    ) -> Array | None:
        """Return rows from ``q`` to where fingertips stand off their placements, or None."""
        table = self._fingers.placements
        here = pose.apply(
            np.array([self._reach.centres[i][row] for i, row in zip(fingers, rows, strict=True)])
        )
        outward = -table.normals[list(rows)] @ pose.rotation.T
        radius = self._fingers.radius[list(fingers)][:, None]
        for height in HEIGHTS:
            found, ends = [q], np.linspace(0.0, height, PARTS + 1)[1:]
            for part in ends.tolist():
                targets = here + part * radius * outward
                new = self._reach.kinematics.follow(found[-1], fingers, targets, moving)
                if new is None or not all(
                    self._clear(q, pose, self._reach.touch) for q in ((found[-1] + new) / 2.0, new)
                ):
                    break
                found.append(new)
            else:
                return np.array(found)
        return None

    def _clear(self, q: Array, pose: Pose, touch: Array, clear: float = 0.0) -> bool:
        self._model.place(q, pose)
        return self._model.hit(touch, clear=clear) is None

    def _way(
        self, pose: Pose, ends: tuple[Array, Array], along: Along, touch: Array
    ) -> Array | None:
        """Return corners (m, k) from one configuration to another."""
        for clear in CLEAR:
            far = clear * float(self._fingers.radius.min())
            if all(self._clear(q, pose, touch, far) for q in ends):
                found = self._corners(pose, ends, along, touch, far)
                if found is not None:
                    return found
        return None

    def _corners(
        self, pose: Pose, ends: tuple[Array, Array], along: Along, touch: Array, far: float
    ) -> Array | None:
        """Return corners as ``_way`` does, links ``far`` from the object; None if none is found."""
        spec, (moving, complete, looks), q = self._model.spec, along, ends[0].copy()

        def valid(part: Array) -> bool:
            q[moving] = part
            whole = complete(q)
            return whole is not None and self._clear(whole, pose, touch, far)

        first, last = (end[moving] for end in ends)
        found = np.array([first, last])
        if not _straight(first, last, valid):
            low, high = spec.low[moving], spec.high[moving]
            made = joint_way(low, high, first, last, valid, self._rng, looks)
            if made is None:
                return None
            found = made
            if not all(_straight(a, b, valid) for a, b in itertools.pairwise(made)):
                return None
        rows = [ends[0]]
        for part in found[1:-1]:
            q[moving] = part
            whole = complete(q)
            assert whole is not None, "it was valid"
            rows.append(whole)
        return np.array([*rows, ends[1]])


def _as_it_is(q: Array) -> Array:
    """Return a configuration all of whose other hinges stay: a copy."""
    return q.copy()


def _straight(a: Array, b: Array, valid: Callable[[Array], bool]) -> bool:
    """Whether all is valid on the straight way from one configuration to another."""
    steps = max(1, int(np.ceil(np.abs(b - a).max() / LONGEST)))
    return all(valid(a + k / steps * (b - a)) for k in range(steps + 1))
