"""What a plan claims, tried where it claims least: pulses in the directions that statics fears.

Playing a plan back shows that the motion works. It does not show z: a finger that is there for
disturbances alone is not missed before a disturbance comes. Problem (6) says that every wrench
z l_i can be resisted; here the weakest of them, by the statics of the contacts, modes and forces
that are executed, acts on the execution.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.plan.arcs import arc_of
from gm_ompl.plan.model import DisplacementStep
from gm_ompl.reference.stability import DIRECTIONS, resistances
from gm_ompl.simulation.balance import statics_at
from gm_ompl.simulation.disturb import STEADY
from gm_ompl.simulation.execute import Setup
from gm_ompl.simulation.measure import force_unit
from gm_ompl.simulation.pulses import Disturber, Trial
from gm_ompl.simulation.report import plain
from gm_ompl.simulation.timeline import PHASES

FRACTION = 0.8
"""Strength of the pulses, of the z l_i that the plan claims to resist."""

LOOKS = 4
"""Places looked at in each part of the motion, beside the one that claims least."""

DOUBT = 0.99
"""A place is taken before an earlier one if it resists less than this of that one's share."""

ALIKE = 1e-6
"""Resistances that differ by less, relatively, are equal: the first direction is taken."""


@dataclass(frozen=True)
class ProbeReport:
    """Pulses where the plan claims least.

    Attributes:
        fraction: peak of the pulses over z l_i.
        trials: in order of time.
    """

    fraction: float
    trials: tuple[Trial, ...]

    @property
    def lost(self) -> tuple[Trial, ...]:
        """The pulses that were not withstood."""
        return tuple(trial for trial in self.trials if not trial.withstood)

    @property
    def share(self) -> float:
        """Share of the pulses withstood; 1 where there is nothing to try."""
        return 1.0 - len(self.lost) / max(len(self.trials), 1)

    @property
    def findings(self) -> tuple[str, ...]:
        """Why the plan's claim does not hold; empty if it does."""
        return tuple(
            f"a z of {trial.z:.4g} is claimed at {trial.time:.2f} s, but {self.fraction:g} z l_i, "
            f"i = {trial.direction}, leaves the object {100 * trial.offset:.2g}% of D off, "
            f"slipping by {100 * trial.slip:.2g}%"
            for trial in self.lost
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        return {"share": self.share, **plain(asdict(self))}

    def table(self) -> str:
        """Return the report as lines of text."""
        tried = len(self.trials)
        lines = [
            f"{self.fraction:g} z l_i in the weakest directions: "
            f"{tried - len(self.lost)} of {tried} pulses withstood"
        ]
        return "\n".join([*lines, *(f"NOT: {finding}" for finding in self.findings)])


def probe(setup: Setup, count: int) -> ProbeReport:
    """Put ``count`` pulses on the execution, each on a fresh one, spread over the whole motion.

    The motion is cut into ``count`` equal parts. In each the pulse comes where the least z is
    claimed, or where more is claimed (at least z_min) than what is executed resists, in the
    direction in which it resists least.

    Args:
        setup: the plan, made ready.
        count: number of pulses; none comes in a part where z is infinite.
    """
    places = [_doubtful(setup, part) for part in np.array_split(_usable(setup), count) if len(part)]
    disturber, trials = Disturber(setup, [instant for instant, _ in places]), []
    for instant, number in places:
        trials.append(disturber.trial(instant, DIRECTIONS[number], number, FRACTION))
    return ProbeReport(FRACTION, tuple(trials))


def _usable(setup: Setup) -> IntArray:
    """Return the instants of motion at which the plan claims a finite z."""
    line = setup.timeline
    finite = np.isfinite(line.z) & (line.z < STEADY / setup.units.force)
    usable: IntArray = np.flatnonzero((line.phase == PHASES.index("move")) & finite)
    return usable


def _doubtful(setup: Setup, part: IntArray) -> tuple[int, int]:
    """Return the instant of ``part`` to try, and the direction in which least is resisted there.

    Of the place that claims the least z and a few others it is the one where what is executed
    resists least of what is claimed; where all resist what they claim, the first.
    """
    z, z_min = setup.timeline.z, setup.problem.mechanics.z_min
    others = part[np.linspace(0, len(part) - 1, LOOKS + 2)[1:-1].astype(int)]
    best, chosen = np.inf, (-1, -1)
    for instant in [int(part[np.argmin(z[part])]), *others.tolist()]:
        found = resisted(setup, instant)
        least = float(found.min())
        share = min(least * force_unit(setup.problem) / max(float(z[instant]), z_min), 1.0)
        if share < best * DOUBT:
            number = int(np.flatnonzero(found <= least * (1.0 + ALIKE))[0])
            best, chosen = share, (instant, number)
    return chosen


def resisted(setup: Setup, instant: int) -> Array:
    """Return z_i, (76,), of what is executed at an instant of motion, over ``Statics.scale``."""
    line, problem = setup.timeline, setup.problem
    step, k = setup.plan.steps[int(line.step[instant])], int(line.segment[instant])
    assert isinstance(step, DisplacementStep)
    segment, n = step.segments[k], problem.fingers.count
    middle = arc_of(step).middles(len(step.segments))[k]
    model = statics_at(problem, middle, step.placements, range(n))
    force = np.array([mode == "force" for mode in segment.modes], dtype=bool)
    f_com = np.array([f or 0.0 for f in segment.f_com]) / model.scale
    return resistances(model, np.where(force, f_com, model.f_max), force)
