"""A plan with a junction that fails, not even holding at rest, gives way to another plan."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import pytest

import gm_ompl
from gm_ompl.contact.junction import JunctionVerdict
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners import again
from gm_ompl.planners.again import SEARCHES, settled
from gm_ompl.planners.planner import Budget, Planner, PlannerSpecs, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.planners.steady import Steady, steady_moves
from gm_ompl.problem import Move
from gm_ompl.scenario.load import load

FIRST = SearchResult(
    Status.SOLVED,
    statistics={
        "time_s": 1.0, "expanded": 3, "generated": 5, "mode_decisions": 7, "history": [[1, 2, 0]]
    },
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Step:
    """Stands for a move."""

    name: str
    cost: float = 1.0


def plan(name: str) -> tuple[Move, ...]:
    return cast(tuple[Move, ...], (Step(name),))


class Scripted:
    """Stands for a planner that finds given plans one after the other."""

    def __init__(self, names: Sequence[str], randomised: bool = True) -> None:
        self.specs, self.names = PlannerSpecs(False, randomised), list(names)
        self.asked: list[Budget] = []

    def solve(self, _: object, __: object, budget: Budget, *___: object) -> SearchResult:
        self.asked.append(budget)
        return dataclasses.replace(FIRST, moves=plan(self.names.pop(0)))


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans named "bad" have a junction that fails, those named "rests" one that needs rest."""

    def steady(_: Judge, moves: tuple[Move, ...]) -> Steady:
        name = cast(Step, moves[0]).name
        found = {
            "bad": (JunctionVerdict.FAILS,),
            "rests": (JunctionVerdict.RESTS,),
            "unknown": None,
        }
        return Steady(moves, found.get(name, ()))

    monkeypatch.setattr(again, "steady_moves", steady)


def chosen(scripted: Scripted, first: SearchResult, **budget: Any) -> tuple[SearchResult, Steady]:
    problem = load("paper/slide").problem
    judge = Judge(problem, make_backend(problem))
    rng = np.random.default_rng(0)
    return settled(cast(Planner, scripted), judge, first, Budget(**budget), rng)


def test_a_plan_that_stands_replaces_one_that_does_not() -> None:
    """The first plan of this search fails at a corner; what is returned does not, says check."""
    problem = load("random/small/8").problem
    judge, rng = Judge(problem, make_backend(problem)), np.random.default_rng(0)
    moves = make_planner("HybridRRT").solve(problem, judge, Budget(), rng).moves
    assert steady_moves(judge, moves).fails
    found = gm_ompl.plan("random/small/8", "HybridRRT")
    report = gm_ompl.check(found)
    assert report.holds, report.table()
    assert not any(JunctionVerdict.FAILS.value in note for note in report.notes)


@pytest.mark.usefixtures("told")
def test_searches_go_on_until_one_stands() -> None:
    """Each has what is left of the budget; what they did adds up; not known is not good enough."""
    scripted = Scripted(["bad", "unknown", "rests", "good"])
    first = dataclasses.replace(FIRST, moves=plan("bad"))
    result, steady = chosen(scripted, first, max_iterations=100, time_limit=50.0)
    assert steady.moves == result.moves == plan("rests")
    assert [budget.max_iterations for budget in scripted.asked] == [97, 94, 91]
    assert [budget.time_limit for budget in scripted.asked] == [49.0, 48.0, 47.0]
    assert (result.statistics["expanded"], result.statistics["time_s"]) == (12, 4.0)
    assert result.statistics["history"] == [[4.0, 2, 0]]


@pytest.mark.usefixtures("told")
def test_the_first_plan_is_kept_where_none_stands() -> None:
    """After so many searches, or with nothing left to spend, or of a planner that cannot vary."""
    first = dataclasses.replace(FIRST, moves=plan("bad"), optimal=True)
    for scripted, budget, searches in (
        (Scripted(["bad"] * SEARCHES), {}, SEARCHES - 1),
        (Scripted(["bad"] * SEARCHES), {"max_iterations": 5}, 1),
        (Scripted(["good"], randomised=False), {}, 0),
        (Scripted([]), {"max_iterations": 3}, 0),
    ):
        result, steady = chosen(scripted, first, **budget)
        assert (result.moves, result.optimal) == (first.moves, True) and steady.fails
        assert len(scripted.asked) == searches


@pytest.mark.usefixtures("told")
def test_plans_found_on_the_way_are_asked_first() -> None:
    """The cheapest of them that stands is taken; it is not called optimal."""
    others = (plan("bad"), plan("rests"), plan("good"))
    first = dataclasses.replace(FIRST, moves=plan("bad"), others=others, optimal=True)
    result, steady = chosen(Scripted([]), first)
    assert steady.moves == result.moves == plan("rests")
    assert (result.cost, result.optimal) == (1.0, False)


def test_a_search_for_ever_better_plans_hands_out_the_earlier_ones() -> None:
    """They get dearer, and are not the best one."""
    problem = load("paper/slide").problem
    judge, rng = Judge(problem, make_backend(problem)), np.random.default_rng(0)
    result = make_planner("HybridRRTstar").solve(problem, judge, Budget(None, 60), rng)
    costs = [sum(move.cost for move in moves) for moves in (result.moves, *result.others)]
    assert len(costs) > 1 and costs == sorted(costs)
