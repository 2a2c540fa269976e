"""Counts on the shipped scenarios: what is expected of them, and other searches' costs."""

from __future__ import annotations

import gm_ompl
from gm_ompl.scenario.load import load, shipped
from tests.verify.counting import Result, count
from tests.verify.expectations import disagreements

ON_PATHS = [name for name in shipped() if load(name).problem.motion.dimension == 1]
PAPER = [name for name in shipped() if name.startswith("paper/")]


@count(instances=len(ON_PATHS))
def expectations(instance: int) -> Result:
    """The shipped scenarios with one degree of freedom come out as they say they must.

    Without a robot's hand, whose reach is sampled, they are proven optimal; `check` confirms every
    step (worst: seconds of search).
    """
    name = ON_PATHS[instance]
    plan = gm_ompl.plan(name)
    wrong = list(disagreements(plan, load(name).model.expect))
    sampled = load(name).problem.hand is not None
    if plan.status == "solved" and not (plan.optimal or sampled):
        wrong.append("not proven optimal")
    report = gm_ompl.check(plan)
    if not report.holds:
        wrong.append(report.table())
    return Result(holds=not wrong, worst=plan.statistics.time_s, note=f"{name}: {'; '.join(wrong)}")


@count(instances=len(PAPER))
def dijkstra_full_size(instance: int) -> Result:
    """Dijkstra's algorithm on the paper's graph finds the same optimal cost at full size.

    Worst: relative difference.
    """
    name = PAPER[instance]
    plain, ours = gm_ompl.plan(name, "dijkstra"), gm_ompl.plan(name)
    assert plain.cost is not None and ours.cost is not None
    gap = abs(plain.cost - ours.cost) / plain.cost
    return Result(
        holds=plain.optimal and ours.optimal and gap <= 1e-6,
        worst=gap,
        note=f"{name}: {plain.cost} by dijkstra, {ours.cost} by astar",
    )
