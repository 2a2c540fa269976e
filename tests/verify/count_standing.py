"""Counts of where objects stand: heights found, and one tolerance for all contacts."""

from __future__ import annotations

import gm_ompl
from tests.executed import PROVEN
from tests.verify.counting import Result, count
from tests.verify.resting import hull_in_resting_poses, notched_bar_in_resting_poses

FAMILIES = ("small", "slide", "push", "tumble", "regrasp", "chain")
RANDOM = 300
COARSE = {"fingers.placements.grid": [3, 2], "lattice.segments": 4}
LIMIT = 60_000
"""Iterations; both searches end in the same way under it."""


@count(instances=200)
def rest_hulls(instance: int) -> Result:
    """`rest` is the height of a random hull in all resting poses (worst: error over its size)."""
    worst = max(abs(a - b) / size for a, b, size in hull_in_resting_poses(instance))
    return Result(worst <= 1e-12, worst, f"seed {instance}")


@count(instances=200)
def rest_meshes(instance: int) -> Result:
    """`rest` is the height of a random notched bar, a mesh, likewise (worst: likewise)."""
    worst = max(abs(a - b) / size for a, b, size in notched_bar_in_resting_poses(instance))
    return Result(worst <= 1e-12, worst, f"seed {instance}")


@count(instances=RANDOM + len(PROVEN))
def contact_tolerances(instance: int) -> Result:
    """Contacts up to 1e-5 D give the cost that contacts up to 1e-7 D give (worst: difference)."""
    if instance < RANDOM:
        family, seed = FAMILIES[instance % len(FAMILIES)], instance // len(FAMILIES)
        name = f"random/{family}/{seed}"
        scenario = gm_ompl.load(name, {} if family == "small" else COARSE)
        if family == "chain":
            scenario = gm_ompl.load(name, {**COARSE, "lattice.segments": [4, 4, 4]})
    else:
        name = PROVEN[instance - RANDOM]
        scenario = gm_ompl.load(name)
    wide, narrow = (
        gm_ompl.plan(scenario.with_({"mechanics.contact_tolerance": value}), max_iterations=LIMIT)
        for value in (1e-5, 1e-7)
    )
    outcome = "proven optimal" if wide.optimal else wide.status
    if wide.cost is None or narrow.cost is None:
        return Result(wide.status == narrow.status, None, f"{name}: {wide.status}", outcome=outcome)
    apart = abs(wide.cost - narrow.cost) / narrow.cost
    return Result(apart <= 1e-9, apart, name, outcome=outcome)
