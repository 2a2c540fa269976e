"""The project's own speed as ratios in one run: what ``gm-ompl bench`` shows."""

from __future__ import annotations

import cProfile
import os
import platform
import pstats
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import gm_ompl
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.problem import Problem
from gm_ompl.study.bench_decisions import Searched, Times, searched, timed

Json: TypeAlias = dict[str, Any]

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")
SEARCHES = ("astar", "dijkstra")

DRAWN = 1000  # decisions drawn per search for the kernel
SAMPLED_NODES = 400  # nodes on which arcs are counted; the mean stands for all

_SHARES = {
    "geometry": ("geometry", "contact", "motion"),
    "decisions": ("mechanics", "feasibility"),
    "search": ("planners", "graph"),
}


def bench(
    scenarios: Sequence[str] = SCENARIOS,
    overrides: Sequence[str] = (),
    note: Callable[[str], None] = lambda _: None,
    *,
    repeat: int = 5,
    highs: int = 20,
    search_limit: float = 10.0,
) -> Json:
    """Measure; what comes back is plain JSON, times in the unit that a key's end names.

    Args:
        scenarios: shipped names or files of one coordinate.
        overrides: "KEY=VALUE" changes of every scenario.
        note: told what is being measured.
        repeat: repetitions of what is short.
        highs: decisions per search made with HiGHS, too.
        search_limit: wall time of a search [s].
    """
    problems = {name: gm_ompl.load(name, overrides).problem for name in scenarios}
    note("start-up")
    start: Json = startup(scenarios[0], overrides, repeat)
    pool: dict[str, Times] = {search: defaultdict(list) for search in SEARCHES}
    decisions, plans = [], []
    for name, problem in problems.items():
        note(f"{name}: decisions and plans")
        found = {search: searched(problem, search, search_limit) for search in SEARCHES}
        mean: list[float] = []
        for search, one in found.items():
            times = timed(one, DRAWN, highs, repeat)
            mean += times["highs"]
            for way, values in times.items():
                pool[search][way] += values
            decisions.append(_decision_row(name, search, len(one.asked), times))
        mean_ms = statistics.fmean(mean) if mean else None
        row = _plan_row(found["dijkstra"], mean_ms, repeat, search_limit)
        plans.append({"scenario": name, **row, "peak_mb": _spent(_plan(name, overrides))[1]})
    decisions += [_decision_row("all", search, None, times) for search, times in pool.items()]
    machine = {
        "python": platform.python_version(), "platform": platform.platform(),
        "cores": os.cpu_count(), "load": os.getloadavg()[0],
    }  # fmt: skip
    start = {**start, "scenario": scenarios[0]}
    return {"machine": machine, "decisions": decisions, "plans": plans, "start": start}


def _decision_row(name: str, search: str, asked: int | None, times: Times) -> Json:
    kernel, sample = times["kernel"], times["sample"]
    return {
        "scenario": name,
        "search": search,
        "asked": asked,
        "drawn": len(kernel),
        "kernel_median_ms": _median(kernel),
        "kernel_p95_ms": float(np.quantile(kernel, 0.95)) if kernel else None,
        "both_force": len(times["both_force"]),
        "both_force_median_ms": _median(times["both_force"]),
        "highs_drawn": len(sample),
        "highs_median_ms": _median(times["highs"]),
        "highs_whole_median_ms": _median(times["whole"]),
        "ratio": _median([h / k for h, k in zip(times["highs"], sample, strict=True)]),
        "ratio_whole": _median([h / k for h, k in zip(times["whole"], sample, strict=True)]),
    }


def _median(values: Sequence[float]) -> float | None:
    return statistics.median(values) if values else None


