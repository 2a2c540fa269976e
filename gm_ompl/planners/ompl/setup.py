"""A problem as OMPL's SimpleSetup: space, validity, directed motions, objective, goal, planner."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, final

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from gm_ompl import clock
from gm_ompl.arguments import positive
from gm_ompl.feasibility.judge import Judge
from gm_ompl.holds.watch import Stop, never
from gm_ompl.planners.ompl.adapter import ExploredTrees, PlainPlanner, offer, planner_data, tree_of
from gm_ompl.planners.ompl.callbacks import (
    DirectedMotions,
    GoalRegion,
    Guard,
    NodeValidity,
    ObjectProjection,
    PlanCost,
)
from gm_ompl.planners.ompl.convert import longest_motion
from gm_ompl.planners.ompl.ends import EXACTLY, given_goal, given_start
from gm_ompl.planners.ompl.parts import parts_of
from gm_ompl.planners.ompl.shortcuts import shortcut
from gm_ompl.planners.ompl.table import OMPL_PLANNERS, refuse_unsound
from gm_ompl.planners.planner import Planner, SearchResult, Status
from gm_ompl.sampling.motions import HybridState

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
        shortcuts: whether ``solve`` takes the short cuts of the path that OMPL's planner found.
        spent: wall time of all runs [s].
    """

    def __init__(self, judge: Judge, rng: np.random.Generator) -> None:
        seed_ompl(rng)
        made, guard = parts_of(judge, rng), Guard()
        space, codec = made.space, made.codec
        super().__init__(space)
        self.judge, self.codec, self.guard = judge, codec, guard
        self.motions, self.draws = made.motions, made.draws
        self.scenario: dict[str, Any] | None = None
        self.seed: int | None = None
        self.shortcuts, self.spent = True, 0.0
        self._used, self._parameters = "", dict[str, Any]()
        si = self.getSpaceInformation()
        self.setStateValidityChecker(NodeValidity(si, codec, self.motions, guard))
        si.setMotionValidator(DirectedMotions(si, codec, self.motions, guard))
        self.setOptimizationObjective(PlanCost(si, codec, self.motions, guard))
        space.registerDefaultProjection(ObjectProjection(space, codec, guard))
        super().addStartState(self.state(codec.start))
        self.offer_goals()

    def state(self, meaning: HybridState) -> Any:
        """Return a new state of OMPL's that means ``meaning``."""
        made = self.getSpaceInformation().allocState()
        self.codec.write(made, meaning)
        return made

    def clearStartStates(self) -> None:
        """Forget all start states, the scenario's own included."""
        super().clearStartStates()
        self.motions.starts.clear()

    def addStartState(self, state: Any) -> None:
        """Add a start state: the object as the scenario starts, fingers placed or not yet.

        Raises:
            InputError: no plan of the scenario can begin there.
        """
        self._add_start(given_start(self.codec, self.motions.model, state, "addStartState"))

    def setStartState(self, state: Any) -> None:
        """Set the only start state, see ``addStartState``."""
        start = given_start(self.codec, self.motions.model, state, "setStartState")
        self.clearStartStates()
        self._add_start(start)

    def _add_start(self, start: HybridState) -> None:
        self.motions.starts.add(start)
        super().addStartState(self.state(start))

    def setGoalState(self, state: Any, threshold: float = EXACTLY) -> None:
        """Set the only goal state: the object in the scenario's goal, all fingers placed.

        Args:
            state: the goal state.
            threshold: how far from it, in the space's distance, OMPL's planners may end.

        Raises:
            InputError: no plan of the scenario can end there.
        """
        goal = given_goal(self.codec, self.motions.model, state, "setGoalState")
        super().setGoalState(self.state(goal), threshold)

    def setStartAndGoalStates(self, start: Any, goal: Any, threshold: float = EXACTLY) -> None:
        """Set the only start state and the only goal state."""
        self.setStartState(start)
        self.setGoalState(goal, threshold)

    def offer_goals(self, count: int | None = None, elsewhere: float = 0.0) -> None:
        """Set the goal region; see ``GoalRegion`` for the arguments.

        BITstar and FMT take all of the goal states before they begin.
        """
        si, most = self.getSpaceInformation(), self.draws.goals if count is None else count
        self.setGoal(GoalRegion(si, self.codec, self.draws, self.guard, most, elsewhere))

    def use(self, planner: Planner, goals: int | None = None) -> None:
        """Set one of gm_ompl's planners: OMPL's own by their names, others through an adapter.

        Args:
            planner: the planner, with its settings.
            goals: goal states to offer; None: as the planner is set.
        """
        if planner.name in OMPL_PLANNERS:
            made = self._configured(planner.name, planner.settings, goals)
        else:
            made = PlainPlanner(
                self.getSpaceInformation(),
                planner, self.judge, self.codec, self.guard, self.draws.rng,
            )  # fmt: skip
        self._used, self._parameters = made.getName(), planner.settings
        self.setPlanner(made)

    def _configured(self, name: str, settings: Mapping[str, Any], goals: int | None) -> Any:
        """Return OMPL's planner ``name`` as set; changes the goal to suit it."""
        planner = getattr(og, name)(self.getSpaceInformation())
        if "range_share" in settings:
            planner.setRange(settings["range_share"] * longest_motion(self.getStateSpace()))
        if "samples" in settings:
            many = planner.setNumSamples if name == "FMT" else planner.setSamplesPerBatch
            many(settings["samples"])
        self.shortcuts = settings["shortcuts"]
        if settings.get("first_plan"):
            self.stop_at_first_plan()
        if "guided_share" in settings:
            # Goal states and guided states come through the goal region, the rest from OMPL.
            goal_bias, guided = settings["goal_bias"], settings["guided_share"]
            share = goal_bias + guided - goal_bias * guided
            planner.setGoalBias(share)
            self.offer_goals(ENDLESS, 0.0 if share == 0.0 else 1.0 - goal_bias / share)
        else:
            self.offer_goals(goals or settings["goal_states"])
        return planner

    def stop_at_first_plan(self) -> None:
        """Let planners that improve their plan end with the first one."""
        self.getOptimizationObjective().setCostThreshold(ob.Cost(math.inf))

    def solve(self, time: Any = 1.0, *, ptc: Stop | None = None) -> Any:
        """Run the planner, then take the short cuts of its path if ``shortcuts``.

        An exception in a callback ends the run and is raised here.

        Args:
            time: seconds, or OMPL's termination condition.
            ptc: OMPL's termination condition, by its name in OMPL.

        Raises:
            InputError: the time is no positive number.
            UnsoundPlannerError: the planner ignores that motions are one-way.
        """
        condition = time if ptc is None else ptc
        over = condition if callable(condition) else _after(positive("time", time, "seconds"))
        status = self.run(over, None if callable(condition) else over)
        if self.shortcuts:
            self.shorten(over)
        return status

    def simplifySolution(self, limit: Any = 0.0) -> None:
        """Take the short cuts of the path that was found: never dearer, the same states.

        Args:
            limit: seconds, 0 for as long as it takes, or OMPL's termination condition.
        """
        if callable(limit):
            self.shorten(limit)
        else:
            self.shorten(_after(positive("duration", limit, "seconds")) if limit else never)

    def shorten(self, stop: Stop) -> None:
        """Replace the path that was found by the cheapest through its states; ``stop`` ends it.

        Paths of gm_ompl's own planners stay: those planners judge and refine them.
        """
        states = self.solution()
        if states is None or isinstance(self.getPlanner(), PlainPlanner):
            return
        found = [self.state(state) for state in shortcut(self.motions, states, stop)]
        pdef, name = self.getProblemDefinition(), self.getSolutionPlannerName()
        offer(self.getSpaceInformation(), pdef, found, name)

    def run(self, stop: Stop, give_up: Stop | None = None) -> Any:
        """Run the planner until ``stop``; callbacks cut their work short where ``give_up``.

        Raises:
            UnsoundPlannerError: the planner ignores that motions are one-way.
        """
        refuse_unsound(self.getPlanner())
        self.guard.watch(give_up)
        self.motions.hurried = _without_plan(self.getPlanner())
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

    def getSolutionPath(self) -> Any:
        """Return a copy of the solution path: OMPL's own ends with the next ``clear``."""
        return og.PathGeometric(super().getSolutionPath())

    def solution(self) -> list[HybridState] | None:
        """Return the states of the exact solution path, or None without one."""
        if not self.getProblemDefinition().hasExactSolution():
            return None
        path = self.getSolutionPath()
        return [self.codec.read(path.getState(k)) for k in range(path.getStateCount())]

    def explored(self) -> ExploredTrees:
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


def _after(seconds: float) -> Stop:
    """Return what says whether so many seconds have passed from now."""
    ends = clock.now() + seconds
    return lambda: clock.now() >= ends


def _without_plan(planner: Any) -> Stop:
    """Return what says whether a planner that rewires its tree has no plan yet."""
    if not isinstance(planner, og.RRTstar):
        return never
    return lambda: not math.isfinite(planner.bestCost().value())
