"""Random states of free motion: goal states, and states that some hand brings the object to."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.separation import lowered, supports
from gm_ompl.motion.lattice import Coordinates
from gm_ompl.planners.ompl.draws import OUTSIDE, Draws
from gm_ompl.planners.ompl.free_motions import FreeMotions
from gm_ompl.planners.ompl.steering import Steering
from gm_ompl.sampling.free_model import coordinates_of
from gm_ompl.sampling.motions import HybridState
from gm_ompl.sampling.pose_tree import nearest_in

ARRIVALS: Final = 5
"""Known states from which the goal is approached at first before any goal state will do."""

PLACES: Final = 20
"""Goal poses drawn in search of one where some hand fits."""


@final
class PoseDraws(Draws):
    """Draws states of free motion.

    Args:
        motions: what motions consist of.
        steering: finds states to which some hand brings the object.
        rng: the only source of randomness.
    """

    goals = 10

    def __init__(self, motions: FreeMotions, steering: Steering, rng: np.random.Generator) -> None:
        super().__init__(motions.free, rng)
        self._model, self._steering = motions.free, steering
        self._asked = False

    def start_and_goal_possible(self) -> bool:
        """Whether the start may have valid placements; the goal is not searched for proofs."""
        return self.hand(self._model.start, self._problem.fingers.start) is not None

    def goal(self) -> HybridState | None:
        """Return a goal state: one to which some hand brings the object, where one is found.

        Else one whose hand holds on the way into it; else any that is valid.
        """
        for _ in range(1 if self._asked else ARRIVALS):
            found = self._steering.arriving()
            if found is not None:
                return found
        self._asked = True
        found = self._steering.entering()
        if found is not None:
            return found
        for _ in range(PLACES):
            q = coordinates_of(self._pose())
            hand = self.hand(q, self._problem.fingers.goal) if self._model.arrived(q) else None
            if hand is not None and self._model.leaves(HybridState(q, hand)):
                return HybridState(q, hand)
        return None

    def _pose(self) -> Pose:
        """Return a pose in the goal, lowered where its height is open."""
        goal, (low, high) = self._model.motion.goal, self._model.motion.region
        low, high = np.maximum(low, goal.low), np.minimum(high, goal.high)
        known = self._model.pose(self.one_of(self._steering.known).q)
        near = nearest_in(goal, Pose(known.rotation, self.rng.uniform(low, np.maximum(low, high))))
        if goal.low[2] == goal.high[2]:
            return near
        problem = self._problem
        obstacles = [(o.name, o.body) for o in problem.environment.obstacles]
        under = supports(
            problem.body, obstacles, problem.environment.floor,
            Pose(near.rotation, near.position * [1.0, 1.0, 0.0]),
            problem.environment.contact_tolerance,
        )  # fmt: skip
        rise = lowered(under, problem.body.diagonal)
        return near if rise is None else Pose(near.rotation, np.array([*near.position[:2], rise]))

    def anywhere(self) -> HybridState | None:
        """Return a state that some hand brings the object to."""
        low, high = self._model.motion.region
        turn = self.rng.normal(size=4)
        return self._steering.settle(None, Pose.from_quaternion(self.rng.uniform(low, high), turn))

    def to_goal(self, q: Coordinates) -> float:
        """Return how far a pose is from the goal, over D."""
        pose, goal = self._model.pose(q), self._model.motion.goal
        if goal.contains(pose):
            return 0.0
        turn = self._model.metric.turn * goal.rotation_error(pose)
        return max((goal.position_error(pose) + turn) / self._problem.body.diagonal, OUTSIDE)
