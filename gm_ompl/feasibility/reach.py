"""Which placements a fingertip can get to through the air, and which change of placement it can.

A placement is reachable where the fingertip's sphere can get there from far away through free
space. The air around the object falls into components: what is outside, and pockets. A finger goes
from one placement to another in the same component. StraightWays ways are tried first; where they
fail, a grid of sphere centres is flooded, ever finer: gaps that are less than
``Fingers.clearance`` wider than the fingertip may count as closed, others do not.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.caches import Memo
from gm_ompl.feasibility.keys import PoseClasses
from gm_ompl.feasibility.space import Label, Part, Space, StraightWays, straight_out
from gm_ompl.geometry.air import FreeAir
from gm_ompl.geometry.flood import for_ever, straight_ways
from gm_ompl.geometry.pose import Pose
from gm_ompl.problem import Placements, Problem

LOWEST: Final = -6
"""The lowest point off a placement is as many doublings from the finest spacing: where a gap
widens beside a placement, a fingertip leaves it with next to no room."""

PER_CLEARANCE: Final = 2.0
"""Finest spacings in the clearance of a gap that must count: with two, a node lies in every ball of
its width, and neighbours in two that touch."""

SPACE_BYTES: Final = 2_000_000
"""About what the fills in one air take."""

Staying: TypeAlias = tuple[tuple[int, int], ...]
"""Fingers that stay, and the row of each."""


class Answer(enum.Enum):
    """Whether a fingertip gets away."""

    YES = "there is a way"
    NO = "it is in a pocket"
    UNDECIDED = "its surroundings are too large to be filled"


@final
class Reach:
    """Answers about one problem; all of it is computed when it is first asked for.

    Args:
        problem: the problem.
        centres: per radius, (P, 3), the fingertips' centres at every placement.

    Attributes:
        active: whether fingers go through the air at all (``fingers.transit``).
        pockets: first touches and regrasps refused.
        undecided: answers that a budget refused.
        optimistic: whether such answers are taken to be favourable.
        bounds: of the object, object frame.
    """

    def __init__(self, problem: Problem, centres: Mapping[float, Array]) -> None:
        hand = problem.fingers
        self.active = hand.transit
        self.pockets = self.undecided = 0
        self.optimistic = False
        self._problem, self._centres = problem, centres
        self._radii: list[float] = hand.radius.tolist()
        self._clearance: list[float] = hand.clearance.tolist()
        corners = problem.body.vertices
        self.bounds = corners.min(axis=0), corners.max(axis=0)
        self._obstacles = [p for o in problem.environment.obstacles for p in o.body.pieces]
        self._classes = None if self._obstacles else PoseClasses(problem)
        each = 400 + 50 * len(hand.placements)
        self._airs = Memo[tuple[object, float], FreeAir](20_000 + 5_000 * len(self._obstacles))
        self._straight = Memo[tuple[object, float], StraightWays](each)
        self._at_once = Memo[tuple[object, ...], BoolArray](400 + len(hand.placements))
        self._spaces = Memo[tuple[object, ...], Space](SPACE_BYTES)
        self._answers = Memo[tuple[object, ...], Answer](400)

    def forget(self) -> None:
        """Forget what was decided, and how much of it was not."""
        self._answers.clear()
        self.undecided = 0

    def heights(self, finger: int) -> Array:
        """Return how far off its placement a fingertip is tried, along the normal."""
        finest, most = self.finest(finger), self._problem.body.diagonal
        count = 1 + int(np.ceil(np.log2(max(most / finest, 2.0))))
        return np.array([finest * 2.0**k for k in range(LOWEST, count)])

    def clearance(self, finger: int) -> float:
        """Return how much wider than the fingertip a gap is that must count."""
        return self._clearance[finger]

    def centre(self, finger: int, row: int) -> Array:
        """Return the centre (3,) of a fingertip at a placement, object frame."""
        centre: Array = self._centres[self._radii[finger]][row]
        return centre

    def finest(self, finger: int) -> float:
        """Return the finest grid's spacing."""
        return self._clearance[finger] / PER_CLEARANCE

    def _key(
        self, pose: Pose, finger: int, staying: Iterable[tuple[int, int]]
    ) -> tuple[object, ...]:
        """Return what an answer depends on: equal fingers in the same places are the same."""
        places = sorted((self._radii[i], row) for i, row in staying)
        return (*self._alone(pose, finger), *places)

    def _alone(self, pose: Pose, finger: int) -> tuple[object, float]:
        known = None if self._classes is None else self._classes.of(pose)
        return pose.key if known is None else known, self._radii[finger]

    def _air(self, pose: Pose, finger: int, staying: Staying) -> FreeAir:
        problem, radius = self._problem, self._radii[finger]
        air = self._airs.of(
            self._alone(pose, finger),
            lambda: FreeAir(problem.body, self._obstacles, problem.environment.floor, pose, radius),
        )
        if not staying:
            return air
        radii = [self._radii[i] for i, _ in staying]
        tips = [self._centres[radius][row] for radius, (_, row) in zip(radii, staying, strict=True)]
        return air.beside(np.array(tips), np.array(radii))

    def _ways_out(self, pose: Pose, finger: int) -> StraightWays:
        return self._straight.of(self._alone(pose, finger), lambda: self._found(pose, finger))

    def _found(self, pose: Pose, finger: int) -> StraightWays:
        table, here = self._problem.fingers.placements, self._centres[self._radii[finger]]
        return straight_out(self._air(pose, finger, ()), here, table, self.heights(finger))

    def at_once(self, pose: Pose, finger: int, staying: Staying) -> BoolArray:
        """Return placements (P,) that are outside at first sight; others may be, too."""
        return self._at_once.of(
            self._key(pose, finger, staying), lambda: self._clear_ways(pose, finger, staying)
        )

    def _clear_ways(self, pose: Pose, finger: int, staying: Staying) -> BoolArray:
        ways = self._ways_out(pose, finger)
        if not staying:
            return ways.found
        air, here = self._air(pose, finger, staying), self._centres[self._radii[finger]]
        found = ways.found & air.clear_of_tips(here, ways.corner)
        found &= air.clear_of_tips(ways.corner, ways.end)
        return found

    def outside(self, pose: Pose, finger: int, staying: Staying, row: int) -> bool:
        """Whether a fingertip at ``row``, where it is free, can get away.

        Args:
            pose: where the object rests.
            finger: whose fingertip.
            staying: the others that are in place.
            row: its placement.
        """
        if self.at_once(pose, finger, staying)[row]:
            return True
        return self._taken(self._answer(pose, finger, staying, row))

    def _taken(self, answer: Answer) -> bool:
        """Return an answer as it is used, and count it where it is none."""
        if answer is Answer.UNDECIDED:
            self.undecided += 1
            return self.optimistic
        return answer is Answer.YES

    def _answer(self, pose: Pose, finger: int, staying: Staying, row: int) -> Answer:
        if self.at_once(pose, finger, staying)[row]:
            return Answer.YES
        if staying:  # who cannot get away alone cannot either with others in the way
            alone = self._answer(pose, finger, (), row)
            if alone is not Answer.YES:
                return alone
        key = (*self._key(pose, finger, staying), row)
        return self._answers.of(key, lambda: self._filled(pose, finger, staying, row))

    def _filled(self, pose: Pose, finger: int, staying: Staying, row: int) -> Answer:
        space = self.space(pose, finger, staying)
        stubs, air = self.stubs(space, finger, row), space.air
        if not len(stubs):
            return Answer.NO
        away = for_ever(air) * straight_ways(air)
        points = np.repeat(stubs, len(away), axis=0)
        if air.clear(points, points + np.tile(away, (len(stubs), 1))).any():
            return Answer.YES
        found = set[Part]()
        for level, swept in enumerate(space.swept):
            found = swept.parts(stubs)
            if Label.OUTSIDE in found:
                return Answer.YES
            for closed in space.closed[level : level + 1]:
                if not closed.parts(stubs) & {Label.OUTSIDE, Label.UNKNOWN}:
                    return Answer.NO
        return Answer.UNDECIDED if Label.UNKNOWN in found else Answer.NO

    def space(self, pose: Pose, finger: int, staying: Staying) -> Space:
        """Return the air for ``finger`` beside those that stay."""
        return self._spaces.of(
            self._key(pose, finger, staying),
            lambda: Space(self._air(pose, finger, staying), self.finest(finger)),
        )

    def stubs(self, space: Space, finger: int, row: int) -> Array:
        """Return the points (k, 3) off a placement, along its normal, as far as that is free."""
        table = self._problem.fingers.placements
        here, heights = self._centres[self._radii[finger]][row], self.heights(finger)
        off: Array = here - heights[:, None] * table.normals[row]
        piece = np.full(len(off), table.piece[row])
        free = space.air.clear(np.tile(here, (len(off), 1)), off, piece)
        return off[: len(off) if free.all() else int(free.argmin())]

    def joined(self, pose: Pose, finger: int, staying: Staying, a: int, b: int) -> bool:
        """Whether ``finger`` gets from one placement to another while others stay."""
        if not self.active:
            return True
        outside = [self.outside(pose, finger, staying, row) for row in (a, b)]
        joined = all(outside)
        if not any(outside):
            joined = self._taken(self._within(pose, finger, staying, a, b))
        self.pockets += not joined
        return joined

    def regraspable(self, pose: Pose, finger: int, rows: IntArray) -> BoolArray:
        """Return from which of some free placements a finger may go elsewhere, (len(rows),).

        The others are left aside, and what is not decided may be.
        """
        answers = {row: self._answer(pose, finger, (), row) for row in rows.tolist()}
        inside = [row for row, answer in answers.items() if answer is not Answer.YES]
        found = [
            answer is not Answer.NO
            or any(
                row != other and self._within(pose, finger, (), row, other) is not Answer.NO
                for other in inside
            )
            for row, answer in answers.items()
        ]
        return np.array(found, dtype=bool)

    def _within(self, pose: Pose, finger: int, staying: Staying, a: int, b: int) -> Answer:
        """Return whether two placements that are not outside are in one pocket."""
        space = self.space(pose, finger, staying)
        ends = [self.stubs(space, finger, row) for row in (a, b)]
        shared = set[Part]()
        for swept in space.swept:
            here, there = (swept.parts(stubs) for stubs in ends)
            shared = here & there
            if shared - {Label.UNKNOWN}:
                return Answer.YES
        return Answer.UNDECIDED if shared else Answer.NO

    def landing(
        self, pose: Pose, placements: Placements, standing: Iterable[int] = ()
    ) -> tuple[int, ...] | None:
        """Return an order in which fingers touch first, each with a way there; None without one.

        A fingertip less in the way blocks nobody: so they are taken off again, whoever can leave
        first, and land in the opposite order.

        Args:
            pose: where the object rests.
            placements: per finger.
            standing: fingers that are in place already.
        """
        if not self.active:
            return tuple(range(len(placements)))
        standing = tuple(standing)
        left, order = [i for i in range(len(placements)) if i not in standing], list[int]()
        while left:
            touching = (*standing, *left)
            for i in left:
                staying = tuple((k, placements[k]) for k in touching if k != i)
                if self.outside(pose, i, staying, placements[i]):
                    break
            else:
                self.pockets += 1
                return None
            left.remove(i)
            order.append(i)
        return tuple(reversed(order))
