"""Counts on the random families: every search ends in one of the ways it may end."""

from __future__ import annotations

import math
from collections.abc import Callable

import gm_ompl
from tests.verify.counting import Result, count

SEEDS = 200
LIMIT = 20.0
"""Wall time per search [s]."""


def _ended(family: str, seed: int) -> Result:
    name = f"random/{family}/{seed}"
    plan = gm_ompl.plan(name, time_limit=LIMIT)
    report = gm_ompl.check(plan)
    bound, wrong = plan.lower_bound, ""
    if not report.holds:
        wrong = report.table()
    elif plan.status == "solved" and not plan.optimal:
        assert plan.cost is not None
        if bound is None or not 0.0 <= bound <= plan.cost:
            wrong = f"solved at {plan.cost} with the bound {bound}"
        elif plan.statistics.time_s < LIMIT:
            wrong = f"solved at {plan.cost}, stopped early with the bound {bound}"
    elif plan.status == "budget" and not (bound is not None and math.isfinite(bound)):
        wrong = f"budget spent with the bound {bound}"
    elif plan.status == "interrupted":
        wrong = "interrupted"
    ended = {"infeasible": "proven infeasible", "budget": "budget spent, bound valid"}
    outcome = "proven optimal" if plan.optimal else ended.get(plan.status, plan.status)
    return Result(
        holds=not wrong, worst=plan.statistics.time_s, note=f"{name}: {wrong}", outcome=outcome
    )


def _family(family: str) -> None:
    def ends(instance: int) -> Result:
        return _ended(family, instance)

    ends.__name__ = f"family_{family}"
    ends.__doc__ = (
        f"random/{family}: solved to proven optimality (and checked), proven infeasible, or budget "
        f"({LIMIT:g} s) spent with a valid bound (worst: seconds)."
    )
    register: Callable[[Callable[[int], Result]], Callable[[int], Result]] = count(SEEDS)
    register(ends)


for _name in ("slide", "push", "tumble", "regrasp", "chain"):
    _family(_name)
