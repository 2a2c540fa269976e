"""Plans without regrasping, all sets of placements at once: against the search over lanes."""

from __future__ import annotations

import dataclasses
import math
from unittest import mock

import pytest

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph.closure import Closure
from gm_ompl.planners import free_search
from gm_ompl.planners.free_search import FreeSearch
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, SearchResult, Status, silent
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.kept import kept, lanes

SMALL = (
    ("tasks/reorient", ("fingers.placements.grid=[2, 2]",)),
    ("tasks/placedown", ("fingers.placements.grid=[2, 3]",)),
    ("tasks/reorient", ("fingers.placements.grid=[3, 3]", "cost.samples_at=ends")),
    ("tasks/pick-card-soft", ("motion.goal.position=[0.75, 0, 0.25]", "motion.goal.rotation=any")),
    ("free/out-of-the-corner", ()),
    ("free/l-bracket", ()),
    ("random/free/3", ()),
    ("random/free-clutter/3", ()),
)


@pytest.mark.parametrize(("name", "changes"), SMALL)
def test_the_lanes_find_the_same(name: str, changes: tuple[str, ...]) -> None:
    """It has the optimum where plans that regrasp cannot be cheaper, and never bounds too high."""
    problem = load(name, changes).problem
    other = lanes(problem)
    assert other.cost is not None
    optimum, search = other.cost, kept(problem, other.cost * 1.0001)
    assert other.optimal
    assert search.bound <= optimum * (1.0 + 1e-9)
    assert search.cost >= optimum * (1.0 - 1e-9)
    if search.proves(optimum):
        assert search.cost == pytest.approx(optimum, rel=1e-9)
    moves = search.moves()
    assert math.fsum(move.cost for move in moves) == pytest.approx(search.cost) or not moves


def test_what_is_enough_ends_it() -> None:
    """No plan is cheaper than the bound that it ends with."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    whole = kept(problem)
    search = kept(problem, 0.9 * whole.cost)
    assert search.cost == math.inf
    assert search.bound == pytest.approx(0.9 * whole.cost)
    assert search.expanded < whole.expanded


def searched(problem: Problem, kept: mock.Mock) -> SearchResult:
    """What lanes find beside a search that stands in for the one without regrasping."""
    judge = Judge(problem, KernelBackend(problem))
    with mock.patch.object(KeptSearch, "of", return_value=kept):
        return FreeSearch(problem, judge, Log(Budget().start(), judge), silent).run()


def test_a_search_that_is_done_gives_its_bound() -> None:
    """A plan that costs just as much as those that regrasp must is proven, without another look."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    cheapest = lanes(problem)
    assert cheapest.cost is not None
    dear = dataclasses.replace(
        cheapest, cost=2.0 * cheapest.cost, lower_bound=0.0, optimal=False
    )  # so that the part found may be left for less
    done = mock.Mock(done=True, bound=dear.cost, cost=math.inf, poses=1, expanded=0)
    part = mock.Mock(exhausted=True)
    part.run.return_value = dear
    with (
        mock.patch.object(free_search, "FEW_NODES", 0),
        mock.patch.object(free_search, "part_search", return_value=part),
    ):
        found = searched(problem, done)
    assert found.optimal
    assert found.lower_bound == dear.cost
    assert part.run.call_count == 1


def test_what_a_limit_ends_tells_its_time() -> None:
    """Where nothing was found yet, the time that was spent is told all the same."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    with mock.patch.object(Closure, "to_goal", side_effect=LimitError("enough")):
        found = searched(problem, mock.Mock())
    assert found.statistics["ended_by"] == "enough"
    assert found.statistics["time_s"] > 0.0


@pytest.mark.parametrize("name", ["tasks/reorient", "free/l-bracket"])
def test_turns_change_nothing(name: str) -> None:
    """Where lanes pause after every lane, and the other search has its turn, it ends the same."""
    problem = load(name, ("fingers.placements.grid=[3, 3]",)).problem
    with mock.patch.object(free_search, "TURN", 0.0):
        judge = Judge(problem, KernelBackend(problem))
        found = FreeSearch(problem, judge, Log(Budget().start(), judge), silent).run()
    whole = lanes(problem)
    assert found.status is whole.status
    assert found.optimal
    assert found.cost == pytest.approx(whole.cost, rel=1e-9)


def test_what_is_not_reached_yet_bounds_all_plans() -> None:
    """Where time ends before the goal was met, the nearest node that is left gives a bound."""
    problem = load("tasks/step-over").problem
    judge = Judge(problem, KernelBackend(problem))
    with mock.patch.object(KeptSearch, "of", return_value=None):
        found = FreeSearch(problem, judge, Log(Budget(1.0).start(), judge), silent).run()
    assert found.cost is None
    assert found.lower_bound > 4.0


def test_ctrl_c_ends_what_would_have_paused() -> None:
    """What is interrupted when its turn is over ends the search all the same."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    stopped = dataclasses.replace(lanes(problem), status=Status.INTERRUPTED, optimal=False)
    part = mock.Mock(exhausted=False)
    part.run.return_value = stopped
    with (
        mock.patch.object(free_search, "TURN", 0.0),
        mock.patch.object(free_search, "part_search", return_value=part),
        mock.patch.object(Closure, "to_goal", return_value=1.0),
    ):
        found = searched(problem, mock.Mock(done=True, bound=0.0, cost=math.inf, expanded=0))
    assert found.status is Status.INTERRUPTED
    assert part.run.call_count == 1
