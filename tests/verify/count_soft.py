"""Soft fingertips, and equilibrium alone, on random instants."""

from __future__ import annotations

import numpy as np

from gm_ompl.contact.decision import Outcome
from gm_ompl.mechanics.instant import decide_instant
from tests.instances import random_instance, softened
from tests.mechanics.equilibrium_alone import balanced
from tests.verify.count_kernel import agreement
from tests.verify.counting import Result, count


@count(instances=2000)
def soft_agreement(instance: int) -> Result:
    """With soft fingertips the kernel decides like the reference: z to 1e-6 of max(z, 1e-3 M g)."""
    rng = np.random.default_rng(instance)
    return agreement(instance, softened(rng, random_instance(rng)))


@count(instances=2000)
def equilibrium_alone(instance: int) -> Result:
    """With z_min = 0 what passes Problem (5) is feasible where a plain program finds a balance."""
    rng = np.random.default_rng(instance)
    instant = random_instance(rng)
    if instance % 2:
        instant = softened(rng, instant)
    decision, plain = decide_instant(instant), balanced(instant)
    refused = decision.outcome is Outcome.INTERNAL_FORCE
    return Result(
        holds=refused or (decision.outcome is Outcome.STABLE) == plain,
        note=f"seed {instance}: {decision}, balanced: {plain}",
        marginal=plain is None and not refused,
        outcome=decision.outcome.name.lower(),
    )
