"""OMPL's planners on free motion: a start and a goal pose, nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from ompl import geometric as og

import gm_ompl
from gm_ompl.errors import InputError
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.sampling.free_model import coordinates_of
from gm_ompl.sampling.motions import HybridState

SCENARIO = "tasks/placedown"
SOON = ("RRTConnect", "RRTstar", "KPIECE1")


@pytest.mark.parametrize("name", SOON)
def test_plans_hold_and_repeat(name: str) -> None:
    """Same seed and iteration limit, same plan; an independent check confirms it."""
    first, second = (
        gm_ompl.plan(
            SCENARIO, name, seed=2, max_iterations=100,
            parameters={"first_plan": True} if name == "RRTstar" else {},
        )
        for _ in range(2)
    )  # fmt: skip
    assert first.status == "solved"
    assert first.steps == second.steps
    assert gm_ompl.check(first).holds


def _setup(planner: str, seed: int) -> HybridSetup:
    setup = gm_ompl.setup(SCENARIO, seed=seed)
    setup.setPlanner(getattr(og, planner)(setup.getSpaceInformation()))
    return setup


def test_what_is_settled_says_what_it_means() -> None:
    """A sample is changed once, to a state that some hand brings the object to; then it stays."""
    setup, settled = _setup("RRT", 1), 0
    si = setup.getSpaceInformation()
    sampler, state = si.allocStateSampler(), si.allocState()
    for _ in range(5):
        sampler.sampleUniform(state)
        assert setup.codec.said(state) is None
        valid = si.isValid(state)
        said = setup.codec.said(state)
        assert said == setup.codec.read(state)
        assert si.isValid(state) == valid
        assert setup.codec.read(state) == said
        settled += valid
    assert settled > 0


def test_states_written_read_back_in_every_bit() -> None:
    """So a pose that was set is that pose, and not taken for a sample."""
    setup = _setup("RRT", 1)
    for known in setup.draws.goal(), setup.draws.anywhere():
        assert known is not None
        assert setup.codec.said(setup.state(known)) == known
        again = coordinates_of(setup.motions.model.pose(known.q))
        assert np.allclose(again, known.q, atol=1e-5)


def test_goal_states_of_ones_own_are_honoured_or_refused() -> None:
    """The plan ends with the hand that was set; a pose elsewhere is refused by name."""
    setup = _setup("RRTConnect", 3)
    goal = setup.draws.goal()
    assert goal is not None
    with pytest.raises(InputError, match=r"setGoalState: .*motion\.goal"):
        setup.setGoalState(setup.state(HybridState(setup.motions.model.start, goal.placements)))
    setup.setGoalState(setup.state(goal))
    setup.solve(60.0)
    path = setup.solution()
    assert path is not None
    assert path[-1] == goal
    assert gm_ompl.check(gm_ompl.plan_from(setup)).holds


def test_the_projects_own_planners_run_on_the_setup() -> None:
    """HybridRRTConnect under SimpleSetup: the path is the plan's poses, the plan holds."""
    setup = gm_ompl.setup(SCENARIO, "HybridRRTConnect", seed=1)
    setup.solve(60.0)
    plan = gm_ompl.plan_from(setup)
    assert plan.status == "solved"
    assert gm_ompl.check(plan).holds
    assert setup.planner_data().numEdges() >= len(plan.steps)
