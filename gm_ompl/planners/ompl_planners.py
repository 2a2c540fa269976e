"""OMPL's planners that are sound for one-way motion, by their OMPL names."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.parameters import Parameter
from gm_ompl.planners.planner import (
    Budget,
    Planner,
    PlannerSpecs,
    Report,
    SearchResult,
    silent,
)
from gm_ompl.problem import Problem

_FIRST = PlannerSpecs(directed=True, optimal=False, randomised=True)
_ANYTIME = PlannerSpecs(directed=True, optimal=True, randomised=True)

RANGE = Parameter(
    "range",
    float,
    1.0,
    "Longest motion tried, as a share of the space's extent. Below 1, motions end at states "
    "between two others, whose placements lie between theirs in the placement table.",
    low=0.001,
    high=1.0,
    logarithmic=True,
)
GOAL_BIAS = Parameter(
    "goal_bias", float, 0.05, "How often a goal state is drawn.", low=0.0, high=1.0
)
GUIDED = Parameter(
    "guided",
    float,
    0.0,
    "How often a state is drawn that is valid by itself and leans to placements that have held, "
    "instead of a uniform one.",
    low=0.0,
    high=1.0,
)
FIRST_PLAN = Parameter("first_plan", bool, False, "Stop at the first plan instead of improving it.")
GOAL_STATES = Parameter(
    "goal_states", int, 100, "Goal states that are drawn.", low=1, high=100_000, logarithmic=True
)
SAMPLES = Parameter(
    "samples", int, 100, "States drawn at a time.", low=1, high=1_000_000, logarithmic=True
)
# BITstar and FMT compare every state with every goal state and with all its neighbours.
FEW_GOAL_STATES = replace(GOAL_STATES, default=10)


class OmplPlanner(Planner):
    """One of OMPL's planners on the hybrid space; every path is judged anew."""

    def solve(
        self,
        problem: Problem,  # noqa: ARG002 (the judge knows it)
        judge: Judge,
        budget: Budget,
        rng: np.random.Generator,
        report: Report = silent,
    ) -> SearchResult:
        """Search for a plan; an iteration is one question of OMPL's whether to stop.

        A planner that improves its plan stops at the first one where ``budget`` has neither a
        time limit nor an iteration limit.
        """
        from gm_ompl.planners.ompl_run import run  # loads OMPL

        return run(self, judge, budget, rng, report)


class RRT(OmplPlanner):
    """A tree from the start."""

    name: ClassVar[str] = "RRT"
    specs: ClassVar[PlannerSpecs] = _FIRST
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_BIAS, GUIDED)


class RRTConnect(OmplPlanner):
    """Two trees; the goal's is judged in the direction of execution."""

    name: ClassVar[str] = "RRTConnect"
    specs: ClassVar[PlannerSpecs] = _FIRST
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_STATES)


class RRTstar(OmplPlanner):
    """A tree from the start that is rewired towards the optimum."""

    name: ClassVar[str] = "RRTstar"
    specs: ClassVar[PlannerSpecs] = _ANYTIME
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_BIAS, GUIDED, FIRST_PLAN)


class InformedRRTstar(OmplPlanner):
    """RRTstar that draws only states that could improve the plan."""

    name: ClassVar[str] = "InformedRRTstar"
    specs: ClassVar[PlannerSpecs] = _ANYTIME
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_BIAS, GUIDED, FIRST_PLAN)


class SORRTstar(OmplPlanner):
    """InformedRRTstar that draws in order of promise."""

    name: ClassVar[str] = "SORRTstar"
    specs: ClassVar[PlannerSpecs] = _ANYTIME
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_BIAS, GUIDED, FIRST_PLAN)


class BITstar(OmplPlanner):
    """A heuristic search over batches of states."""

    name: ClassVar[str] = "BITstar"
    specs: ClassVar[PlannerSpecs] = _ANYTIME
    parameters: ClassVar[tuple[Parameter, ...]] = (SAMPLES, FEW_GOAL_STATES, FIRST_PLAN)


class FMT(OmplPlanner):
    """One pass over a given number of states."""

    name: ClassVar[str] = "FMT"
    specs: ClassVar[PlannerSpecs] = _FIRST
    parameters: ClassVar[tuple[Parameter, ...]] = (SAMPLES, FEW_GOAL_STATES)


class KPIECE1(OmplPlanner):
    """A tree that spreads over the object's coordinates."""

    name: ClassVar[str] = "KPIECE1"
    specs: ClassVar[PlannerSpecs] = _FIRST
    # OMPL draws near known states, where the placements hardly ever change: hence the guide.
    parameters: ClassVar[tuple[Parameter, ...]] = (RANGE, GOAL_BIAS, replace(GUIDED, default=0.8))


OMPL_PLANNERS: tuple[type[OmplPlanner], ...] = (
    RRT, RRTConnect, RRTstar, InformedRRTstar, SORRTstar, BITstar, FMT, KPIECE1,
)  # fmt: skip
