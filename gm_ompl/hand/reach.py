"""What a hand reaches: masks per finger at a pose and along an arc, and what was refused.

A placement counts where the finger's chain alone has a configuration there: the fingertip's centre
on the placement, within the limits, its links clear of object, floor, obstacles and each other. It
is necessary for a whole hand, and lazy: asked where geometry leaves a fingertip free.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.caches import Memo
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.inverse import InverseKinematics
from gm_ompl.hand.model import HandModel

TOUCH: Final = 2e-2
"""How deep a fingertip's own link may seem to be in the object, in its radius: meshes have facets,
and inverse kinematics ends somewhere."""

NEAR: Final = 0.05
"""A refusal holds in so large a ball around its pose, in the object's diagonals and in rad."""


class HandReach:
    """Answers about one hand, one object and one table of placements.

    Args:
        model: the hand among object and obstacles.
        centres: per finger, (P, 3), the fingertip's centres at the placements, object frame.
        radius: (n,), of the fingertips.
        diagonal: of the object.

    Attributes:
        kinematics: the inverse kinematics, for whoever continues from here.
        touch: (n,), how deep a fingertip's link may seem to be in the object.
        refusals: how often joint paths refused a placement somewhere.
    """

    def __init__(
        self, model: HandModel, centres: Sequence[Array], radius: Array, diagonal: float
    ) -> None:
        self.model, self.kinematics = model, InverseKinematics(model)
        self.centres, self.touch, self.refusals = tuple(centres), TOUCH * radius, 0
        self._near = NEAR * diagonal
        self._found = Memo[tuple[bytes, int, int], tuple[Array, ...]](400)
        self._refused: list[tuple[Pose, int, int]] = []
        self._arcs: dict[Hashable, set[tuple[int, int]]] = {}

    def configuration(self, pose: Pose, finger: int, row: int) -> Array | None:
        """Return hinges (k,) that put one fingertip on a placement, the others at home."""
        found = self._found.of((pose.key, finger, row), lambda: self._search(pose, finger, row))
        return found[0] if found else None

    def _search(self, pose: Pose, finger: int, row: int) -> tuple[Array, ...]:
        target = pose.apply(self.centres[finger][row])
        for q in self.kinematics.solutions(finger, target, self.model.spec.home):
            self.model.place(q, pose)
            if self.model.hit(self.touch, (finger,)) is None:
                return (q,)
        return ()

    def mask(self, pose: Pose, finger: int, free: BoolArray) -> BoolArray:
        """Return which of the placements ``free`` (P,) a finger reaches at a pose."""
        reached = free.copy()
        for at, who, row in self._refused:
            if who == finger and reached[row] and self._beside(at, pose):
                reached[row] = False
        for row in np.flatnonzero(reached).tolist():
            reached[row] = self.configuration(pose, finger, row) is not None
        reached.flags.writeable = False
        return reached

    def along(
        self, key: Hashable, poses: Sequence[Pose], finger: int, free: BoolArray
    ) -> BoolArray:
        """Return which of the placements ``free`` (P,) a finger reaches all along an arc.

        Args:
            key: the arc's.
            poses: some along it.
            finger: whose.
            free: by everything else.
        """
        reached = free.copy()
        reached[[row for who, row in self._arcs.get(key, ()) if who == finger]] = False
        for pose in poses:
            reached = self.mask(pose, finger, reached).copy()
        reached.flags.writeable = False
        return reached

    def refuse(self, key: Hashable, pose: Pose, finger: int, row: int) -> None:
        """Take a finger off a placement along an arc and beside a pose, whatever is said above."""
        self.refusals += 1
        self._refused.append((pose, finger, row))
        if key is not None:
            self._arcs.setdefault(key, set()).add((finger, row))

    def _beside(self, a: Pose, b: Pose) -> bool:
        """Whether two poses are near each other."""
        if np.linalg.norm(a.position - b.position) > self._near:
            return False
        cosine = (np.trace(a.rotation.T @ b.rotation) - 1.0) / 2.0
        return bool(cosine >= np.cos(NEAR))
