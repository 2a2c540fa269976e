"""Counts on ways through the air: a sampling planner's second opinion, and plans' ways swept."""

from __future__ import annotations

import numpy as np

import gm_ompl
from gm_ompl.checking.recheck import Recheck
from gm_ompl.checking.report import Findings, Violation
from gm_ompl.checking.ways import check_landing, check_way
from gm_ompl.plain.air import Air
from gm_ompl.planfile.model import Plan, RegraspStep
from gm_ompl.scenario.scenario import Scenario
from tests.cluttered import cluttered, judged, sampled_out, shaft, wider
from tests.feasibility.test_reach import moved_case, reach_case
from tests.verify.counting import Result, count

SAMPLES = 20_000
MOST_NODES = 1_000
PLANNERS = {
    "astar": 200, "HybridRRTConnect": 200, "HybridRRT": 200, "RRTConnect": 200, "HybridRRTstar": 20
}  # fmt: skip
"""Iterations at most, of each planner."""
FAMILIES = ("regrasp", "tumble", "small", "planar", "chain")


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


@count(120)
def deep_pockets(instance: int) -> Result:
    """A wider fingertip has no way out in 100 samples for each of the fill's up to 1,000 nodes."""
    rng = np.random.default_rng([8, instance])
    tree = cluttered(rng)
    judge, pose = judged(tree)
    for row in rng.permutation(np.flatnonzero(judge.node(pose).free[0]))[:6].tolist():
        judge, pose = judged(tree)  # nothing is filled yet
        if judge.reach.outside(pose, 0, (), row) or judge.reach.undecided:
            continue
        nodes = judge.reach.space(pose, 0, ()).nodes
        if 0 < nodes <= MOST_NODES:
            wide = Air(wider(judge.problem), pose, 0, ())
            found = sampled_out(wide, row, rng, 100 * nodes)
            note = f"scene {instance}, placement {row}, {nodes} nodes"
            return Result(not found, note=note, outcome="a pocket")
    return Result(True, outcome="none so small")


@count(60)
def moved_scenes(instance: int) -> Result:
    """Moved and turned about the vertical, each placement of a scene is reachable as before."""
    try:
        told = moved_case(instance)
    except AssertionError as error:
        return Result(False, note=f"scene {instance}: {error}")
    return Result(True, outcome="none in a pocket" if all(told) else "some in pockets")


@count(1000)
def ways(instance: int) -> Result:
    """No first touch or way of any planner's plan is refused by the sweeps of ``check``."""
    planner, most = list(PLANNERS.items())[instance % len(PLANNERS)]
    family = (*FAMILIES, "shaft")[instance // len(PLANNERS) % (len(FAMILIES) + 1)]
    scenario: object = f"random/{family}/{instance}"
    if family == "shaft":
        scenario = shaft(np.random.default_rng([11, instance]))
    plan = gm_ompl.plan(scenario, planner, max_iterations=most, time_limit=20, seed=instance)  # type: ignore[arg-type]
    if not plan.steps:
        return Result(True, outcome="no plan")
    refused = through_air(plan)
    regrasps = sum(step.kind == "regrasp" for step in plan.steps)
    return Result(
        not refused,
        note=f"{family} {instance}, {plan.planner}: {'; '.join(map(str, refused))}",
        outcome="with regrasps" if regrasps else "without regrasps",
    )


def through_air(plan: Plan) -> list[Violation]:
    """Return what ``check`` has against a plan's first touches and ways: its sweeps, no more."""
    problem = Scenario.from_resolved(plan.scenario, "a plan").problem
    recheck, table = Recheck(problem), problem.fingers.placements
    refused = list[Violation]()
    for number, step in enumerate(plan.steps):
        found = Findings(number)
        places = [record.row(table) for record in step.placements]
        rows = tuple(row for row in places if row is not None)
        assert len(rows) == problem.fingers.count
        if number == 0:
            check_landing(recheck, problem.motion.pose(problem.start), rows, found)
        if isinstance(step, RegraspStep):
            target = step.to.row(table)
            assert target is not None
            pose = problem.motion.pose(step.at)
            check_way(recheck, step, (rows, target), pose, found)
        refused += found.violations
    return refused
