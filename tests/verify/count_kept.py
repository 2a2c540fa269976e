"""A count on free motion: plans without regrasping, by two searches."""

from __future__ import annotations

import numpy as np

from gm_ompl.planners.planner import Status
from gm_ompl.scenario.load import load
from tests.kept import kept, lanes
from tests.verify.counting import Result, count

AGREE = 1e-9
"""Costs are equal up to this, relatively."""

PATIENCE = 20.0
"""What lanes may take [s]."""

BASES = ("tasks/reorient", "tasks/placedown", "tasks/pick-card-soft", "free/out-of-the-corner")


@count(instances=100)
def kept_agreement(instance: int) -> Result:
    """All sets at once find what lanes find, or a bound that is not too high."""
    rng, name = np.random.default_rng(instance), BASES[instance % len(BASES)]
    grid = rng.integers(1, 4, 2).tolist()
    changes = [
        f"fingers.placements.grid={grid}",
        f"friction.environment={rng.uniform(0.15, 0.5):.3f}",
        f"friction.finger={rng.uniform(0.5, 0.9):.3f}",
        f"cost.stability={10.0 ** rng.uniform(-4.0, -2.0):.5f}",
    ]
    if rng.random() < 0.3:
        changes.append("cost.samples_at=ends")
    if name == "tasks/reorient":
        changes.append(f"motion.goal.position=[{0.25 * rng.integers(-6, 7)}, 0, 0.5]")
    if name == "tasks/pick-card-soft":
        x = 0.25 * rng.integers(1, 6)
        changes += [f"motion.goal.position=[{x}, 0, 0.25]", "motion.goal.rotation=any"]
    problem = load(name, tuple(changes)).problem
    other, note = lanes(problem, PATIENCE), f"{name} {' '.join(changes)}"
    if other.cost is None or not other.optimal:
        told = "infeasible" if other.status is Status.INFEASIBLE else "lanes take too long"
        return Result(True, None, note, outcome=told)
    search = kept(problem, other.cost * 1.0001)
    low = search.bound <= other.cost * (1.0 + AGREE) and search.cost >= other.cost * (1.0 - AGREE)
    if not search.proves(other.cost):
        return Result(low, None, note, outcome="regrasping may be cheaper")
    gap = abs(search.cost / other.cost - 1.0) if other.cost else abs(search.cost)
    return Result(low and gap <= AGREE, gap, note, outcome="one optimum")
