"""Counts on what two simulators say of the same executions: MuJoCo's and DART's."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gm_ompl.simulation.disturb import instants
from gm_ompl.simulation.engine import EngineName
from gm_ompl.simulation.execute import Setup, execute, prepare
from gm_ompl.simulation.pulses import Disturber
from tests.executed import NAMES, plan_of
from tests.verify.counting import Result, count

PULSES = 300
WEAKEST, STRONGEST = 0.5, 3.0  # over z
ENGINES: tuple[EngineName, EngineName] = ("mujoco", "dart")


@lru_cache(2)
def _setup(name: str, engine: EngineName) -> Setup:
    return prepare(plan_of(name), engine=engine)


def _agreed(one: bool, other: bool, words: tuple[str, str], note: str) -> Result:
    """Return whether both say the same: yes in the first word, no in the second."""
    outcome = f"both {words[not one]}" if one == other else f"MuJoCo alone {words[not one]}"
    return Result(one == other, None, note, outcome=outcome)


@count(instances=len(NAMES))
def engines(instance: int) -> Result:
    """MuJoCo and DART agree whether a plan holds when executed."""
    reports = [execute(_setup(NAMES[instance], engine)) for engine in ENGINES]
    note = "\n".join([NAMES[instance], *(report.table() for report in reports)])
    return _agreed(reports[0].holds, reports[1].holds, ("hold", "fail"), note)


@count(instances=PULSES)
def engines_under_pulses(instance: int) -> Result:
    """MuJoCo and DART agree whether a pulse of 0.5 to 3 z is withstood."""
    rng = np.random.default_rng(instance)
    name = NAMES[int(rng.integers(len(NAMES)))]
    fraction, direction = float(rng.uniform(WEAKEST, STRONGEST)), rng.normal(size=6)
    direction /= np.linalg.norm(direction)
    (when,) = instants(_setup(name, "mujoco"), 1, rng).tolist()
    withstood = [
        Disturber(_setup(name, engine), [when]).trial(when, direction, -1, fraction).withstood
        for engine in ENGINES
    ]
    note = f"{name}: {fraction:.2f} z at instant {when}"
    return _agreed(withstood[0], withstood[1], ("withstand", "lose"), note)
