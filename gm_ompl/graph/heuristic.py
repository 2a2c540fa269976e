"""Heuristics: lower bounds on the cost from a node to the goal."""

from __future__ import annotations

from typing import Protocol, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.caches import Memo
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.goals import blocked_at_all
from gm_ompl.holds.sets import LIFTED
from gm_ompl.problem import Placements, Problem

MOST_DISTANCES = 4_000_000
"""A goal region with more distances than this from one node counts as being everywhere."""


class Heuristic(Protocol):
    """A lower bound on the cost to the goal; it may grow while a search runs, never fall."""

    def estimate(self, config: int, placements: Placements) -> float:
        """Return the bound for a node; +inf where the goal cannot be reached.

        Args:
            config: the object's node.
            placements: canonical; at most one finger LIFTED, which may still go anywhere.
        """

    def finger_estimates(self, config: int) -> tuple[Array, ...]:
        """Return per finger (P,) bounds for every node that has it at each placement.

        The largest over a node's fingers must not exceed its ``estimate``.
        """


@final
class NoHeuristic:
    """Zero everywhere: A* becomes Dijkstra's algorithm."""

    def __init__(self, problem: Problem) -> None:
        self._zero = (np.zeros(len(problem.fingers.placements)),) * problem.fingers.count

    def estimate(self, config: int, placements: Placements) -> float:  # noqa: ARG002
        """Return 0."""
        return 0.0

    def finger_estimates(self, config: int) -> tuple[Array, ...]:  # noqa: ARG002
        """Return zeros."""
        return self._zero


@final
class TravelHeuristic:
    """Eq. (11), with min(max_i |dq*_i|, X_regr) in its first case.

    The minimum makes it admissible and consistent also where X_regr is less than the distance to
    the goal. Of several goal nodes, the nearest counts for each fingertip, and a placement is
    blocked where it is blocked at all of them. A finger in the air counts as unblocked and
    already there.

    Args:
        judge: of the problem.
        goals: the goal's nodes; at least one.
    """

    def __init__(self, judge: Judge, goals: tuple[int, ...]) -> None:
        problem = judge.problem
        self._problem, self._judge, self._goals = problem, judge, goals
        self._X_regr = problem.cost.regrasp
        self._blocked = blocked_at_all(judge, goals)
        self._lists = [mask.tolist() for mask in self._blocked]
        self._goal_centres = self._centres_at_goals()
        numbers = len(problem.fingers.placements) * problem.fingers.count
        self._distances = Memo[int, list[list[float]]](32 * numbers)

    def estimate(self, config: int, placements: Placements) -> float:
        """Return the bound (11) for a node."""
        distances = self._distances.get(config) or self._measure(config)
        n_regr, furthest = 0, 0.0
        for i, row in enumerate(placements):
            if row == LIFTED:
                continue
            if self._lists[i][row]:
                n_regr += 1
            elif distances[i][row] > furthest:
                furthest = distances[i][row]
        return n_regr * self._X_regr if n_regr else min(furthest, self._X_regr)

    def finger_estimates(self, config: int) -> tuple[Array, ...]:
        """Return per finger (P,): X_regr where it is blocked, else min(|dq*_i|, X_regr)."""
        distances = self._distances.get(config) or self._measure(config)
        return tuple(
            np.where(mask, self._X_regr, np.minimum(np.array(row), self._X_regr))
            for mask, row in zip(self._blocked, distances, strict=True)
        )

    def _centres_at_goals(self) -> dict[float, Array] | None:
        """Return per radius the centres (goals, P, 3) in the world, None if too many."""
        graph = self._problem.object_graph
        if len(self._goals) * len(self._problem.fingers.placements) > MOST_DISTANCES:
            return None
        poses = [graph.pose(node) for node in self._goals]
        return {
            radius: np.stack([pose.apply(self._judge.centres(i)) for pose in poses])
            for i, radius in enumerate(self._problem.fingers.radius.tolist())
        }

    def _measure(self, config: int) -> list[list[float]]:
        """Return per finger, per placement |dq*_i|: straight to the nearest goal node."""
        radii = self._problem.fingers.radius.tolist()
        if self._goal_centres is None:
            nowhere = [0.0] * len(self._problem.fingers.placements)
            return [nowhere for _ in radii]
        pose = self._problem.object_graph.pose(config)
        known: dict[float, list[float]] = {}
        for i, radius in enumerate(radii):
            if radius not in known:
                here = pose.apply(self._judge.centres(i))
                steps = self._goal_centres[radius] - here
                squared = np.einsum("gpk,gpk->gp", steps, steps).min(axis=0)
                known[radius] = np.sqrt(squared).tolist()
        distances = self._distances[config] = [known[radius] for radius in radii]
        return distances
