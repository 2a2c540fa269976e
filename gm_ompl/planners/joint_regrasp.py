"""Regrasps in which fingers that hold follow an arm that moves.

Where fingers share an arm and the lifted one does not reach its new placement while the arm stands
still, the arm moves, too. Each finger that holds keeps its place by its own hinges: RRTConnect
plans the arm's and the lifted finger's, and Newton's steps give the others for each configuration,
always from where they were at the beginning, so that they are a function of it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.geometry.pose import Pose
from gm_ompl.hand.inverse import SAME
from gm_ompl.hand.reach import HandReach
from gm_ompl.planners.joint_transit import Along, Transits
from gm_ompl.planners.ompl.joint_space import LONGEST
from gm_ompl.problem import Regrasp

ENDS: Final = 4
"""Configurations tried at the new placement."""

AROUND: Final = 24
"""Beginnings around where a regrasp begins, from which those are sought."""

FAR: Final = 0.5
"""How far the last of them is, the standard deviation of each hinge [rad]."""

LOOKS: Final = 4_000
"""Configurations looked at before a way is given up: each takes Newton's steps."""

STEEP: Final = 5.0
"""A holding finger's hinge that turns so many times further than the others jumps."""


class HeldHand(NamedTuple):
    """Who keeps its place while an arm moves.

    Attributes:
        pose: where the object is.
        fingers: those that hold.
        targets: (m, 3), where their fingertips' centres are, world frame.
        following: (k,), the hinges that keep them there.
        moving: (k,), those that are planned: the arm's and the lifted finger's.
        start: (k,), the configuration from which Newton's steps begin.
    """

    pose: Pose
    fingers: tuple[int, ...]
    targets: Array
    following: BoolArray
    moving: BoolArray
    start: Array


@final
class ArmRegrasps:
    """Ways in the space of the hinges of an arm and one of its fingers.

    Args:
        reach: of the hand.
        transits: of the same hand.
        rng: of configurations from which Newton's steps begin.
    """

    def __init__(self, reach: HandReach, transits: Transits, rng: np.random.Generator) -> None:
        self._reach, self._model = reach, reach.model
        self._transits, self._rng = transits, rng
        self._shared = np.any(self._model.chains, axis=0) & ~np.any(self._model.own, axis=0)

    def ways(self, move: Regrasp, start: Array) -> Iterator[Array]:
        """Yield rows (m, k) that take the lifted finger to its new placement.

        Args:
            move: the regrasp.
            start: (k,), where it begins.
        """
        if not self._shared.any():
            return
        held = self._held(move, start)
        for end in itertools.islice(self._ends(move, held), ENDS):
            along = Along(held.moving, self._follower(held), LOOKS)
            rows = self._transits.regrasp(move, start, end, along)
            if rows is not None:
                dense = self._dense(rows, held)
                if dense is not None:
                    yield dense

    def _held(self, move: Regrasp, start: Array) -> HeldHand:
        i, model = move.finger, self._model
        fingers = tuple(j for j in range(model.count) if j != i)
        centres = [self._reach.centres[j][move.placements[j]] for j in fingers]
        following = np.zeros(len(start), dtype=bool)
        for j in fingers:
            following |= model.own[j]
        targets = move.pose.apply(np.array(centres).reshape(-1, 3))
        return HeldHand(move.pose, fingers, targets, following, ~following, start)

    def _follower(self, held: HeldHand) -> Callable[[Array], Array | None]:
        """Return what completes configurations: who holds keeps its place."""

        def complete(q: Array) -> Array | None:
            begun, kinematics = np.where(held.following, held.start, q), self._reach.kinematics
            return kinematics.follow(begun, held.fingers, held.targets, held.following)

        return complete

    def _ends(self, move: Regrasp, held: HeldHand) -> Iterator[Array]:
        """Yield configurations with every fingertip in place, the lifted one's new."""
        i, kinematics = move.finger, self._reach.kinematics
        target = move.pose.apply(self._reach.centres[i][move.target])
        fingers, targets = (*held.fingers, i), np.vstack([held.targets, target])
        every = np.ones(len(held.start), dtype=bool)
        others = kinematics.solutions(i, target, held.start, held.moving)
        beginnings = itertools.chain.from_iterable(
            itertools.zip_longest(self._around(held.start), others)
        )
        found, follow = list[Array](), self._follower(held)
        for beginning in beginnings:
            if beginning is None:
                continue
            end = kinematics.follow(beginning, fingers, targets, every)
            if end is None or any(np.abs(end - old).max() <= SAME for old in found):
                continue
            found.append(end)
            same = follow(end)
            if same is None or np.abs(same - end).max() > SAME:
                continue  # a holding finger would have to leave its branch
            self._model.place(end, move.pose)
            if self._model.hit(self._reach.touch) is None:
                yield end

    def _around(self, start: Array) -> Iterator[Array]:
        """Yield ``start`` (k,), and random configurations farther and farther from it."""
        spec = self._model.spec
        for k in range(AROUND):
            step = self._rng.normal(scale=FAR * k / AROUND, size=len(start))
            yield np.clip(start + step, spec.low, spec.high)

    def _dense(self, rows: Array, held: HeldHand) -> Array | None:
        """Return rows (m, k) so near each other that who holds stays; None where one jumps."""
        follow, found = self._follower(held), [rows[0]]
        for a, b in itertools.pairwise(rows):
            steps = max(1, int(np.ceil(np.abs(b - a)[held.moving].max() / LONGEST)))
            for k in range(1, steps + 1):
                q = b if k == steps else follow(a + k / steps * (b - a))
                if q is None or np.abs(q - found[-1]).max() > STEEP * LONGEST:
                    return None
                found.append(q)
        return np.array(found)
