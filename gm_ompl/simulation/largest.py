"""The largest disturbance withstood along an execution, beside z."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.simulation.disturb import instants
from gm_ompl.simulation.execute import Setup
from gm_ompl.simulation.pulses import Disturber, Trial
from gm_ompl.simulation.timeline import PHASES

LADDER = (0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0)
"""Strengths tried in turn for the largest withstood, over z."""

AROUND = 19
"""Directions in which each of them is tried: a quarter of the 76."""


@dataclass(frozen=True)
class Largest:
    """The largest disturbance withstood at one place of a plan.

    Attributes:
        time: when the pulses begin [s].
        phase: what happens then.
        z: the stability margin there.
        fraction: the largest of ``LADDER`` up to which every pulse was withstood, in all directions
            tried; 0 if the first was not.
        direction: number of a direction in which the next was not withstood; -1 if all were.
    """

    time: float
    phase: str
    z: float
    fraction: float
    direction: int

    def line(self) -> str:
        """Return it as a line of text."""
        lost = "" if self.direction < 0 else f"; direction {self.direction} first to be lost"
        return (
            f"  at {self.time:.2f} s ({self.phase}) z is {self.z:.3g}, withstood "
            f"{self.fraction:g} z{lost}"
        )


def largest(setup: Setup, count: int, seed: int) -> tuple[Largest, ...]:
    """Return the largest disturbances withstood at ``count`` random times.

    Args:
        setup: the plan, made ready.
        count: number of times.
        seed: of times and directions.
    """
    rng = np.random.default_rng(seed)
    when = instants(setup, count, rng)
    disturber = Disturber(setup, when.tolist())
    found = []
    for instant in when.tolist():
        tried = rng.permutation(len(DIRECTIONS))[:AROUND].tolist()
        reached, lost = 0.0, -1
        for fraction in LADDER:
            trials = (_try(disturber, instant, number, fraction) for number in tried)
            lost = next((trial.direction for trial in trials if not trial.withstood), -1)
            if lost >= 0:
                break
            reached = fraction
        line = setup.timeline
        found.append(
            Largest(
                time=float(line.time[instant]),
                phase=PHASES[int(line.phase[instant])],
                z=float(line.z[instant]),
                fraction=reached,
                direction=lost,
            )
        )
    return tuple(found)


def _try(disturber: Disturber, instant: int, number: int, fraction: float) -> Trial:
    direction = DIRECTIONS[number] / np.linalg.norm(DIRECTIONS[number])
    return disturber.trial(instant, direction, number, fraction)
