"""OMPL's planners and its SimpleSetup on manipulation problems."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from ompl import geometric as og
from ompl import util as ou

import gm_ompl
from gm_ompl.errors import UnsoundPlannerError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.lattice import Goal
from gm_ompl.planners.ompl.table import OMPL_PLANNERS, UNSOUND
from gm_ompl.planners.planner import Budget, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.sampling.motions import CoordinateModel
from gm_ompl.scenario.load import load

SMALL = ["fingers.placements.grid=[3, 3]", "lattice.segments=4"]
NAMES = list(OMPL_PLANNERS)


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    level = ou.getLogLevel()
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    yield
    ou.setLogLevel(level)


@pytest.mark.parametrize("name", NAMES)
def test_plans_hold_and_repeat(name: str) -> None:
    """Same seed and iteration limit, same plan; an independent check confirms it."""
    scenario = gm_ompl.load("paper/push", SMALL)
    first, second = (
        gm_ompl.plan(scenario, name, seed=2, max_iterations=_limit(name), parameters=_quick(name))
        for _ in range(2)
    )
    assert first.status == "solved"
    assert first.steps == second.steps
    assert first.statistics.expanded == second.statistics.expanded
    assert first.statistics.expanded <= _limit(name) + 2
    assert not first.optimal
    report = gm_ompl.check(first)
    assert report.holds, report


CUT_SHORT = """
import gm_ompl
scenario = gm_ompl.load("random/chain/53")
for k in range(6):
    plan = gm_ompl.plan(scenario, {name!r}, time_limit=0.2 + 0.1 * k, seed=k)
    assert plan.status in ("solved", "budget")
"""


@pytest.mark.parametrize("name", ["FMT", "BITstar"])
def test_a_time_limit_kills_no_process(name: str) -> None:
    """Ended while it still takes in its samples; FMT once freed states twice then."""
    ran = subprocess.run(
        [sys.executable, "-P", "-c", CUT_SHORT.format(name=name)], capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr


def _limit(name: str) -> int:
    return 150 if name == "BITstar" else 400  # its iterations are long


def _quick(name: str) -> dict[str, Any]:
    return {"samples": 40} if name in ("FMT", "BITstar") else {}


@pytest.mark.parametrize("name", ["RRTConnect", "RRTstar"])
def test_planar_plans_hold(name: str) -> None:
    """With a circular coordinate, too, a plan holds and ends in the goal."""
    plan = gm_ompl.plan("planar/turn", name, seed=1, max_iterations=50)
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds


def test_improving_planners_note_falling_costs() -> None:
    """RRTstar's history falls to the plan's cost; without any limit the first plan is enough."""
    scenario = gm_ompl.load("paper/push", SMALL)
    plan = gm_ompl.plan(scenario, "RRTstar", seed=3, max_iterations=200)
    costs = [cost for _, cost, _ in plan.statistics.history if cost is not None]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] == pytest.approx(plan.cost, rel=1e-9)
    assert gm_ompl.plan(scenario, "RRTstar", seed=3).status == "solved"


@pytest.mark.parametrize("name", sorted(UNSOUND))
def test_unsound_planners_are_refused_by_name(name: str) -> None:
    """A planner that ignores the direction of motions is bad input, with the reason."""
    with pytest.raises(UnsoundPlannerError, match=name):
        gm_ompl.plan("paper/slide", name)


def test_unsound_objects_are_refused_before_they_run() -> None:
    """So are OMPL's objects, and settings that make a sound planner unsound."""
    setup = gm_ompl.setup(gm_ompl.load("paper/push", SMALL))
    si = setup.getSpaceInformation()
    star, tree = og.RRTstar(si), og.RRT(si)
    star.setDelayCC(False)
    tree.setIntermediateStates(True)
    for planner in (og.PRM(si), og.BKPIECE1(si), star, tree):
        setup.setPlanner(planner)
        with pytest.raises(UnsoundPlannerError):
            setup.solve(0.01)
        with pytest.raises(UnsoundPlannerError):
            gm_ompl.plan_from(setup)


def test_plan_from_takes_its_own_setups_alone() -> None:
    """A SimpleSetup made elsewhere has no scenario to plan."""
    setup = gm_ompl.setup("paper/slide")
    with pytest.raises(gm_ompl.InputError, match="SimpleSetup"):
        gm_ompl.plan_from(og.SimpleSetup(setup.getSpaceInformation()))
    assert gm_ompl.plan_from(setup).status == "budget"  # not solved yet


