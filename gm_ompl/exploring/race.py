"""Exact where that answers in time, sampled else: what a page is told, one answer after another."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias

from gm_ompl.exploring.planners import (
    AUTO,
    EXACT,
    PATIENCE_S,
    POLITENESS,
    SAMPLED,
    SAMPLING_S,
    seconds,
)
from gm_ompl.forks import Json

Run: TypeAlias = Callable[[Json], Coroutine[Any, Any, Json]]


@dataclass(frozen=True)
class Allowance:
    """What a run may spend."""

    time_s: float
    memory_mb: float | None


async def answers(
    run: Run, settings: list[str], planner: str, allowance: Allowance
) -> AsyncIterator[Json]:
    """Yield answers, each better than the one before; ``final`` is true in the last.

    Where the iteration is given up, the runs are cancelled.
    """

    async def ran(name: str, most: float = allowance.time_s, niceness: int = 0) -> Json:
        task = {
            "settings": settings,
            "planner": name,
            "niceness": niceness,
            "time_s": min(most, seconds(name, allowance.time_s)),
            "memory_mb": allowance.memory_mb,
        }
        return _told(await run(task))

    async def sampled() -> Json:
        found = await ran(SAMPLED, SAMPLING_S)
        return await ran(SAMPLED) if found.get("status") == "budget" else found

    if planner == AUTO:
        exact = asyncio.create_task(ran(EXACT, niceness=POLITENESS))
        racing = [exact, asyncio.create_task(sampled())]
        iteration = _raced(*racing)
    else:
        racing = [asyncio.create_task(ran(planner))]
        iteration = _alone(*racing)
    try:
        async for answer in iteration:
            yield answer
    finally:
        for task in racing:
            task.cancel()
        with suppress(asyncio.CancelledError):
            await asyncio.gather(*racing, return_exceptions=True)


async def mapped(
    run: Run, settings: list[str], instant: Json, allowance: Allowance
) -> AsyncIterator[Json]:
    """Yield the one answer to the question where fingers may be at an instant."""
    task = {
        "settings": settings,
        "instant": instant,
        "niceness": 0,
        "time_s": allowance.time_s,
        "memory_mb": allowance.memory_mb,
    }
    yield {**_told(await run(task)), "final": True}


async def _alone(task: asyncio.Task[Json]) -> AsyncIterator[Json]:
    yield {**await task, "final": True}


async def _raced(exact: asyncio.Task[Json], sampled: asyncio.Task[Json]) -> AsyncIterator[Json]:
    await asyncio.wait({exact}, timeout=PATIENCE_S)
    if not exact.done():
        await asyncio.wait({exact, sampled}, return_when=asyncio.FIRST_COMPLETED)
        if not exact.done() and _solved(told := sampled.result()):
            yield {**told, "final": False}
    last = await exact
    if not _settles(last):
        other = await sampled
        last = other if _solved(other) or last.get("kind") == "refused" else last
    yield {**last, "final": True}


def _settles(exact: Json) -> bool:
    """Whether nothing better can come: a plan, a proof that there is none, a wrong scenario."""
    if exact["kind"] == "refused":
        return bool(exact["of"] == "scenario")
    return exact.get("status") in ("solved", "infeasible")


def _solved(answer: Json) -> bool:
    return bool(answer.get("solved"))


def _told(outcome: Json) -> Json:
    """Return the answer of a run; of one that came to none, why."""
    if "kind" in outcome:
        return outcome
    return {"kind": "refused", "of": outcome["status"], "lines": [str(outcome["message"])]}
