"""Counts on executions: what z promises against disturbances, on all shipped plans."""

from __future__ import annotations

from functools import lru_cache

import gm_ompl
from gm_ompl.simulation.disturb import disturb, probe
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
    ("shapes/hexagon", ()),
    ("shapes/l-bracket", ()),
    ("hand/three-fingers", ()),
    ("planar/turn", ()),
    ("planar/corridor", ()),
    ("planar/corner", ()),
)
"""The shipped problems; the experiment also with friction the other way round, f_max off by 20%."""

PULSES = 20
ROUNDS = 8


@lru_cache(2)
def _setup(number: int) -> Setup:
    name, overrides = PLANS[number]
    return prepare(gm_ompl.plan(gm_ompl.load(name, overrides)))


@count(instances=len(PLANS))
def executions(instance: int) -> Result:
    """The shipped plans hold when executed in simulation (worst: position error at the end, D)."""
    report = execute(_setup(instance))
    note = f"{PLANS[instance]}: {'; '.join(report.findings)}"
    return Result(report.holds, report.end_position / report.size, note)


@count(instances=len(PLANS))
def probes(instance: int) -> Result:
    """Of 20 pulses of 0.8 z l_i in the weakest directions, all are withstood (worst: lost)."""
    report = probe(_setup(instance), PULSES)
    return Result(not report.lost, len(report.lost), f"{PLANS[instance]}: {report.table()}")


@count(instances=ROUNDS * len(PLANS))
def disturbances(instance: int) -> Result:
    """Of 20 pulses of 0.8 z at random times of a plan, at least 19 are withstood (worst: lost)."""
    plan, seed = divmod(instance, ROUNDS)  # a plan's rounds follow each other: it is planned once
    report = disturb(_setup(plan), 0.8, PULSES, seed)
    lost = sum(not trial.withstood for trial in report.trials)
    return Result(lost <= 1, lost, f"{PLANS[plan]}: {report.table()}")
