"""A problem as OMPL's SimpleSetup: space, validity, directed motions, objective, goal, planner."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from gm_ompl import clock
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl.adapter import Explored, PlainPlanner, planner_data, tree_of
from gm_ompl.planners.ompl.callbacks import (
    DirectedMotions,
    GoalRegion,
    Guard,
    NodeValidity,
    ObjectProjection,
    PlanCost,
)
from gm_ompl.planners.ompl.convert import Codec, make_space
from gm_ompl.planners.ompl.motions import Motions, StateDraws
from gm_ompl.planners.ompl.table import OMPL_PLANNERS, refuse_unsound
from gm_ompl.planners.planner import Planner, SearchResult, Status
from gm_ompl.sampling.motions import ContinuousModel, HybridState

GOAL_STATES = 100
"""Goal states that planners may draw; BITstar and FMT take all of them before they begin."""

ENDLESS = 2**31 - 1
"""The largest number of goal samples that OMPL can be told of."""

MAX_SEED = 2**31 - 1


def seed_ompl(rng: np.random.Generator) -> None:
    """Seed OMPL's generators, which are global; call it before space and planner are built."""
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)  # seeding twice is reported as an error, and works
    ou.RNG.setSeed(int(rng.integers(1, MAX_SEED)))
    ou.setLogLevel(level)


@final
class HybridSetup(og.SimpleSetup):
    """OMPL's SimpleSetup for a manipulation problem, complete but for the planner.

    Args:
        judge: answers about the problem.
        rng: of the states drawn in Python; OMPL's own generators are seeded from it, too.

    Attributes:
        judge: likewise.
        codec: from OMPL's states to coordinates and placements, and back.
        motions: what each motion consists of.
        draws: random states.
        guard: keeps exceptions from callbacks.
        scenario: the scenario as resolved, or None; for ``plan_from``.
        seed: what the setup was seeded with, or None.
        spent: wall time of all runs [s].
    """

    def __init__(self, judge: Judge, rng: np.random.Generator) -> None:
        seed_ompl(rng)
        codec, guard = Codec(judge.problem), Guard()
        space = make_space(judge.problem)
        super().__init__(space)
        self.judge, self.codec, self.guard = judge, codec, guard
        self.motions = Motions(ContinuousModel(judge.problem, judge), codec.start)
        self.draws = StateDraws(self.motions, rng)
        self.scenario: dict[str, Any] | None = None
        self.seed: int | None = None
        self.spent = 0.0
        self._used, self._parameters = "", dict[str, Any]()
        si = self.getSpaceInformation()
        self.setStateValidityChecker(NodeValidity(si, codec, self.motions, guard))
        si.setMotionValidator(DirectedMotions(si, codec, self.motions, guard))
        self.setOptimizationObjective(PlanCost(si, codec, self.motions, guard))
        space.registerDefaultProjection(ObjectProjection(space, codec, guard))
        start = si.allocState()
        codec.write(start, codec.start)
        self.setStartState(start)
        self.offer_goals()

    def offer_goals(self, count: int = GOAL_STATES, elsewhere: float = 0.0) -> None:
        """Set the goal region; see ``GoalRegion`` for the arguments."""
        si = self.getSpaceInformation()
        self.setGoal(GoalRegion(si, self.codec, self.draws, self.guard, count, elsewhere))

    def use(self, planner: Planner) -> None:
        """Set one of gm_ompl's planners: OMPL's own by their names, others through an adapter."""
        if planner.name in OMPL_PLANNERS:
            made = self._configured(planner.name, planner.settings)
        else:
            made = PlainPlanner(
                self.getSpaceInformation(),
                planner, self.judge, self.codec, self.guard, self.draws.rng,
            )  # fmt: skip
        self._used, self._parameters = made.getName(), planner.settings
        self.setPlanner(made)

    def _configured(self, name: str, settings: Mapping[str, Any]) -> Any:
        """Return OMPL's planner ``name`` as set; changes the goal to suit it."""
        planner = getattr(og, name)(self.getSpaceInformation())
        if "range_share" in settings:
            planner.setRange(settings["range_share"] * self.getStateSpace().getMaximumExtent())
        if "samples" in settings:
            many = planner.setNumSamples if name == "FMT" else planner.setSamplesPerBatch
            many(settings["samples"])
        if settings.get("first_plan"):
            self.stop_at_first_plan()
        if "guided_share" in settings:
            # Goal states and guided states come through the goal region, the rest from OMPL.
            goal_bias, guided = settings["goal_bias"], settings["guided_share"]
            share = goal_bias + guided - goal_bias * guided
            planner.setGoalBias(share)
            self.offer_goals(ENDLESS, 0.0 if share == 0.0 else 1.0 - goal_bias / share)
        else:
            self.offer_goals(settings["goal_states"])
        return planner

    def stop_at_first_plan(self) -> None:
        """Let planners that improve their plan end with the first one."""
        self.getOptimizationObjective().setCostThreshold(ob.Cost(math.inf))

    def solve(self, limit: Any = 1.0) -> Any:
        """Run the planner; an exception in a callback ends the run and is raised here.

        Args:
            limit: seconds, or OMPL's termination condition.

        Raises:
            UnsoundPlannerError: the planner ignores that motions are one-way.
        """
        if callable(limit):
            return self.run(limit)
        ends = clock.now() + float(limit)
        return self.run(lambda: clock.now() >= ends, lambda: clock.now() >= ends)

    def run(self, stop: Callable[[], bool], give_up: Callable[[], bool] | None = None) -> Any:
        """Run the planner until ``stop``; callbacks cut their work short where ``give_up``.

        Raises:
            UnsoundPlannerError: the planner ignores that motions are one-way.
        """
        refuse_unsound(self.getPlanner())
        self.guard.watch(give_up)
        started = clock.now()
        finished = self.guard.finished
        status = super().solve(ob.PlannerTerminationCondition(lambda: finished(stop)))
        self.spent += clock.now() - started
        self.guard.settle()
        return status

    def ending(self) -> SearchResult:
        """Return what the planner knows of how its run ended, where it is one of gm_ompl's own."""
        planner = self.getPlanner()
        known = planner.result if isinstance(planner, PlainPlanner) else None
        return known or SearchResult(Status.BUDGET)

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of the planner where it was set by ``use`` and still is."""
        return self._parameters if self.getPlanner().getName() == self._used else {}

    def solution(self) -> list[HybridState] | None:
        """Return the states of the exact solution path, or None without one."""
        if not self.getProblemDefinition().hasExactSolution():
            return None
        path = og.PathGeometric(self.getSolutionPath())
        return [self.codec.read(path.getState(k)) for k in range(path.getStateCount())]

    def explored(self) -> Explored:
        """Return what the planner explored, in gm_ompl's own terms."""
        planner = self.getPlanner()
        if isinstance(planner, PlainPlanner):
            return planner.tree()
        raw = ob.PlannerData(self.getSpaceInformation())
        self.getPlannerData(raw)
        return tree_of(raw, self.codec)

    def planner_data(self) -> Any:
        """Return what the planner explored as OMPL's ``PlannerData``, weights by our costs.

        Of searches on the lattice it is the plan that was found. Edges lead in the direction of
        execution, also in a tree that grew from the goal, whose vertices have the tag 2. The data
        is a copy: it outlives the planner.
        """
        tree = self.explored()
        return planner_data(self.getSpaceInformation(), self.codec, self.motions, tree)
