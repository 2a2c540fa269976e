"""Counts on executions: what z promises against disturbances."""

from __future__ import annotations

from functools import lru_cache

from gm_ompl.simulation.disturb import disturb, probe
from gm_ompl.simulation.execute import Setup, prepare
from tests.executed import NAMES, plan_of
from tests.verify.counting import Result, count

PULSES = 20


@lru_cache(2)
def _setup(name: str) -> Setup:
    return prepare(plan_of(name))


@count(instances=len(NAMES))
def probes(instance: int) -> Result:
    """Of 20 pulses of 0.8 z l_i in the weakest directions, all are withstood (worst: lost)."""
    name = NAMES[instance]
    report = probe(_setup(name), PULSES)
    return Result(not report.lost, len(report.lost), f"{name}: {report.table()}")


@count(instances=len(NAMES))
def disturbances(instance: int) -> Result:
    """Of 20 pulses of 0.8 z at random times of a plan, at least 19 are withstood (worst: lost)."""
    name = NAMES[instance]
    report = disturb(_setup(name), 0.8, PULSES, instance)
    lost = len(report.lost)
    return Result(lost <= 1, lost, f"{name}: {report.table()}", outcome=f"{lost} lost")
