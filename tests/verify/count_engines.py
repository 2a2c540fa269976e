"""A count on what two simulators say of the same pulses: MuJoCo and DART."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.simulation.disturb import instants, resisted
from gm_ompl.simulation.engine import EngineName
from gm_ompl.simulation.execute import Setup, prepare
from gm_ompl.simulation.measure import MOVE
from gm_ompl.simulation.pulses import Disturber
from tests.executed import NAMES, plan_of
from tests.verify.counting import Result, count

PULSES, TOGETHER = 300, 5  # pulses, and how many of them a plan is played for
WEAKEST, STRONGEST = 0.5, 3.0  # over z
TOWARDS = 4.0  # how much strong ones are preferred: most of the weak ones are withstood by both
ENGINES: tuple[EngineName, EngineName] = ("mujoco", "dart")


@lru_cache(1)
def _disturbed(group: int) -> tuple[Setup, list[int], tuple[Disturber, ...]]:
    """Return the plan that some pulses are put on, when they begin, and who puts them."""
    rng = np.random.default_rng(group)
    plan = plan_of(NAMES[int(rng.integers(len(NAMES)))])
    setups = [prepare(plan, engine=engine) for engine in ENGINES]
    when = instants(setups[0], TOGETHER, rng).tolist()
    return setups[0], when, tuple(Disturber(setup, when) for setup in setups)


def _weakest(setup: Setup, instant: int) -> Array:
    """Return the direction in which what is executed resists least, about then, in motion."""
    moving = np.flatnonzero(setup.timeline.phase == MOVE)
    found = resisted(setup, int(moving[np.abs(moving - instant).argmin()]))
    direction: Array = DIRECTIONS[int(found.argmin())]
    return direction


def pulse_of(instance: int) -> tuple[str, int, Array, float, tuple[Disturber, ...]]:
    """Return a pulse: the plan's name, when it begins, its direction, over z, and who puts it."""
    group, number = divmod(instance, TOGETHER)
    setup, when, disturbers = _disturbed(group)
    rng = np.random.default_rng((instance, 1))
    fraction = WEAKEST + (STRONGEST - WEAKEST) * float(rng.uniform()) ** (1.0 / TOWARDS)
    direction = rng.normal(size=6)
    if instance % 2 == 0:
        direction = _weakest(setup, when[number])
    direction = direction / np.linalg.norm(direction)
    return setup.problem.name, when[number], direction, fraction, disturbers


@count(instances=PULSES)
def engines_under_pulses(instance: int) -> Result:
    """MuJoCo and DART agree whether a pulse of 0.5 to 3 z is withstood.

    Every other one comes where least is resisted.
    """
    name, instant, direction, fraction, disturbers = pulse_of(instance)
    withstood = [one.trial(instant, direction, -1, fraction).withstood for one in disturbers]
    words = ["withstood" if held else "lost" for held in withstood]
    note = f"{name}: {fraction:.2f} z at instant {instant}"
    agreed = withstood[0] == withstood[1]
    return Result(agreed, None, note, outcome=f"{words[0]} by MuJoCo, {words[1]} by DART")
