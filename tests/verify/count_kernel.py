"""The compiled kernel against the reference on random instants."""

from __future__ import annotations

import numpy as np

from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.reference.modes import decide_modes
from gm_ompl.reference.statics import force_unit
from tests.instances import random_instance
from tests.mechanics.agreement import borderline, compared
from tests.verify.counting import Result, count


@count(instances=5000)
def kernel_agreement(instance: int) -> Result:
    """The kernel decides like the reference: verdict, modes, z to 1e-6 of max(z, 1e-3 M g)."""
    return agreement(instance, random_instance(np.random.default_rng(instance)))


def agreement(seed: int, instant: Instant) -> Result:
    """Return how kernel and reference compare on an instant."""
    mine, theirs = decide_instant(instant), decide_modes(instant)
    found = compared(mine, theirs, force_unit(instant))
    close = not found.holds and borderline(instant)
    return Result(
        holds=found.holds,
        worst=found.error if np.isfinite(found.error) else None,
        note=f"seed {seed}: {found.note}",
        marginal=close,
        outcome=theirs.outcome.name.lower(),
    )
