"""First touches, regrasps and leaving through the air: judged by the reference's plain floods."""

from __future__ import annotations

from collections.abc import Sequence

from gm_ompl.geometry.pose import Pose
from gm_ompl.plain.air import Air, Freedom
from gm_ompl.problem import Placements, Problem


class AirJudge:
    """Which placements of one problem fingers get to, each answer found once.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._known: dict[object, Freedom] = {}

    def freedom(
        self, pose: Pose, finger: int, staying: tuple[tuple[int, int], ...], row: int
    ) -> Freedom:
        """Return whether a fingertip gets away from a placement while others stay."""
        key = (pose.key, finger, staying, row)
        if key not in self._known:
            self._known[key] = Air(self.problem, pose, finger, staying).freedom(row)
        return self._known[key]

    def goes(self, pose: Pose, placements: Placements, finger: int, target: int) -> Freedom:
        """Return whether a finger gets from its placement to another."""
        if not self.problem.fingers.transit:
            return Freedom.FREE
        staying = tuple((i, row) for i, row in enumerate(placements) if i != finger)
        here = self.freedom(pose, finger, staying, placements[finger])
        there = self.freedom(pose, finger, staying, target)
        if here is there is Freedom.POCKET:
            air = Air(self.problem, pose, finger, staying)
            return Freedom.FREE if air.joined(placements[finger], target) else Freedom.POCKET
        return there if here is Freedom.FREE else here

    def landing(
        self, pose: Pose, placements: Placements, standing: Sequence[int] = ()
    ) -> tuple[Freedom, int]:
        """Return whether fingers can touch one after the other, and who cannot.

        Taken off in the opposite order: who can leave does, until nobody is left or all are stuck.
        """
        left = [i for i in range(len(placements)) if i not in standing]
        found = Freedom.FREE
        while left and self.problem.fingers.transit:
            touching = (*standing, *left)
            for i in left:
                staying = tuple((k, placements[k]) for k in touching if k != i)
                found = self.freedom(pose, i, staying, placements[i])
                if found is Freedom.FREE:
                    break
                if self.freedom(pose, i, (), placements[i]) is not Freedom.FREE:
                    return found, i
            else:
                return found, left[0]
            left.remove(i)
        return Freedom.FREE, -1
