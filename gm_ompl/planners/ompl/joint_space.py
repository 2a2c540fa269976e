"""OMPL's RRTConnect for a hand's hinges: a way from one configuration to another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from gm_ompl import limits
from gm_ompl.arrays import Array
from gm_ompl.planners.ompl.run import silence
from gm_ompl.planners.ompl.setup import seed_ompl

LONGEST = 0.02
"""A way is looked at in steps of at most so much [rad]."""

MOST_LOOKS = 60_000
"""Configurations looked at before a way is given up, where nothing else is said."""


def joint_way(
    low: Array,
    high: Array,
    start: Array,
    goal: Array,
    valid: Callable[[Array], bool],
    rng: np.random.Generator,
    most_looks: int = MOST_LOOKS,
) -> Array | None:
    """Return corners (m, k) of a way, both ends included; None where none was found.

    Args:
        low: (k,), least angles [rad].
        high: (k,), greatest.
        start: (k,).
        goal: (k,).
        valid: whether a configuration (k,) penetrates nothing.
        rng: OMPL's random numbers, which are global, are seeded from it.
        most_looks: after so many the way is given up.
    """
    looks = 0

    def looked(state: ob.State) -> bool:
        nonlocal looks
        looks += 1
        return valid(np.array([state[k] for k in range(len(low))]))

    def over() -> bool:
        return looks > most_looks or bool(limits.reached())

    seed_ompl(rng)
    information = _space(low, high, looked)
    definition = ob.ProblemDefinition(information)
    ends = information.allocState(), information.allocState()
    for state, values in zip(ends, (start, goal), strict=True):
        for k, value in enumerate(np.clip(values, low, high).tolist()):
            state[k] = value
    definition.setStartAndGoalStates(*ends)
    planner = og.RRTConnect(information)
    planner.setProblemDefinition(definition)
    with silence():
        planner.setup()
        found = planner.solve(ob.PlannerTerminationCondition(over))
        if not found or not definition.hasExactSolution():
            return None
        way = definition.getSolutionPath()
        og.PathSimplifier(information).simplifyMax(way)
    count = way.getStateCount()
    return np.array([[way.getState(i)[k] for k in range(len(low))] for i in range(count)])


def _space(low: Array, high: Array, looked: Callable[[ob.State], bool]) -> Any:
    """Return the space of hinges between their limits, its states judged by ``looked``."""
    space = ob.RealVectorStateSpace(len(low))
    bounds = ob.RealVectorBounds(len(low))
    for k, (least, most) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        bounds.setLow(k, least)
        bounds.setHigh(k, most)
    space.setBounds(bounds)
    information = ob.SpaceInformation(space)
    information.setStateValidityChecker(looked)
    information.setStateValidityCheckingResolution(LONGEST / space.getMaximumExtent())
    information.setup()
    return information
