"""Pulses of disturbance put on an execution: at random, where z is least, and ever stronger.

Playing a plan back shows that the motion works. It does not show z: a finger that is there for
disturbances alone is not missed before a disturbance comes. Problem (6) says that every wrench
z l_i can be resisted; here such wrenches act on the execution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.reference.stability import DIRECTIONS, resistances
from gm_ompl.simulation.balance import statics_at
from gm_ompl.simulation.execute import Setup
from gm_ompl.simulation.measure import MOVE
from gm_ompl.simulation.pulses import Disturber, PulseReport, direction_name
from gm_ompl.simulation.segments import commanded, planned_segments
from gm_ompl.simulation.timeline import PHASES
from gm_ompl.simulation.world import force_unit

STEADY = 1e6  # a margin above this many times the force unit is no number to scale a pulse by
PROBED = 0.8  # strength of the pulses where z is least, of the z l_i that the plan claims to resist
LOOKS = 4  # places looked at in each part of the motion, beside the one that claims least

DOUBT = 0.99
"""A place is taken before an earlier one if it resists less than this of that one's share."""

ALIKE = 1e-6  # resistances that differ by less, relatively, are equal: the first direction is taken

LADDER = (0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0)
"""Strengths tried in turn for the largest withstood, over z."""

AROUND = 19  # directions in which each of them is tried: a quarter of the 76


def _finite(setup: Setup) -> BoolArray:
    """Return (T,), where the plan claims a margin that a pulse can be scaled by."""
    z = setup.timeline.z
    return np.isfinite(z) & (z < STEADY / setup.units.force)


def instants(setup: Setup, count: int, rng: np.random.Generator) -> IntArray:
    """Return instants, in order, drawn evenly from the first motion to the end of the last."""
    moving = np.flatnonzero(setup.timeline.phase == MOVE)
    usable = np.arange(moving[0], moving[-1] + 1)
    drawn: IntArray = np.sort(rng.choice(usable[_finite(setup)[usable]], count))
    return drawn


def disturb(setup: Setup, fraction: float, count: int, seed: int) -> PulseReport:
    """Put ``count`` pulses on the execution, each on a fresh one.

    Half go in the 76 directions in turn, half in random ones, at random times; the peak of
    each is ``fraction`` of z.
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
    return PulseReport(fraction, tuple(trials))


def probe(setup: Setup, count: int) -> PulseReport:
    """Put ``count`` pulses on the execution, each on a fresh one, spread over the whole motion.

    The motion is cut into ``count`` equal parts. In each, unless z is infinite there, the
    pulse comes where the least z is claimed, or where more is claimed (at least z_min) than
    what is executed resists, in the direction in which it resists least.
    """
    usable = np.flatnonzero((setup.timeline.phase == MOVE) & _finite(setup))
    places = [_doubtful(setup, part) for part in np.array_split(usable, count) if len(part)]
    disturber = Disturber(setup, [instant for instant, _ in places])
    trials = (disturber.trial(k, DIRECTIONS[i], i, PROBED) for k, i in places)
    return PulseReport(PROBED, tuple(trials))


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
        least, claimed = float(found.min()), max(float(z[instant]), z_min)
        share = 1.0  # of nothing claimed all is resisted
        if claimed > 0.0:
            share = min(least * force_unit(setup.problem) / claimed, 1.0)
        if share < best * DOUBT:
            number = int(np.flatnonzero(found <= least * (1.0 + ALIKE))[0])
            best, chosen = share, (instant, number)
    return chosen


def resisted(setup: Setup, instant: int) -> Array:
    """Return z_i, (76,), of what is executed at an instant of motion, over ``Statics.scale``."""
    line, problem = setup.timeline, setup.problem
    number = int(line.step[instant])
    segment = planned_segments(problem, number, setup.plan.steps[number])[
        int(line.segment[instant])
    ]
    fingers = range(problem.fingers.count)
    model = statics_at(problem, segment.part.middle, segment.placements, fingers)
    force, f_com = commanded(segment.record)
    return resistances(model, np.where(force, f_com / model.scale, model.f_max), force)


@dataclass(frozen=True)
class Largest:
    """The largest disturbance withstood at one place of a plan."""

    time: float  # when the pulses begin [s]
    phase: str  # what happens then
    z: float  # the stability margin there
    # the largest of ``LADDER`` up to which every pulse was withstood, in all directions tried; 0
    # if the first was not
    fraction: float
    direction: int  # number of a direction in which the next was not withstood; -1 if all were

    def table(self) -> str:
        """Return it as a line of text."""
        lost = f"; {direction_name(self.direction)} first to be lost" if self.direction >= 0 else ""
        return (
            f"  at {self.time:.2f} s ({self.phase}) z is {self.z:.3g}, withstood "
            f"{self.fraction:g} z{lost}"
        )


def largest(setup: Setup, count: int, seed: int) -> tuple[Largest, ...]:
    """Return the largest disturbances withstood at ``count`` random times."""
    rng, line = np.random.default_rng(seed), setup.timeline
    when = instants(setup, count, rng).tolist()
    disturber = Disturber(setup, when)
    units = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
    found = []
    for k in when:
        tried = rng.permutation(len(DIRECTIONS))[:AROUND].tolist()
        reached, lost = 0.0, -1
        for fraction in LADDER:
            trials = (disturber.trial(k, units[i], i, fraction) for i in tried)
            lost = next((trial.direction for trial in trials if not trial.withstood), -1)
            if lost >= 0:
                break
            reached = fraction
        phase = PHASES[int(line.phase[k])]
        found.append(Largest(float(line.time[k]), phase, float(line.z[k]), reached, lost))
    return tuple(found)
