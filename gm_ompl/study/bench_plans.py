"""Whole plans timed: A*, what the plain search would take, start-up, and where time goes."""

from __future__ import annotations

import cProfile
import pstats
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.registry import make_planner
from gm_ompl.problem import Placements, Problem

SAMPLED_NODES = 400
"""Nodes on which arcs are counted; the mean stands for all."""

_SHARES = {
    "geometry": ("geometry", "contact", "motion"),
    "decisions": ("mechanics", "feasibility"),
    "search": ("planners", "graph"),
}


@dataclass(frozen=True)
class Solved:
    """A* solved several times, memos emptied each time.

    Attributes:
        seconds: median wall time of ``solve``, the first left out.
        expanded: lanes or nodes expanded.
        decisions: mode decisions.
        optimal: whether proven optimal.
    """

    seconds: float
    expanded: int
    decisions: int
    optimal: bool


def solved(problem: Problem, repeat: int, time_limit: float) -> Solved:
    """Solve ``repeat`` + 1 times."""
    seconds = []
    for _ in range(repeat + 1):
        judge = Judge(problem, KernelBackend(problem))
        started = time.perf_counter()
        rng = np.random.default_rng(0)
        result = make_planner("astar").solve(problem, judge, Budget(time_limit), rng)
        seconds.append(time.perf_counter() - started)
    return Solved(
        statistics.median(seconds[1:]),
        int(result.statistics["expanded"]),
        int(result.statistics["mode_decisions"]),
        result.optimal,
    )


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
            regrasps = sum(_targets(judge, placements, i, rows[i]) for i in range(n))
            heads = sum(
                judge.placements_valid(pose(q), placements) for _, q in lattice.neighbours(at)
            )
            counts.append(regrasps + problem.cost.samples_per_arc * heads)
    return float(np.mean(counts)) if counts else 0.0


def _targets(judge: Judge, placements: Placements, finger: int, rows: np.ndarray) -> int:
    """Return how many other placements are free for a finger and clear of the others."""
    fits = np.ones(len(rows), dtype=bool)
    for other, row in enumerate(placements):
        clear = judge.clear[finger][other]
        if clear is not None:
            fits &= clear[rows, row]
    return int(fits.sum()) - 1


def startup(scenario: str, overrides: Sequence[str], repeat: int) -> tuple[float, float]:
    """Return median wall times [s] of ``--help`` and of a first plan, each in a new process.

    A first run, which may compile the kernel, is not counted.
    """
    changes = [word for change in overrides for word in ("--set", change)]
    plan = ["plan", scenario, *changes, "--json"]
    _run(plan)
    helps = [_run(["--help"]) for _ in range(repeat)]
    return statistics.median(helps), statistics.median(_run(plan) for _ in range(repeat))


def _run(arguments: list[str]) -> float:
    started = time.perf_counter()
    command = [sys.executable, "-m", "gm_ompl", *arguments]
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - started


def profiled(problem: Problem, time_limit: float) -> dict[str, float]:
    """Return the shares of A*'s time spent on geometry, decisions, search and the rest.

    Time is counted where it passes, numpy's and compiled code's in the module that calls them.
    """
    judge = Judge(problem, KernelBackend(problem))
    profile = cProfile.Profile()
    rng = np.random.default_rng(0)
    profile.runcall(make_planner("astar").solve, problem, judge, Budget(time_limit), rng)
    spent = dict.fromkeys([*_SHARES, "other"], 0.0)
    for function, row in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        callers = row[4]
        if _share(function[0]) == "other" and callers:
            # Code of libraries counts where it is called from.
            for caller, part in callers.items():
                spent[_share(caller[0])] += part[2]
        else:
            spent[_share(function[0])] += row[2]
    total = sum(spent.values())
    return {name: seconds / total for name, seconds in spent.items()}


def _share(file: str) -> str:
    packages = Path(file).parts
    for name, parts in _SHARES.items():
        if "gm_ompl" in packages and any(part in packages for part in parts):
            return name
    return "other"
