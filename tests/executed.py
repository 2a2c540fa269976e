"""Plans that are executed by counts and tables: of all shipped scenarios, and of random ones."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import gm_ompl
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.load import shipped

SEEDS: Final = {
    "slide": (0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 14, 15, 17, 18, 19, 20, 21, 23),
    "push": (0, 3, 4, 5, 7, 9, 10, 11, 12, 13, 14, 15, 18, 19, 20, 21, 22, 24, 28, 29),
    "tumble": (0, 1, 2, 5, 6, 7, 9, 10, 12, 15, 16, 17, 18, 19, 21, 25, 26, 28, 32, 35),
    "regrasp": (1, 3, 4, 15, 16, 18, 19, 20, 22, 23, 27, 30, 34, 35, 36, 40, 44, 47, 48, 50),
    "chain": (3, 7, 8, 9, 11, 12, 15, 16, 18, 25, 28, 29, 31, 33, 34, 38, 39, 40, 41, 48),
}
"""By family, the first twenty whose optimal plan has a z of at least a tenth of the weight."""

UNPROVEN: Final = (
    "free/over-there", "tasks/bookshelf", "tasks/corner-pivot", "tasks/ledge",
    "tasks/peg-thin-fingers", "tasks/pick-card", "tasks/pick-card-soft", "tasks/step-over",
)  # fmt: skip
"""Shipped, but exact search takes, or took, longer than a count may wait."""

PROVEN: Final = tuple(name for name in shipped() if name not in UNPROVEN)
SHIPPED: Final = tuple(name for name in PROVEN if not name.startswith("robot/"))
"""Plans for robots have counts of their own."""

RANDOM: Final = tuple(f"random/{family}/{seed}" for family in SEEDS for seed in SEEDS[family])
NAMES: Final = (*SHIPPED, *RANDOM)


@lru_cache(2)
def plan_of(name: str) -> Plan:
    """Return the optimal plan of a scenario."""
    return gm_ompl.plan(name)
