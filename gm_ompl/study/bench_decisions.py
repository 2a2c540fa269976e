"""Mode decisions drawn from real searches, timed with the kernel and with HiGHS."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from cProfile import Profile
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

import numpy as np

from gm_ompl.contact.decision import ControlMode, ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend, Key
from gm_ompl.planners.planner import Budget, SearchResult
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Problem
from gm_ompl.reference import highs
from gm_ompl.reference.internal_force import excessive_internal_force
from gm_ompl.reference.modes import combinations, decide_modes
from gm_ompl.reference.stability import stability_program
from gm_ompl.reference.statics import statics

Answer = TypeVar("Answer")


@dataclass(frozen=True, eq=False)
class Searched:
    """A search and the decisions of the whole hand that it made."""

    problem: Problem  # what was searched
    backend: KernelBackend  # numbers the contact states
    result: SearchResult  # of the search
    asked: list[Key]  # every decision made, in order
    seconds: float  # wall time of the search [s]


Times: TypeAlias = dict[str, list[float]]
"""CPU times of the same decisions by several ways [ms]: "kernel", per decision the median of the
repetitions, memo off; "both_force", those where every finger is force-controlled; "sample", the
kernel's where HiGHS decides too; "highs", by the reference's ``decide_modes``, which skips hopeless
mode sets and, where no finger is force-controlled, solves (6) direction by direction; "whole", as
Sec. 3.4 is written, see ``as_written``."""


def searched(
    problem: Problem, planner: str, time_limit: float, profile: Profile | None = None
) -> Searched:
    """Search with the kernel, memos empty, perhaps profiled, and keep what was decided."""
    backend = KernelBackend(problem)
    judge, solve = Judge(problem, backend), make_planner(planner).solve
    started, rng = time.perf_counter(), np.random.default_rng(0)
    call = profile.runcall if profile else lambda function, *given: function(*given)
    result: SearchResult = call(solve, problem, judge, Budget(time_limit), rng)
    seconds = time.perf_counter() - started
    asked = [key for key in backend.decided() if len(key[2]) == problem.fingers.count]
    return Searched(problem, backend, result, asked, seconds)


def timed(search: Searched, most: int, with_highs: int, repeat: int) -> Times:
    """Time ``most`` decisions of a search, ``repeat`` times, and ``with_highs`` by HiGHS too."""
    drawn = spread(search.asked, most)
    passes = [_kernel_pass(search, drawn) for _ in range(repeat)]
    kernel = np.median([times for times, _ in passes], axis=0).tolist() if drawn else []
    both = [
        t for t, decision in zip(kernel, passes[0][1], strict=True)
        if decision.modes and ControlMode.POSITION not in decision.modes
    ]  # fmt: skip
    sample = [_one_of_sample(search, key, repeat) for key in spread(drawn, with_highs)]
    ways = {
        way: [times[k] for times in sample] for k, way in enumerate(("sample", "highs", "whole"))
    }
    return {"kernel": kernel, "both_force": both, **ways}


def _one_of_sample(search: Searched, key: Key, repeat: int) -> tuple[float, float, float]:
    """Time one decision by the kernel, before and after HiGHS makes it in two ways [ms].

    A machine's speed changes within seconds: what is to be divided is measured side by side.
    """
    instant = search.problem.instant(search.backend.contacts(key[0]), key[1], key[2])
    kernel = [_kernel_pass(search, [key])[0][0] for _ in range(repeat)]
    needed, whole = _milliseconds(decide_modes, instant), _milliseconds(as_written, instant)
    kernel += [_kernel_pass(search, [key])[0][0] for _ in range(repeat)]
    return float(np.median(kernel)), needed, whole


def as_written(instant: Instant) -> float:
    """Solve Sec. 3.4 as it is written: (5), and where it passes (6) as one program, for all modes.

    Returns:
        The largest z, over the reference's unit of force; -inf without any.
    """
    model, best = statics(instant), -np.inf
    for modes in combinations(model.fingers):
        position = [i for i, mode in enumerate(modes) if mode is ControlMode.POSITION]
        if not excessive_internal_force(model, position).excessive:
            solution = highs.solve(stability_program(model, modes))
            best = max(best, float(solution.x[0]) if len(solution.x) else -np.inf)
    return best


def spread(items: Sequence[Answer], most: int) -> list[Answer]:
    """Return up to ``most`` items, evenly spread over the sequence."""
    if len(items) <= most:
        return list(items)
    return [items[int(i)] for i in np.linspace(0, len(items) - 1, most)]


def _kernel_pass(search: Searched, drawn: list[Key]) -> tuple[list[float], list[ModeDecision]]:
    backend, z_min = search.backend, search.problem.mechanics.z_min
    backend.forget()
    times, decisions = [], []
    for environment, fingers, placements in drawn:
        started = time.process_time()
        decision = backend.decide(environment, fingers, placements, z_min)
        times.append(1e3 * (time.process_time() - started))
        decisions.append(decision)
    return times, decisions


def _milliseconds(decide: Callable[[Instant], object], instant: Instant) -> float:
    started = time.process_time()
    decide(instant)
    return 1e3 * (time.process_time() - started)
