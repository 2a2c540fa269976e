"""Sec. 3.4 in several cases at once, on random instants."""

from __future__ import annotations

import numpy as np

from gm_ompl.errors import SolverError
from gm_ompl.mechanics.case_alternatives import decide_in_cases
from gm_ompl.reference.modes import decide_modes, margin
from gm_ompl.reference.statics import force_unit
from gm_ompl.uncertainty.worlds import cases_of
from tests.uncertain import uncertain_instance
from tests.verify.counting import Result, count

AGREE = 1e-6
"""Largest difference in z, over max(z, 1e-3 M g)."""


@count(instances=2000)
def robust_agreement(instance: int) -> Result:
    """The kernel decides for 1 to 32 cases at once like the reference: z to 1e-6, its f_com too."""
    rng = np.random.default_rng([instance, 24])
    instant = uncertain_instance(rng)
    number, unit = len(cases_of(instant)), force_unit(instant)
    note = f"seed {instance}: {number} cases"
    try:
        theirs = decide_modes(instant)
        mine = decide_in_cases(instant)
    except SolverError:  # planning asks the reference then, which proves its answers
        return Result(holds=True, note=note, outcome="left to the reference")
    error, allowed = np.inf, AGREE * max(abs(theirs.z), 1e-3 * unit)
    if mine.outcome is theirs.outcome:
        error = 0.0 if mine.z == theirs.z else abs(mine.z - theirs.z)
        if mine.modes and np.isfinite(mine.z):
            error = max(error, abs(margin(instant, mine.modes, mine.f_com) - mine.z))
    return Result(
        holds=bool(error <= allowed),
        worst=float(error / allowed * AGREE),
        note=f"{note}: kernel {mine}, reference {theirs}",
        outcome=mine.outcome.name.lower(),
    )
