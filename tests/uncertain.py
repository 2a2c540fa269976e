"""Random instants of which not everything is known exactly."""

from __future__ import annotations

import dataclasses

import numpy as np

from gm_ompl.contact.state import Instant
from gm_ompl.uncertainty.ranges import Three, Uncertainty
from gm_ompl.uncertainty.worlds import cases_of
from tests.instances import random_instance

MOST_CASES = 32


def uncertain_instance(rng: np.random.Generator, fingers: int | None = None) -> Instant:
    """Return an instant with 1 to 3 fingers and 1 to 32 different cases."""
    while True:
        n = int(rng.integers(1, 4)) if fingers is None else fingers
        instant = random_instance(rng, n)
        instant = dataclasses.replace(instant, uncertainty=random_ranges(rng, instant))
        if instant.uncertainty and len(cases_of(instant)) <= MOST_CASES:
            return instant


def random_ranges(rng: np.random.Generator, instant: Instant) -> Uncertainty:
    """Return ranges of some of an instant's quantities."""
    share = float(rng.choice([0.01, 0.05, 0.1, 0.3]))
    size = float(np.abs(instant.points).max(initial=0.0)) or 1.0

    def some(probability: float) -> float:
        return share * float(rng.random() < probability)

    friction, tips, centre = some(0.6), some(0.6), some(0.5)
    x, y, z = (centre * size * 0.2 * float(rng.random() < 0.6) for _ in range(3))
    offset: Three = (x, y, z)
    return Uncertainty(
        environment_friction=(friction * instant.environment_friction,),
        finger_friction=tuple((tips * instant.friction).tolist()),
        mass=some(0.5) * instant.mass,
        centre_of_mass=offset,
        position=0.1 * size * some(0.2),
        command=some(0.3),
        tilt=0.3 * some(0.2),
    )
