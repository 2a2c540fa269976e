"""Compiling on two cores where nothing is compiled yet.

A process compiles one function at a time. So another one compiles what the mode decision calls at
its edges, and keeps it on disk; this one meanwhile compiles the simplex. Then it compiles the
decision, which takes the other's work from there, while the other turns to lanes, hubs and routes.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from typing import Final

from gm_ompl import clock, compilation
from gm_ompl.cores import cores
from gm_ompl.motion.free import FreeMotion
from gm_ompl.problem import Problem

KERNELS: Final = "gm_ompl.planners.kernels"
"""What the other process runs; it loads all that can be compiled, so here only when needed."""


def prepare(problem: Problem) -> None:
    """Compile what searches need, if nothing of it is on disk; the budgets' clock stands still.

    Where ``problem`` asks for another back end than the kernel, nothing is compiled ahead.
    """
    if problem.mechanics.backend != "kernel" or cores() < 2:
        return
    if compilation.CACHE is None or compilation.is_compiled():
        return
    from gm_ompl.planners import kernels
    from gm_ompl.planners.lane_parts import CellPart, part_class

    compilation.announce()
    command = [sys.executable, "-P", "-m", KERNELS]
    quiet, pipe = subprocess.DEVNULL, subprocess.PIPE
    try:
        helper = subprocess.Popen(command, stdin=quiet, stdout=pipe, stderr=quiet)
    except OSError:  # no program of Python's, or no more processes: searches compile by themselves
        return
    with helper as other:
        try:
            kernels.passes()
            assert other.stdout is not None
            _standing(other.stdout.readline)  # at once where the other has failed
            kernels.decision()
            if part_class(problem) is CellPart:
                kernels.cells()
            if _sweeps(problem):
                kernels.sweeps()
            _standing(other.wait)
        finally:
            other.kill()


def _standing(wait: Callable[[], object]) -> None:
    """Wait for the other process; the budgets' clock stands still."""
    waiting = time.monotonic()
    wait()
    clock.stand_still(time.monotonic() - waiting)


def _sweeps(problem: Problem) -> bool:
    """Whether motions are tested for collisions: not where the object stays level on the floor."""
    if problem.environment.obstacles or isinstance(problem.motion, FreeMotion):
        return True
    objects = problem.object_graph
    leaving = objects.arcs_from(objects.start)
    return not all(sweep.keeps_level for one in leaving[:1] for sweep in one.arc.sweeps)
