"""Counts on what two simulators say of the same executions: MuJoCo's and DART's."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.reference.stability import DIRECTIONS
from gm_ompl.simulation.disturb import instants, resisted
from gm_ompl.simulation.engine import EngineName
from gm_ompl.simulation.execute import Setup, execute, prepare
from gm_ompl.simulation.measure import MOVE
from gm_ompl.simulation.pulses import Disturber
from tests.executed import NAMES, plan_of
from tests.verify.counting import Result, count

PULSES, TOGETHER = 300, 5  # pulses, and how many of them a plan is played for
WEAKEST, STRONGEST = 0.5, 3.0  # over z
ENGINES: tuple[EngineName, EngineName] = ("mujoco", "dart")


def _agreed(one: bool, other: bool, words: tuple[str, str], note: str) -> Result:
    """Return whether both say the same: yes in the first word, no in the second."""
    outcome = f"both {words[not one]}" if one == other else f"MuJoCo alone {words[not one]}"
    return Result(one == other, None, note, outcome=outcome)


@count(instances=len(NAMES))
def engines(instance: int) -> Result:
    """MuJoCo and DART agree whether a plan holds when executed."""
    plan = plan_of(NAMES[instance])
    reports = [execute(prepare(plan, engine=engine)) for engine in ENGINES]
    note = "\n".join([NAMES[instance], *(report.table() for report in reports)])
    return _agreed(reports[0].holds, reports[1].holds, ("hold", "fail"), note)


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


@count(instances=PULSES)
def engines_under_pulses(instance: int) -> Result:
    """MuJoCo and DART agree whether a pulse of 0.5 to 3 z is withstood.

    Every other one comes where least is resisted.
    """
    group, number = divmod(instance, TOGETHER)
    setup, when, disturbers = _disturbed(group)
    rng = np.random.default_rng((instance, 1))
    fraction, direction = float(rng.uniform(WEAKEST, STRONGEST)), rng.normal(size=6)
    if instance % 2 == 0:
        direction = _weakest(setup, when[number])
    direction = direction / np.linalg.norm(direction)
    withstood = [one.trial(when[number], direction, -1, fraction).withstood for one in disturbers]
    note = f"{setup.problem.name}: {fraction:.2f} z at instant {when[number]}"
    return _agreed(withstood[0], withstood[1], ("withstand", "lose"), note)