def _plan_row(plain: Searched, mean_ms: float | None, repeat: int, time_limit: float) -> Json:
    """Time A*, its first run left out, beside the plain search: counted decisions times a mean."""
    runs = [searched(plain.problem, "astar", time_limit) for _ in range(repeat + 1)][1:]
    seconds, result = statistics.median(run.seconds for run in runs), runs[0].result
    expanded = int(plain.result.statistics["expanded"])
    decisions = decisions_per_node(plain.problem) * expanded
    plain_s = None if mean_ms is None else 1e-3 * mean_ms * decisions
    return {
        "optimal": result.optimal,
        "seconds": seconds,
        "expanded": int(result.statistics["expanded"]),
        "mode_decisions": int(result.statistics["mode_decisions"]),
        "plain_expanded": expanded,
        "plain_is_whole": plain.result.optimal,
        "plain_decisions": decisions,
        "plain_mean_decision_ms": mean_ms,
        "plain_s": plain_s,
        "ratio": None if plain_s is None else plain_s / seconds,
        "profile": profiled(plain.problem, time_limit),
    }


def decisions_per_node(problem: Problem) -> float:
    """Return the mean number of mode decisions that expanding a node takes in the plain search.

    Every displacement arc is judged in samples_per_arc segments, every regrasping arc once; arcs
    to nodes that geometry rules out are not. Counted on random valid nodes.
    """
    rng = np.random.default_rng(0)
    judge = Judge(problem, KernelBackend(problem))
    lattice, n, pose = problem.lattice, problem.fingers.count, problem.motion.pose
    counts: list[int] = []
    for _ in range(50 * SAMPLED_NODES):
        if len(counts) == SAMPLED_NODES:
            break
        at = int(rng.integers(lattice.size))
        free = judge.node(pose(lattice.coordinates(at))).free
        rows = [np.flatnonzero(mask) for mask in free]
        if not all(len(r) for r in rows):
            continue
        placements = tuple(int(rng.choice(r)) for r in rows)
        if judge.apart(placements):
            regrasps = 0
            for i in range(n):  # how many other placements are clear of the other fingers
                clear = zip(judge.clear[i], placements, strict=True)
                fits = [table[rows[i], row] for table, row in clear if table is not None]
                regrasps += int(np.all(fits, axis=0).sum()) - 1 if fits else len(rows[i]) - 1
            heads = sum(
                judge.placements_valid(pose(q), placements) for _, q in lattice.neighbours(at)
            )
            counts.append(regrasps + problem.cost.samples_per_arc * heads)
    return float(np.mean(counts)) if counts else 0.0


def startup(scenario: str, overrides: Sequence[str], repeat: int) -> dict[str, float]:
    """Return median wall times [s] of ``--help`` and of a first plan, each in a new process.

    A first run, which may compile the kernel, is not counted.
    """
    plan = _plan(scenario, overrides)
    _spent(plan)
    return {
        key: statistics.median(_spent(words)[0] for _ in range(repeat))
        for key, words in (("help_s", ["--help"]), ("first_plan_s", plan))
    }


def _plan(scenario: str, overrides: Sequence[str]) -> list[str]:
    return ["plan", scenario, "--json", *(w for change in overrides for w in ("--set", change))]


def _spent(arguments: list[str]) -> tuple[float, float]:
    """Return wall time [s] and peak memory [MiB] of a call of ``gm-ompl``."""
    started = time.perf_counter()
    quiet = subprocess.DEVNULL
    with subprocess.Popen(
        [sys.executable, "-m", "gm_ompl", *arguments], stdout=quiet, stderr=quiet
    ) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)  # it has been waited for
    return time.perf_counter() - started, usage.ru_maxrss / 1024.0


def profiled(problem: Problem, time_limit: float) -> dict[str, float]:
    """Return the shares of A*'s time spent on geometry, decisions, search and the rest.

    Time is counted where it passes, numpy's and compiled code's in the module that calls them.
    """
    profile = cProfile.Profile()
    searched(problem, "astar", time_limit, profile)
    spent = dict.fromkeys([*_SHARES, "other"], 0.0)
    for function, row in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        callers = row[4]
        library = _share(function[0]) == "other" and callers
        # Code of libraries counts where it is called from.
        for place, part in callers.items() if library else [(function, row)]:
            spent[_share(place[0])] += part[2]
    total = sum(spent.values())
    return {name: seconds / total for name, seconds in spent.items()}


def _share(file: str) -> str:
    packages = Path(file).parts
    for name, parts in _SHARES.items():
        if "gm_ompl" in packages and any(part in packages for part in parts):
            return name
    return "other"
