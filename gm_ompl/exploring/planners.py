"""Which planners a page offers, and how long each is given."""

from __future__ import annotations

from typing import Final

from gm_ompl.planners.registry import PLANNERS

AUTO: Final = "auto"
"""Not a planner: the exact one where it answers in time, else the sampling one."""

EXACT, SAMPLED = "astar", "HybridRRTConnect"
"""What ``auto`` chooses from."""

PATIENCE_S: Final = 0.8
"""A plan that was sampled is kept back for so long, in case the exact one comes [s]: what is seen
a second after a knob was turned feels like its answer."""

POLITENESS: Final = 5
"""How nice the exact search is to the sampling one beside it, which is waited for sooner."""

SAMPLING_S: Final = 1.2
"""The sampling planner beside the exact one is given so much [s]: what it has by then is shown,
however it might be improved. Only where it has nothing it is given all the time there is."""

IMPROVING_S: Final = 1.5
"""A planner that improves its plan until its time is over is given so much [s]."""


def names() -> list[str]:
    """Return what may be chosen."""
    return [AUTO, *PLANNERS]


def seconds(planner: str, limit: float) -> float:
    """Return the time that a planner is given, of at most ``limit`` [s]."""
    specs = PLANNERS[planner].specs if planner in PLANNERS else None
    improving = specs is not None and specs.optimal and specs.randomised
    return min(limit, IMPROVING_S) if improving else limit
