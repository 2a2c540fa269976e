"""Plans without regrasping, all sets of placements at once: against the search over lanes."""

from __future__ import annotations

import dataclasses
import itertools
import math
from unittest import mock

import pytest

from gm_ompl.errors import LimitError
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.graph import kept_graph, kept_room
from gm_ompl.graph.closure import Closure
from gm_ompl.planners import free_search
from gm_ompl.planners.free_search import FreeSearch
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.lane_parts import cheaper
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget, Meter, SearchResult, Status, silent
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
        found = searched(problem, mock.Mock(done=True, bound=0.0, cost=math.inf, expanded=0))
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


def test_a_limit_ends_what_would_have_paused() -> None:
    """What breaks lanes off when their turn is over ends the search: they are not gone on with."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    broken = dataclasses.replace(
        lanes(problem), status=Status.BUDGET, cost=None, moves=(), optimal=False, lower_bound=1.0
    )
    part = mock.Mock(exhausted=False)
    part.run.side_effect = [broken, AssertionError("gone on with")]
    with (
        mock.patch.object(free_search, "TURN", 0.0),
        mock.patch.object(free_search, "part_search", return_value=part),
        mock.patch.object(Closure, "to_goal", return_value=1.0),
    ):
        found = searched(problem, mock.Mock(done=True, bound=0.0, cost=math.inf, expanded=0))
    assert found.status is Status.BUDGET


def in_turns(problem: Problem, budget: Budget) -> tuple[SearchResult, int]:
    """What both searches find, told at every step, and how many turns lanes had."""
    judge = Judge(problem, KernelBackend(problem))
    search = FreeSearch(problem, judge, Log(budget.start(), judge), silent)
    with (
        mock.patch.object(Log, "due", return_value=True),
        mock.patch.object(search, "_by_lanes", wraps=search._by_lanes) as turns,
    ):
        found = search.run()
    return found, turns.call_count


def test_what_is_told_on_the_way_gets_no_worse() -> None:
    """No cost that was told rises, no bound falls or is above it, whichever search tells them."""
    problem = load("tasks/reorient", ("fingers.placements.grid=[3, 3]",)).problem
    with mock.patch.object(free_search, "TURN", 0.0):
        found, _ = in_turns(problem, Budget())
    history = found.statistics["history"]
    costs = [math.inf if cost is None else cost for _, cost, _ in history]
    bounds = [bound for *_, bound in history]
    assert costs == sorted(costs, reverse=True) and costs[-1] < math.inf
    assert bounds == sorted(bounds)
    assert all(bound <= cost for cost, bound in zip(costs, bounds, strict=True))


def test_lanes_that_rest_are_not_asked_again() -> None:
    """Where larger parts are left to the other search it goes on by itself, to its end."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    cheapest = lanes(problem)
    with (
        mock.patch.object(free_search, "TURN", 0.0),
        mock.patch.object(free_search, "FEW_NODES", 0),
    ):
        found, turns = in_turns(problem, Budget())
    assert found.cost == pytest.approx(cheapest.cost, rel=1e-9) and found.optimal
    assert turns < 1000


def test_plans_without_regrasping_are_searched_for_first() -> None:
    """Where they have the proof at once no lane is asked for."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    found, turns = in_turns(problem, Budget())
    assert found.optimal and found.cost == pytest.approx(kept(problem).cost, rel=1e-9)
    assert turns == 0


def test_lanes_go_on_where_the_other_search_is_done() -> None:
    """Nothing is left to a search that can say no more."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    with mock.patch.object(free_search, "FEW_NODES", 0):
        found = searched(problem, mock.Mock(done=True, bound=0.0, cost=math.inf, expanded=0))
    assert found.optimal


def test_lanes_go_on_where_there_is_no_memory_for_the_other_search() -> None:
    """It keeps its bound; the plan is the same."""
    problem, asked = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem, []

    def fits(extra: float) -> bool:
        asked.append(extra)
        return len(asked) < 3  # sets of placements, and one book that grows

    with (
        mock.patch.object(kept_graph, "limits", mock.Mock(fits=fits)),
        mock.patch.object(kept_room, "limits", mock.Mock(fits=fits)),
        mock.patch.object(kept_graph, "ASKS", 1 << 18),
    ):
        found, turns = in_turns(problem, Budget())
    assert len(asked) == 3 and turns > 0
    assert found.optimal and found.cost == pytest.approx(kept(problem).cost, rel=1e-9)


@pytest.mark.parametrize("most", [1, 100, 3000])
def test_limited_iterations_find_the_same_however_fast(most: int) -> None:
    """Turns are no matter of time then; all that was expanded counts."""
    problem = load("tasks/reorient", ("fingers.placements.grid=[3, 3]",)).problem
    results = []
    for now in (lambda: 0.0, itertools.count().__next__):
        with mock.patch.object(Meter, "elapsed", side_effect=now):
            found, _ = in_turns(problem, Budget(max_iterations=most))
        counts = found.statistics["expanded"], found.statistics["generated"]
        results.append((found.status, found.cost, found.lower_bound, *counts))
    assert results[0] == results[1]


def test_it_hears_what_stops_the_search() -> None:
    """A budget's limits are heard there as everywhere."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    judge = Judge(problem, KernelBackend(problem))
    for budget in (Budget(stop=lambda: True), Budget(time_limit=0.0)):
        search = KeptSearch.of(judge, Log(budget.start(), judge))
        assert search is not None
        with pytest.raises(LimitError):
            search.step(math.inf)


def test_what_is_known_is_not_lost_by_another_part() -> None:
    """A search of a part, or another of the whole, that knows less leaves the bound as it was."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    knows = dataclasses.replace(lanes(problem), cost=None, moves=(), optimal=False, lower_bound=2.0)
    less = dataclasses.replace(knows, status=Status.BUDGET, lower_bound=1.0)
    assert cheaper(knows, less).lower_bound == 2.0
    assert free_search._within(less, math.inf, 2.0).lower_bound == 2.0
