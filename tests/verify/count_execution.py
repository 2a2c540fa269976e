"""Counts on executions: what z promises against disturbances, on all of the paper's plans."""

from __future__ import annotations

from functools import cache

import gm_ompl
from gm_ompl.simulation.disturb import disturb
from gm_ompl.simulation.execute import Setup, execute, prepare
from tests.verify.counting import Result, count

PLANS = (
    ("paper/slide", ()),
    ("paper/push", ()),
    ("paper/tumble", ()),
    ("paper/regrasp", ()),
    ("paper/cork", ()),
    ("paper/cork", ("friction.finger=1.2", "friction.environment=0.15")),
    ("paper/cork", ("fingers.max_normal_force=2.4",)),
    ("paper/cork", ("fingers.max_normal_force=3.6",)),
)
"""The paper's problems; the experiment also with friction the other way round, f_max off by 20%."""

PULSES = 19


@cache
def _setup(number: int) -> Setup:
    name, overrides = PLANS[number]
    return prepare(gm_ompl.plan(gm_ompl.load(name, overrides)))


@count(instances=len(PLANS))
def executions(instance: int) -> Result:
    """The paper's plans hold when executed in simulation (worst: position error at the end, D)."""
    report = execute(_setup(instance))
    note = f"{PLANS[instance]}: {'; '.join(report.findings)}"
    return Result(report.holds, report.end_position / report.size, note)


@count(instances=8 * len(PLANS))
def disturbances(instance: int) -> Result:
    """Of 19 pulses of 0.8 z at random times of a plan, at least 18 are withstood (worst: lost)."""
    setup = _setup(instance % len(PLANS))
    report = disturb(setup, 0.8, PULSES, seed=instance)
    lost = sum(not trial.withstood for trial in report.trials)
    return Result(lost <= 1, lost, f"{PLANS[instance % len(PLANS)]}: {report.table()}")
