"""Compiling on two cores where nothing is compiled yet.

A process compiles one function at a time. So another one compiles what the mode decision calls at
its edges, and keeps it on disk; this one meanwhile compiles the simplex, what lanes, hubs, routes
and swept tests need, and then the decision, which takes the other's work from there.
"""

from __future__ import annotations

import subprocess
import sys
import time
from typing import Final

from gm_ompl import clock, compilation
from gm_ompl.cores import cores
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
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet) as other:
        try:
            kernels.decision()
            if part_class(problem) is CellPart:
                kernels.cells()
            waiting = time.monotonic()
            other.wait()
            clock.stand_still(time.monotonic() - waiting)
        finally:
            other.kill()
