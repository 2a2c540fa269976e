"""Compiling on two cores where nothing is compiled yet.

A process compiles one function at a time. So another one asks the kernel for a margin, which is
most of a mode decision, and keeps the machine code on disk; this one meanwhile compiles what lanes
need, and then makes a plan, whose decisions take the other's work from there. Both work on a
scenario that takes no time by itself. What else a search turns out to need is compiled then.
"""

from __future__ import annotations

import subprocess
import sys
import time
from typing import Final

import numpy as np

from gm_ompl import clock, compilation
from gm_ompl.contact.decision import ControlMode
from gm_ompl.cores import cores
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Problem

SMALL: Final = ("lattice.segments=2", "fingers.placements.grid=[2, 2]")


def prepare(problem: Problem) -> None:
    """Compile what most searches need, if nothing is on disk; the budgets' clock stands still.

    Where ``problem`` asks for another back end than the kernel, nothing is compiled ahead.
    """
    if problem.mechanics.backend != "kernel" or cores() < 2:
        return
    if compilation.CACHE is None or compilation.is_compiled():
        return
    compilation.announce()
    command = [sys.executable, "-P", "-m", "gm_ompl.planners.prepare"]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet) as other:
        try:
            judge, backend = small()
            lanes(judge, backend)
            waiting = time.monotonic()
            other.wait()
            clock.stand_still(time.monotonic() - waiting)
        finally:
            other.kill()
    plan(judge)


def small() -> tuple[Judge, KernelBackend]:
    """Return the judge of a small problem, and its back end."""
    from gm_ompl.scenario.load import load

    problem = load("paper/slide", SMALL).problem
    backend = KernelBackend(problem)
    return Judge(problem, backend), backend


def lanes(judge: Judge, backend: KernelBackend) -> None:
    """Ask for bounds of lanes."""
    from gm_ompl.graph.goals import start_node
    from gm_ompl.graph.lane_graph import LaneGraph
    from gm_ompl.planners.lane_sources import start_sets

    graph = LaneGraph(judge.problem, judge, backend)
    source = start_sets(judge.problem, judge, graph, start_node(judge.problem))
    source.renew()
    graph.target(graph.lane((0,) * judge.problem.fingers.count), 0, 0.0)


def margin(judge: Judge, backend: KernelBackend) -> None:
    """Ask for the margin under given commands, with everything at rest."""
    problem = judge.problem
    everyone, rows = tuple(range(problem.fingers.count)), (0,) * problem.fingers.count
    at = judge.environment(Moment(problem.motion.pose(problem.motion.low)))
    chosen = (ControlMode.FORCE,) * problem.fingers.count
    backend.alternatives(at, everyone, rows).at(chosen, np.zeros(problem.fingers.count))


def plan(judge: Judge) -> None:
    """Make a plan."""
    from gm_ompl.planners.planner import Budget
    from gm_ompl.planners.registry import make_planner

    make_planner("astar").solve(judge.problem, judge, Budget(None), np.random.default_rng(0))


if __name__ == "__main__":
    margin(*small())
