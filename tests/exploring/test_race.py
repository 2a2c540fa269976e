"""Exact where that answers in time, sampled else: what a page is told, and what is dropped."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import pytest

from gm_ompl.exploring import race
from gm_ompl.exploring.planners import AUTO, EXACT, SAMPLED, names, seconds

Result = TypeVar("Result")

QUICK, SLOW, NEVER = 0.0, 0.15, 60.0
PLAN = {"kind": "plan", "status": "solved", "solved": True}
PROOF = {"kind": "plan", "status": "infeasible", "solved": False}
NOTHING = {"kind": "plan", "status": "budget", "solved": False}
WRONG = {"kind": "refused", "of": "scenario", "lines": ["wrong"]}
UNABLE = {"kind": "refused", "of": "planner", "lines": ["unable"]}
CRASH = {"status": "crash", "message": "Segmentation fault"}


def _completed(work: Coroutine[Any, Any, Result]) -> Result:
    """Do ``work`` in a thread: a browser's driver may have a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, work).result()


def raced(
    monkeypatch: pytest.MonkeyPatch,
    runs: Mapping[str, tuple[float, dict[str, Any]]],
    planner: str = AUTO,
) -> tuple[list[tuple[Any, Any, bool]], list[str]]:
    """Return the answers (planner, status or reason, final), and the runs that were cancelled."""
    monkeypatch.setattr(race, "PATIENCE_S", 0.05)
    cancelled = []

    async def run(task: dict[str, Any]) -> dict[str, Any]:
        delay, outcome = runs[task["planner"]]
        try:
            await asyncio.sleep(delay)
        except asyncio.CancelledError:
            cancelled.append(task["planner"])
            raise
        return {**outcome, "planner": task["planner"]}

    async def collected() -> list[tuple[Any, Any, bool]]:
        told = race.answers(run, [], planner, race.Allowance(10.0, None))
        return [(a.get("planner"), a.get("status") or a["of"], a["final"]) async for a in told]

    return _completed(collected()), cancelled


def test_the_exact_plan_is_the_only_answer_where_it_comes_in_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Then the sampled one is never shown; its search is dropped."""
    for outcome in (PLAN, PROOF):
        found, dropped = raced(monkeypatch, {EXACT: (QUICK, outcome), SAMPLED: (NEVER, PLAN)})
        assert found == [(EXACT, outcome["status"], True)]
        assert dropped == [SAMPLED]


def test_a_sampled_plan_is_shown_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the exact one takes longer, the sampled one is shown, and replaced when it comes."""
    found, _ = raced(monkeypatch, {EXACT: (SLOW, PLAN), SAMPLED: (QUICK, PLAN)})
    assert found == [(SAMPLED, "solved", False), (EXACT, "solved", True)]


def test_the_sampled_plan_stands_where_the_exact_search_finds_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A spent budget, a planner that cannot, a crash: the other's plan is the answer."""
    for outcome in (NOTHING, UNABLE, CRASH):
        for delay in (QUICK, SLOW):
            found, _ = raced(monkeypatch, {EXACT: (QUICK, outcome), SAMPLED: (delay, PLAN)})
            assert found == [(SAMPLED, "solved", True)]
    for outcome in (NOTHING, UNABLE, CRASH):
        found, _ = raced(monkeypatch, {EXACT: (QUICK, NOTHING), SAMPLED: (QUICK, outcome)})
        assert found == [(EXACT, "budget", True)]


def test_what_is_wrong_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong scenario is wrong for both."""
    found, _ = raced(monkeypatch, {EXACT: (SLOW, WRONG), SAMPLED: (QUICK, WRONG)})
    assert found == [(EXACT, "scenario", True)]


def test_a_crash_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that ends without an answer is told in the words of its end."""
    found, _ = raced(monkeypatch, {"RRT": (QUICK, CRASH)}, "RRT")
    assert found == [(None, "crash", True)]


def test_given_up_means_dropped() -> None:
    """Who stops listening has both searches cancelled."""
    cancelled = []

    async def run(task: dict[str, Any]) -> dict[str, Any]:
        try:
            await asyncio.sleep(NEVER)
        finally:
            cancelled.append(task["planner"])
        return {}

    async def listen() -> None:
        async for _ in race.answers(run, [], AUTO, race.Allowance(10.0, None)):
            pass

    async def leave() -> None:
        listening = asyncio.create_task(listen())
        await asyncio.sleep(0.02)
        listening.cancel()
        with pytest.raises(asyncio.CancelledError):
            await listening

    _completed(leave())
    assert sorted(cancelled) == sorted([EXACT, SAMPLED])


def test_planners_that_only_improve_get_less_time() -> None:
    """They use all that they are given; the others stop by themselves."""
    assert names()[0] == AUTO
    assert seconds("HybridRRTstar", 10.0) < 2.0
    assert seconds("HybridRRTConnect", 10.0) == seconds("astar", 10.0) == 10.0
    assert seconds("HybridRRTstar", 0.5) == 0.5
