"""Counts on ways through the air: a sampling planner's second opinion, and plans' ways swept."""

from __future__ import annotations

import numpy as np

import gm_ompl
from gm_ompl.planfile.model import Plan
from tests.cluttered import shaft
from tests.feasibility.test_reach import reach_case
from tests.verify.counting import Result, count

SAMPLES = 20_000
PLANNERS = ("astar", "HybridRRTConnect", "HybridRRT", "RRTConnect", "HybridRRTstar")
FAMILIES = ("regrasp", "tumble", "small", "planar", "chain")
AIR = {"first touches", "way", "leaving"}


@count(500)
def reach(instance: int) -> Result:
    """Pockets have no way for a wider fingertip in 20,000 samples; every way out is swept clear."""
    try:
        seen = reach_case(instance, SAMPLES, 4)
    except AssertionError as error:
        return Result(False, note=f"scene {instance}: {error}")
    outcome = "some in pockets" if seen["pockets"] else "none in a pocket"
    undecided = seen["undecided"] > 0
    return Result(True, outcome=outcome, marginal=undecided, note=f"scene {instance}")


@count(1000)
def ways(instance: int) -> Result:
    """No first touch or way of any planner's plan is refused by ``check``."""
    planner = PLANNERS[instance % len(PLANNERS)]
    family = (*FAMILIES, "shaft")[instance // len(PLANNERS) % (len(FAMILIES) + 1)]
    scenario: object = f"random/{family}/{instance}"
    if family == "shaft":
        scenario = shaft(np.random.default_rng([11, instance]))
    plan = gm_ompl.plan(scenario, planner, max_iterations=500, time_limit=20, seed=instance)  # type: ignore[arg-type]
    if not plan.steps:
        return Result(True, outcome="no plan")
    return _checked(plan, f"{scenario if isinstance(scenario, str) else 'shaft'} {instance}")


def _checked(plan: Plan, note: str) -> Result:
    refused = [v for v in gm_ompl.check(plan).violations if v.topic in AIR]
    regrasps = sum(step.kind == "regrasp" for step in plan.steps)
    return Result(
        not refused,
        note=f"{note}, {plan.planner}: {'; '.join(map(str, refused))}",
        outcome="with regrasps" if regrasps else "without regrasps",
    )
