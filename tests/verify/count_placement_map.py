"""Where a finger may go: the map's margins against the reference's, every partner tried."""

from __future__ import annotations

import numpy as np

import gm_ompl
from gm_ompl.contact.decision import Outcome
from gm_ompl.plain.judge import ReferenceJudge
from gm_ompl.reference.modes import decide_modes
from tests.verify.counting import Result, count

SCENARIOS = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp")


@count(instances=500)
def placement_map(instance: int) -> Result:
    """A random placement's best z over all partners is what HiGHS finds by trying every one."""
    rng = np.random.default_rng(instance)
    name, grid = SCENARIOS[rng.integers(len(SCENARIOS))], int(rng.integers(2, 4))
    changes = {
        "fingers.placements.grid": [grid, grid],
        "friction.finger": float(rng.uniform(0.3, 1.0)),
        "friction.environment": float(rng.uniform(0.1, 0.8)),
        "fingers.max_normal_force": float(rng.uniform(4.0, 20.0)),
    }
    scenario, s = gm_ompl.load(name, changes), float(rng.uniform())
    problem, direction = scenario.problem, [1.0] if rng.random() < 0.7 else None
    found = gm_ompl.placement_map(scenario, [s], direction)
    judge = ReferenceJudge(problem)
    row, best = int(rng.integers(len(problem.fingers.placements))), -np.inf
    contacts = judge.contacts(found.moment)
    for other in range(len(problem.fingers.placements)):
        if judge.node_valid(found.moment.pose, (row, other)):
            decision = decide_modes(problem.instant(contacts, (0, 1), (row, other)))
            if decision.outcome is Outcome.STABLE:
                best = max(best, decision.z)
    z, scale = float(found.z[0, row]), problem.force_scale
    same = z == best or abs(z - best) <= 1e-6 * max(abs(best), 1e-3 * scale)
    return Result(
        holds=bool(same),
        note=f"seed {instance}: {name}, row {row}: {z} instead of {best}",
        outcome=found.finding(0, row).name.lower(),
    )
