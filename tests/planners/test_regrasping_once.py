"""Plans that regrasp once, over all sets of placements at once: against the search over lanes."""

from __future__ import annotations

import math
from unittest import mock

import pytest

import gm_ompl
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.reach import Reach
from gm_ompl.graph import relaxed
from gm_ompl.planners import free_search
from gm_ompl.planners.kept_search import KeptSearch
from gm_ompl.planners.outcome import Log
from gm_ompl.planners.planner import Budget
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from tests.kept import kept, lanes

BOOK = ("tasks/bookshelf", ("fingers.placements.grid=[3, 1]", "lattice.steps.rotation=30 deg"))
TURNED = ("tasks/reorient", ("fingers.placements.grid=[1, 2]",))
CASES = (
    ("tasks/reorient", ("fingers.placements.grid=[2, 2]", "cost.regrasp=0.7")),
    ("tasks/placedown", ("fingers.placements.grid=[1, 3]", "cost.regrasp=1")),
    ("free/out-of-the-corner", ()),
    ("free/out-of-the-corner", ("cost.regrasp=1",)),
    ("free/stairs", ()),
    ("free/l-bracket", ("cost.regrasp=0.001",)),
    TURNED,
    (TURNED[0], (*TURNED[1], "fingers.goal=[{face: -x, cell: [0, 1]}, any]")),
    (TURNED[0], (*TURNED[1], "fingers.start=[{face: -x, cell: [0, 1]}, any]")),
)


def told(problem: Problem, seconds: float | None = None) -> KeptSearch:
    """A search for plans that regrasp once at most, as far as it comes."""
    judge = Judge(problem, KernelBackend(problem))
    search = KeptSearch.of(judge, Log(Budget(seconds).start(), judge))
    assert search is not None
    return search


@pytest.mark.parametrize(("name", "changes"), CASES)
def test_the_lanes_find_the_same(name: str, changes: tuple[str, ...]) -> None:
    """One optimum where plans that regrasp twice cannot be cheaper, and never a bound too high."""
    problem = load(name, changes).problem
    other = lanes(problem)
    assert other.cost is not None and other.optimal
    search = kept(problem, other.cost * 1.0001)
    assert search.bound <= other.cost * (1.0 + 1e-9)
    assert search.cost >= other.cost * (1.0 - 1e-6)
    if search.proves(other.cost):
        assert search.cost == pytest.approx(other.cost, rel=1e-6)
    moves = search.moves()
    assert math.fsum(move.cost for move in moves) == pytest.approx(search.cost) or not moves


@pytest.mark.parametrize(("name", "changes"), [BOOK, TURNED, ("free/out-of-the-corner", ())])
def test_its_plans_hold(name: str, changes: tuple[str, ...]) -> None:
    """The whole planner proves them, lanes have no turn, and ``check`` confirms them."""
    with mock.patch.object(free_search.FreeSearch, "_by_lanes", side_effect=AssertionError):
        plan = gm_ompl.plan(load(name, changes))
    assert plan.status == "solved" and plan.optimal and plan.regrasps == 1
    assert gm_ompl.check(plan).holds


def test_it_begins_where_the_other_kind_has_no_proof() -> None:
    """Plans without regrasping are looked for alone as long as they may be optimal."""
    problem = load("tasks/placedown", ("fingers.placements.grid=[2, 3]",)).problem
    assert len(kept(problem)._searches) == 1
    search = kept(load(*TURNED).problem)
    assert len(search._searches) == 2
    assert search.cost == pytest.approx(search.bound)


def test_both_kinds_bound_all_plans() -> None:
    """The bound of all is none that one kind of plans alone has; it never falls."""
    problem, bounds = load(*TURNED).problem, [0.0]
    search = told(problem)
    while not search.done:
        search.step(math.inf)
        bounds.append(search.bound)
        assert search.bound <= min(one.bound for one in search._searches)
    assert bounds == sorted(bounds)


@pytest.mark.parametrize("enough", [0.5, 0.9, 0.99])
def test_what_is_enough_ends_it(enough: float) -> None:
    """It is known then that no plan is cheaper."""
    problem = load(*TURNED).problem
    cost = kept(problem).cost
    search = kept(problem, enough * cost)
    assert search.cost == math.inf
    assert search.bound == pytest.approx(enough * cost)


def test_no_way_through_the_air_ends_it_without_a_proof() -> None:
    """Who cannot tell what else would do says no more; the bound stays true."""
    problem = load(*TURNED).problem
    cost = kept(problem).cost
    with mock.patch.object(Reach, "joined", return_value=False):
        search = kept(problem)
    assert search.cost > cost and search.bound <= cost
    assert search.done


def test_without_memory_lanes_go_on() -> None:
    """The bound stays true, the plan is the same."""
    problem = load(*TURNED).problem
    judge = Judge(problem, KernelBackend(problem))
    with mock.patch.object(relaxed, "book_with_room", return_value=None):
        search = kept(problem)
        found = free_search.FreeSearch(
            problem, judge, Log(Budget().start(), judge), lambda _: None
        ).run()
    assert found.cost is not None and search.cost == math.inf and search.bound < found.cost
    assert found.optimal and found.cost == pytest.approx(kept(problem).cost, rel=1e-6)


def test_one_finger_has_none_that_stays() -> None:
    """Its regrasps are left to lanes."""
    problem = load("tasks/reorient-one-finger", ("fingers.placements.grid=[1, 1]",)).problem
    assert len(kept(problem)._searches) == 1


def test_turns_change_nothing() -> None:
    """Where lanes have turns in between, costs are the same."""
    problem = load(*TURNED).problem
    judge = Judge(problem, KernelBackend(problem))
    with mock.patch.object(free_search, "TURN", 0.0), mock.patch.object(free_search, "SHARE", 0.5):
        search = free_search.FreeSearch(
            problem, judge, Log(Budget().start(), judge), lambda _: None
        )
        found = search.run()
    assert found.optimal and found.cost == pytest.approx(kept(problem).cost, rel=1e-6)
