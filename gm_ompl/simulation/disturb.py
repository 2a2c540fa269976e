"""Pulses of disturbance against an execution: what z promises, and the largest withstood."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gm_ompl.arrays import IntArray
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.simulation.execute import Setup
from gm_ompl.simulation.pulses import PULSE, REST, Disturber, Trial
from gm_ompl.simulation.report import plain
from gm_ompl.simulation.timeline import PHASES

STEADY = 1e6
"""A margin above this many times the force unit is no number to scale a pulse by."""


@dataclass(frozen=True)
class DisturbanceReport:
    """All pulses of one strength.

    Attributes:
        fraction: peak of the pulses over z.
        pulse: their length [s].
        rest: time from the end of a pulse to the judgement [s].
        trials: in order of time.
    """

    fraction: float
    pulse: float
    rest: float
    trials: tuple[Trial, ...]

    @property
    def share(self) -> float:
        """Share of the pulses withstood."""
        return sum(trial.withstood for trial in self.trials) / max(len(self.trials), 1)

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        return {"share": self.share, **plain(asdict(self))}

    def table(self) -> str:
        """Return the report as lines of text."""
        lost = [trial for trial in self.trials if not trial.withstood]
        lines = [
            f"disturbances of {self.fraction:g} z, pulses of {self.pulse:g} s: "
            f"{len(self.trials) - len(lost)} of {len(self.trials)} withstood "
            f"({100 * self.share:.1f}%)"
        ]
        for phase in PHASES:
            of_phase = [trial for trial in self.trials if trial.phase == phase]
            if of_phase:
                held = sum(trial.withstood for trial in of_phase)
                lines.append(f"  while {phase:8} {held} of {len(of_phase)}")
        lines += [
            f"  lost at {trial.time:.2f} s ({trial.phase}), {_name(trial.direction)}, "
            f"z {trial.z:.3g}: {100 * trial.offset:.2g}% of D off, slipping {100 * trial.slip:.2g}%"
            for trial in lost[:10]
        ]
        return "\n".join(lines)


def _name(direction: int) -> str:
    return "a random direction" if direction < 0 else f"direction {direction}"


def instants(setup: Setup, count: int, rng: np.random.Generator) -> IntArray:
    """Return instants, in order, drawn evenly from the first motion to the end of the last.

    Where the plan states an infinite z there is nothing to scale a pulse by: none is drawn there.
    """
    line = setup.timeline
    moving = np.flatnonzero(line.phase == PHASES.index("move"))
    usable = np.arange(moving[0], moving[-1] + 1)
    finite = np.isfinite(line.z[usable]) & (line.z[usable] < STEADY / setup.units.force)
    drawn: IntArray = np.sort(rng.choice(usable[finite], count))
    return drawn


def disturb(setup: Setup, fraction: float, count: int, seed: int) -> DisturbanceReport:
    """Put ``count`` pulses on the execution, each on a fresh one.

    Half go in the 76 directions in turn, half in random ones, at random times.

    Args:
        setup: the plan, made ready.
        fraction: peak of each pulse over z.
        count: number of pulses.
        seed: of times and directions.
    """
    rng = np.random.default_rng(seed)
    when = instants(setup, count, rng)
    order = rng.permutation(len(DIRECTIONS))
    disturber = Disturber(setup, when.tolist())
    trials = []
    for k, instant in enumerate(when.tolist()):
        number = int(order[k // 2 % len(order)]) if k % 2 == 0 else -1
        direction = DIRECTIONS[number] if number >= 0 else rng.normal(size=6)
        unit = direction / np.linalg.norm(direction)
        trials.append(disturber.trial(instant, unit, number, fraction))
    return DisturbanceReport(fraction, PULSE, REST, tuple(trials))


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