def test_no_valid_goal_placement_is_proof() -> None:
    """A randomised planner says infeasible only where start or goal admits no placements."""
    problem = load("paper/slide", SMALL).problem
    high = Goal((1.0,), (1.0,), (None,))
    hand = dataclasses.replace(problem.fingers, goal=(4, 4))  # both at one place
    impossible = dataclasses.replace(problem, fingers=hand, goal=high)
    judge = Judge(impossible, make_backend(impossible))
    result = make_planner("RRT").solve(
        impossible, judge, Budget(max_iterations=5), np.random.default_rng(0)
    )
    assert result.status is Status.INFEASIBLE
    weak = gm_ompl.load("paper/push", [*SMALL, "fingers.max_normal_force=0.01"])
    assert gm_ompl.plan(weak, "RRTConnect", max_iterations=50).status == "budget"


@pytest.mark.parametrize("name", ["RRTConnect", "RRTstar", "BITstar", "KPIECE1", "astar"])
@pytest.mark.parametrize("error", [ZeroDivisionError("a bug"), KeyboardInterrupt()])
def test_exceptions_in_callbacks_end_the_run_with_their_own_message(
    name: str, error: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bug in the model surfaces as itself; an interrupt ends the search."""

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(CoordinateModel, "displacement", fail)
    monkeypatch.setattr(Judge, "rest", fail)
    setup = gm_ompl.setup(gm_ompl.load("paper/push", SMALL), name)
    if name == "astar":  # asks the judge, not the model
        monkeypatch.setattr(Judge, "node", fail)
    if name == "astar" and isinstance(error, KeyboardInterrupt):
        setup.solve(5.0)
        assert gm_ompl.plan_from(setup).status == "interrupted"
        return
    with pytest.raises(type(error)) as met:
        setup.solve(5.0)
    assert met.value is error


def test_an_interrupt_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C inside a callback gives the status interrupted."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(CoordinateModel, "displacement", interrupt)
    plan = gm_ompl.plan(gm_ompl.load("paper/push", SMALL), "RRTConnect", max_iterations=50)
    assert plan.status == "interrupted"


def test_lattice_search_runs_under_simple_setup() -> None:
    """A* on the setup gives the plan that it gives alone, its proof included."""
    scenario = gm_ompl.load("paper/push", SMALL)
    setup = gm_ompl.setup(scenario, "astar")
    setup.solve(60.0)
    assert setup.getSolutionPath().check()
    plan, alone = gm_ompl.plan_from(setup), gm_ompl.plan(scenario)
    assert plan.optimal
    assert plan.cost == pytest.approx(alone.cost, rel=1e-9)
    assert gm_ompl.check(plan).holds


@pytest.mark.parametrize("name", ["RRTConnect", "RRTstar", "astar"])
def test_planner_data_outlives_its_planner(name: str) -> None:
    """Vertices, edges, start and goal can be read after the setup is cleared."""
    setup = gm_ompl.setup(gm_ompl.load("paper/push", SMALL), name, seed=1)
    setup.solve(2.0)
    data = setup.planner_data()
    setup.clear()
    assert data.numStartVertices() == 1
    assert data.numGoalVertices() >= 1
    assert data.numEdges() >= 1
    states = [setup.codec.read(data.getVertex(k).getState()) for k in range(data.numVertices())]
    assert states.count(setup.codec.start) == 1
    assert "weight" in data.printGraphML()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"range": 0.5}, "did you mean 'range_share'"),
        ({"guided": 0.5}, "did you mean 'guided_share'"),
        ({"range_share": 2.0}, "from 0.001 to 1"),
        ({"range_share": True}, "a number"),
        ({"goal_bias": "often"}, "a number"),
        ({"first_plan": 1}, "true or false"),
    ],
)
def test_wrong_parameters_are_named(given: dict[str, object], message: str) -> None:
    """A parameter that is unknown, of the wrong type or out of range is bad input."""
    with pytest.raises(gm_ompl.InputError, match=message):
        make_planner("RRTstar", given)


def test_the_command_prints_nothing_of_ompl() -> None:
    """On the command line OMPL neither logs nor reports leaks at exit."""
    command = [sys.executable, "-P", "-m", "gm_ompl", "plan", "paper/push", "--planner", "KPIECE1"]
    limits = ["--max-iterations", "30", "--set", "fingers.placements.grid=[3, 3]", "--json"]
    done = subprocess.run(
        [*command, *limits], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode in (0, 4)
    assert json.loads(done.stdout)["planner"] == "KPIECE1"
    for word in ("nanobind", "Info:", "Debug:", "Warning:"):
        assert word not in done.stdout + done.stderr
