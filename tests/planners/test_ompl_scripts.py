"""Programs as OMPL's tutorials write them: constructors, states and times of their own."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from typing import Any

import pytest
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

import gm_ompl
from gm_ompl.errors import InputError, PathError
from gm_ompl.planners.ompl.convert import longest_motion
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.sampling.motions import UNPLACED, HybridState

SMALL = ["fingers.placements.grid=[3, 3]", "lattice.segments=6"]
PLANNERS = ("RRT", "RRTConnect", "RRTstar", "BITstar")
SEEDS = 3


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    yield
    ou.setLogLevel(level)


def _made(scenario: gm_ompl.Scenario, planner: str, seed: int) -> HybridSetup:
    """Return a setup with a planner as its constructor makes it."""
    setup = gm_ompl.setup(scenario, seed=seed)
    setup.setPlanner(getattr(og, planner)(setup.getSpaceInformation()))
    return setup


@functools.cache
def _tumble() -> tuple[gm_ompl.Scenario, float]:
    """Return a small scenario and what its cheapest plan costs."""
    scenario = gm_ompl.load(
        "paper/tumble", ["fingers.placements.grid=[3, 3]", "lattice.segments=4"]
    )
    return scenario, gm_ompl.plan(scenario).cost or math.nan


@pytest.mark.parametrize("planner", PLANNERS)
def test_planners_as_constructed_find_cheap_plans(planner: str) -> None:
    """Without a range nearly all seeds give a plan that holds; half are at most 3 optima dear."""
    scenario, optimum = _tumble()
    costs = []
    for seed in range(SEEDS):
        setup = _made(scenario, planner, seed)
        setup.stop_at_first_plan()
        asked = itertools.count()
        setup.solve(ob.PlannerTerminationCondition(lambda asked=asked: next(asked) >= 2000))
        plan = gm_ompl.plan_from(setup)
        costs.append(math.inf if plan.cost is None else plan.cost)
    assert gm_ompl.check(plan).holds
    assert sorted(costs)[SEEDS // 2] <= 3.0 * optimum


def test_the_automatic_range_cuts_no_motion_short() -> None:
    """What OMPL takes for the longest motion is more than any two states are apart."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRT", 0)
    setup.setup()
    space = setup.getStateSpace()
    assert setup.getPlanner().getRange() == pytest.approx(longest_motion(space))
    last = len(setup.judge.problem.fingers.placements) - 1
    ends = (HybridState((0.0,), (UNPLACED, UNPLACED)), HybridState((1.0,), (last, last)))
    farthest = space.distance(*(setup.state(end) for end in ends))
    assert 0.98 < farthest / longest_motion(space) < 1.0


def test_times_are_given_as_to_ompl() -> None:
    """By position, by name, as a condition; what is no time is named."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRTConnect", 1)
    ends = ob.PlannerTerminationCondition(lambda: False)
    ways: list[tuple[tuple[Any, ...], dict[str, Any]]] = [
        ((60.0,), {}), ((), {"time": 60.0}), ((60,), {}), ((), {"ptc": ends}), ((ends,), {}),
    ]  # fmt: skip
    for given, named in ways:
        assert setup.solve(*given, **named)
        assert setup.haveExactSolutionPath()
        setup.clear()
    for wrong in (0.0, "long", None):
        with pytest.raises(InputError, match="time"):
            setup.solve(wrong)


def test_start_and_goal_states_are_honoured() -> None:
    """The plan begins and ends with the placements of the states that were set."""
    scenario = gm_ompl.load("paper/push", SMALL)
    setup = _made(scenario, "RRTConnect", 3)
    begin, end = setup.draws.hand((0.0,)), setup.draws.goal()
    assert begin is not None
    assert end is not None
    setup.setStartAndGoalStates(setup.state(HybridState((0.0,), begin)), setup.state(end))
    setup.solve(60.0)
    path = setup.solution()
    assert path is not None
    assert (path[0].placements, path[-1]) == (begin, end)
    plan = gm_ompl.plan_from(setup)
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds
    table = setup.judge.problem.fingers.placements
    cells = [(table.labels[table.face[row]], tuple(table.cell[row].tolist())) for row in begin]
    assert [(place.face, place.cell) for place in plan.steps[0].placements] == cells


def test_other_starts_may_be_added() -> None:
    """A second start is one more root; the first remains."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRT", 3)
    begin = setup.draws.hand((0.0,))
    assert begin is not None
    setup.addStartState(setup.state(HybridState((0.0,), begin)))
    assert setup.getProblemDefinition().getStartStateCount() == 2
    setup.solve(60.0)
    assert gm_ompl.check(gm_ompl.plan_from(setup)).holds


