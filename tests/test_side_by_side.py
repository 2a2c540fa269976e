"""The comparison with an earlier commit: what counts as a difference, and as slower."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.side_by_side.before import BEFORE, Before, Outcome, asked, compare, differences, record
from tests.side_by_side.measure import Row, alternate, table

SOLVED = Outcome("solved", 10.0, 10.0, True, 1)
LIMITED = Outcome("solved", 12.0, 9.0, False, 2)
NONE = Outcome("infeasible", None, None, False, None)
SPENT = Outcome("budget", None, 9.0, False, None)


@pytest.mark.parametrize("outcome", [SOLVED, LIMITED, NONE, SPENT])
def test_equal_outcomes_do_not_differ(outcome: Outcome) -> None:
    """Whatever came of a search, the same again is no difference."""
    assert list(differences(outcome, outcome)) == []


@pytest.mark.parametrize(
    ("then", "now", "word"),
    [
        (SOLVED, replace(SOLVED, cost=10.0 * (1.0 + 2e-9), bound=10.0), "cost"),
        (SOLVED, NONE, "status"),
        (NONE, SOLVED, "status"),
        (SOLVED, replace(SOLVED, regrasps=2), "regrasps"),
        (SOLVED, LIMITED, "not proven"),
        (NONE, SPENT, "not proven"),
        (LIMITED, NONE, "is infeasible"),
        (LIMITED, replace(SPENT, bound=13.0), "the bound is"),
        (replace(SPENT, bound=13.0), SOLVED, "the bound was"),
        (NONE, LIMITED, "was infeasible"),
    ],
)
def test_contradictions_are_told(then: Outcome, now: Outcome, word: str) -> None:
    """Each way in which two outcomes cannot both be right is named."""
    assert word in "; ".join(differences(then, now))


@pytest.mark.parametrize(
    ("then", "now"),
    [
        (SOLVED, replace(SOLVED, cost=10.0 * (1.0 + 5e-10))),
        (LIMITED, SOLVED),
        (SPENT, SOLVED),
        (SPENT, NONE),
        (LIMITED, replace(LIMITED, cost=11.0, bound=9.5)),
    ],
)
def test_what_agrees_is_let_pass(then: Outcome, now: Outcome) -> None:
    """Rounding, and what a search finds beyond an earlier limit, is no difference."""
    assert list(differences(then, now)) == []


def _planner(calls: list[str]) -> Callable[[str, str, int], Outcome]:
    def plan(scenario: str, planner: str, seed: int) -> Outcome:
        calls.append(f"{scenario} {planner} {seed}")
        return SOLVED

    return plan


def test_recording_goes_on_where_it_stopped(tmp_path: Path) -> None:
    """A second call plans only what is missing, and the file holds all outcomes."""
    path, calls = tmp_path / "before.json", list[str]()
    keys = [("a", "astar", 0), ("b", "astar", 0), ("b", "dijkstra", 3)]
    assert record(Before("abc", 5.0, {}), iter(keys[:1]), _planner(calls), 60.0, path) == 0
    assert record(Before.read(path), iter(keys), _planner(calls), 60.0, path) == 0
    assert calls == ["a astar 0", "b astar 0", "b dijkstra 3"]
    assert Before.read(path) == Before("abc", 5.0, dict.fromkeys(keys, SOLVED))
    assert record(Before.read(path), iter([("c", "astar", 0)]), _planner(calls), -1.0, path) == 1


def test_differing_runs_are_counted() -> None:
    """A run counts once, however much differs in it."""
    runs = {("a", "astar", 0): SOLVED, ("b", "astar", 0): replace(SOLVED, cost=11.0, bound=11.0)}
    said: list[str] = []
    assert compare(Before("abc", 5.0, runs), _planner([]), said.append) == 1
    assert said[0].startswith("b astar 0: cost is 10.0")


def test_the_record_holds_what_is_asked_for() -> None:
    """The record names its commit, and knows no run that is not asked for; the paper's four are."""
    before = Before.read(BEFORE)
    shipped = ["paper/slide", "paper/push", "paper/tumble", "paper/regrasp"]
    assert len(before.commit) == 12
    assert {(name, "astar", 0) for name in shipped} <= set(before.runs)
    others = {key for key in before.runs if key[0].startswith("random/")}
    assert others <= set(asked([]))


def test_slower_is_more_than_five_percent_and_more_than_noise() -> None:
    """A clear slowdown counts; a small one, and one that the spread explains, do not."""
    old = [1.0, 1.01, 0.99, 1.0, 1.02]
    assert Row("clear", old, [1.2 * t for t in old]).slower
    assert not Row("small", old, [1.04 * t for t in old]).slower
    assert not Row("noisy", [1.0, 2.0, 1.0, 2.0, 1.5], [2.0, 1.0, 2.0, 1.0, 1.7]).slower
    low, high = Row("even", old, old).interval
    assert low == high == 1.0
    assert "| clear | 5 | 1 | 1.2 | 1.200 |" in table([Row("clear", old, [1.2 * t for t in old])])


def test_runs_alternate() -> None:
    """Each repetition is done by both, and neither always goes first."""
    calls: list[str] = []

    def side(name: str) -> Callable[[int], float]:
        def run(k: int) -> float:
            calls.append(f"{name}{k}")
            return 1.0

        return run

    alternate("work", 3, side("old"), side("new"))
    assert calls == ["old0", "new0", "new1", "old1", "old2", "new2"]
