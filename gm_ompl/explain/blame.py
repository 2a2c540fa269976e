"""What stands in the way of a configuration, by name."""

from __future__ import annotations

from typing import final

from gm_ompl.geometry.collision import Scene
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.problem import Placements, Problem


@final
class Blame:
    """Names what penetrates what; floor, object and every obstacle are asked alone.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        body, environment = problem.body, problem.environment
        self._object = Scene(body, [], False)
        touching = environment.contact_tolerance
        obstacles = environment.obstacles
        self._scenes = {o.name: Scene(body, [o.body], False, touching) for o in obstacles}
        if environment.floor:
            self._scenes["floor"] = Scene(body, [], True, touching)

    def configuration(self, q: Coordinates, placements: Placements) -> tuple[str, ...]:
        """Return a sentence for everything that penetrates something at ``q``; none if valid."""
        pose = self._problem.motion.pose(q)
        found = [
            f"the object penetrates {name}"
            for name, scene in self._scenes.items()
            if not scene.object_free(pose)
        ]
        hand, table = self._problem.fingers, self._problem.fingers.placements
        for i, row in enumerate(placements):
            radius, at = float(hand.radius[i]), slice(row, row + 1)
            tip = (pose, table.centres(radius)[at], radius, table.piece[at])
            # Every scene holds the object's own pieces: what they block is not the obstacle's.
            if not self._object.free_placements(*tip)[0]:
                found.append(f"the fingertip of finger {i} penetrates the object")
                continue
            found += [
                f"the fingertip of finger {i} penetrates {name}"
                for name, scene in self._scenes.items()
                if not scene.free_placements(*tip)[0]
            ]
        return (*found, *self._pairs(placements))

    def _pairs(self, placements: Placements) -> list[str]:
        hand, table = self._problem.fingers, self._problem.fingers.placements
        found = []
        for i, row in enumerate(placements):
            for j in range(i):
                a, b = float(hand.radius[j]), float(hand.radius[i])
                other = placements[j]
                apart = self._object.tips_apart(
                    table.centres(a)[other : other + 1], a, table.centres(b)[row : row + 1], b
                )
                if not apart[0, 0]:
                    found.append(f"the fingertips of fingers {j} and {i} penetrate each other")
        return found