def test_states_that_do_not_fit_the_scenario_are_refused() -> None:
    """Each message names the method, what is wrong, and the key of the scenario to change."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRTConnect", 3)
    hand, goal = setup.draws.hand((0.0,)), setup.draws.goal()
    assert hand is not None
    assert goal is not None
    unplaced = (UNPLACED, UNPLACED)
    for method, q, placements, message in (
        (setup.setStartState, 0.5, hand, "setStartState: the object is at .0.5.*motion.start"),
        (setup.addStartState, 0.0, (0, 0), "addStartState: placements .* penetrate"),
        (setup.setStartState, 0.0, (0, 10_000), "placement 10001: must be 0 .* to"),
        (setup.setGoalState, 0.5, goal.placements, "setGoalState: .*not in the scenario's goal"),
        (setup.setGoalState, 1.0, unplaced, "finger 0 has no placement"),
        (setup.setGoalState, 1.0, (0, 0), "setGoalState: placements .* penetrate"),
    ):
        with pytest.raises(InputError, match=message):
            method(setup.state(HybridState((q,), placements)))
    assert setup.getProblemDefinition().getStartStateCount() == 1


def test_starts_set_past_the_setup_are_found_out() -> None:
    """A start set on the problem definition is checked when the path becomes a plan."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRT", 3)
    hand = setup.draws.hand((0.5,))
    assert hand is not None
    pdef = setup.getProblemDefinition()
    pdef.clearStartStates()
    pdef.addStartState(setup.state(HybridState((0.5,), hand)))
    setup.solve(60.0)
    with pytest.raises(PathError, match="does not begin at a start: the object is at"):
        gm_ompl.plan_from(setup)


@pytest.mark.parametrize("what", ["start", "goal"])
def test_the_projects_own_planners_refuse_states_of_ones_own(what: str) -> None:
    """They plan what the scenario says, and say so."""
    setup = gm_ompl.setup(gm_ompl.load("paper/push", SMALL), "astar")
    hand, goal = setup.draws.hand((0.0,)), setup.draws.goal()
    assert hand is not None
    assert goal is not None
    if what == "start":
        setup.setStartState(setup.state(HybridState((0.0,), hand)))
    else:
        setup.setGoalState(setup.state(goal))
    with pytest.raises(InputError, match=f"astar plans .* {what} state .*fingers.{what}"):
        setup.solve(60.0)


def test_short_cuts_are_never_dearer_and_can_be_left_out() -> None:
    """With the same seed the path after short cuts costs at most what it cost before."""
    (scenario, _), saved = _tumble(), 0
    for seed in range(3):
        setup = _made(scenario, "RRT", seed)
        setup.shortcuts = False
        setup.solve(60.0)
        before = setup.solution()
        assert before is not None
        long = gm_ompl.plan_from(setup).cost
        setup.simplifySolution()
        after = setup.solution()
        assert after is not None
        short = gm_ompl.plan_from(setup).cost
        assert long is not None
        assert short is not None
        assert (after[0], after[-1]) == (before[0], before[-1])
        assert short <= long * (1.0 + 1e-9)
        saved += short < long
    assert saved > 0


def test_a_path_outlives_clear() -> None:
    """OMPL's own path ends with ``clear``; reading it later ended the process."""
    setup = _made(gm_ompl.load("paper/push", SMALL), "RRTConnect", 1)
    setup.solve(60.0)
    path, states = setup.getSolutionPath(), setup.solution()
    setup.clear()
    read = [setup.codec.read(path.getState(k)) for k in range(path.getStateCount())]
    assert read == states
