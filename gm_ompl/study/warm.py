"""Small searches before the first run: they load most of the compiled code that runs need.

What they do not reach shows in the first run that needs it (see ``forks``).
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable

import gm_ompl
from gm_ompl.errors import InputError

SMALL = ("lattice.segments=3", "fingers.placements.grid=[2, 2]")
WARMING = ("paper/slide", "paper/regrasp")
"""Scenarios that, made small, load most of the compiled code a run may need."""


def warm_up(planners: Iterable[str]) -> None:
    """Import what these planners use, and load or compile most of it."""
    for name in WARMING:
        scenario = gm_ompl.load(name, SMALL)
        for planner in planners:
            with contextlib.suppress(InputError):  # its runs will say so
                gm_ompl.plan(scenario, planner, max_iterations=20, time_limit=2.0)
