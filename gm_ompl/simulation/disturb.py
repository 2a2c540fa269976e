"""Pulses of disturbance against an execution: what z promises, put to the test."""

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
