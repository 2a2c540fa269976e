"""What a plan tolerates, found site by site."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Final

import numpy as np

from gm_ompl import limits
from gm_ompl.errors import InputError
from gm_ompl.planfile.model import Plan
from gm_ompl.problem import Problem
from gm_ompl.tolerance.forces import Held, held
from gm_ompl.tolerance.quantities import Coordinate, quantities, shown
from gm_ompl.tolerance.reach import Deviations, Trail, reach
from gm_ompl.tolerance.report import (
    End,
    Factor,
    Interval,
    IntervalEnd,
    StepTolerance,
    Tolerance,
)
from gm_ompl.tolerance.scaling import Boxes, widest
from gm_ompl.tolerance.sites import Site, sites
from gm_ompl.tolerance.squeezing import squeeze
from gm_ompl.uncertainty.ranges import Uncertainty
from gm_ompl.uncertainty.worlds import NOMINAL

CLOSE: Final = 0.01
"""How near to each other, relatively, what holds and what does not are found."""

LOW, HIGH = -1, 1


USUAL: Final = {"environment_friction": 0.1, "finger_friction": 0.1, "mass": 0.05, "centre": 0.05}
"""Ranges where a scenario states none: of friction and mass, relative; of the centre of mass, over
the object's sides."""


def measured(plan: Plan, problem: Problem) -> Tolerance:
    """Return what a plan for ``problem`` tolerates.

    Raises:
        InputError: the plan has no step.
        SolverError: the solver returned no answer.
    """
    stated = bool(problem.uncertainty)
    ranges = problem.uncertainty or usual(problem)
    steps = Measure(problem, ranges).steps(plan)
    whole = narrowest(steps)
    return Tolerance(
        problem.name, problem.mechanics.z_min, in_words(ranges, problem), stated, steps, whole,
        least(steps),
    )  # fmt: skip


def common_factor(plan: Plan, problem: Problem) -> float:
    """Return by how much all ranges may be widened together; 0 where a plan does not even hold.

    Raises:
        InputError: the plan has no step.
        SolverError: the solver returned no answer.
    """
    ranges = problem.uncertainty or usual(problem)
    found = least(Measure(problem, ranges, alone=False).steps(plan))
    assert found is not None, "there are ranges"
    return found.x


def usual(problem: Problem) -> Uncertainty:
    """Return the ranges that are widened where a scenario states none."""
    size = np.ptp(problem.body.vertices, axis=0)
    x, y, z = (USUAL["centre"] * size).tolist()
    return Uncertainty(
        environment_friction=(USUAL["environment_friction"] * problem.environment.friction,),
        finger_friction=tuple((USUAL["finger_friction"] * problem.fingers.friction).tolist()),
        mass=USUAL["mass"] * problem.mass,
        centre_of_mass=(x, y, z),
    )


def in_words(ranges: Uncertainty, problem: Problem) -> tuple[str, ...]:
    """Return the ranges in words, one per quantity that is uncertain."""
    widths = {
        "environment_friction": ranges.environment_friction,
        "finger_friction": ranges.finger_friction,
        "mass": (ranges.mass,),
        "centre_of_mass": ranges.centre_of_mass,
        "position": (ranges.position,),
        "command": (ranges.command,),
        "tilt": (ranges.tilt,),
    }
    known = {quantity.name: quantity for quantity in reversed(quantities(problem))}
    return tuple(
        f"{name} +-{', '.join(shown(known[name], x).lstrip('+') for x in dict.fromkeys(values))}"
        for name, values in widths.items()
        if any(values)
    )


class Measure:
    """Finds what the steps of a plan tolerate.

    Args:
        problem: the plan's.
        ranges: what is widened together.
        alone: whether intervals of single quantities are wanted, too.
    """

    def __init__(self, problem: Problem, ranges: Uncertainty, *, alone: bool = True) -> None:
        self._problem, self._ranges = problem, ranges
        self._quantities = quantities(problem) if alone else ()
        self._most = widest(problem, ranges)
        self._trail: Trail = {}
        self._cases: dict[int, Held] = {}
        self._nominal: Held | None = None
        self._known: dict[object, End] = {}

    def steps(self, plan: Plan) -> tuple[StepTolerance, ...]:
        """Return what each step tolerates.

        Raises:
            InputError: the plan has no step.
            SolverError: the solver returned no answer.
        """
        if not plan.steps:
            raise InputError(f"the plan has no steps (status {plan.status!r}): nothing to hold")
        everything = groupby(sites(plan, self._problem), key=lambda site: site.step)
        return tuple(self._step(number, list(group)) for number, group in everything)

    def _step(self, number: int, group: Sequence[Site]) -> StepTolerance:
        nominal = [(self._solved(site), site) for site in group]
        nominal.sort(key=lambda pair: pair[0].slack)
        holds = all(
            here.slack >= 0.0 and not squeeze(site, here.model, here.columns).excessive
            for here, site in nominal
        )
        ends = {
            (quantity.label, side): End(quantity.high if side == HIGH else quantity.low)
            if holds else End(0.0, IntervalEnd.FAILS, number)
            for quantity in self._quantities for side in (LOW, HIGH)
        }  # fmt: skip
        together = Factor(self._most if holds else 0.0) if self._ranges else None
        for here, site in nominal if holds else ():
            for quantity in self._quantities:
                limits.check()
                if quantity.concerns(site):
                    self._narrow(here, site, quantity, ends)
            if together is not None:
                together = self._together(here, site, together)
        intervals = tuple(
            Interval(quantity, ends[quantity.label, LOW], ends[quantity.label, HIGH])
            for quantity in self._quantities
        )
        return StepTolerance(number, holds, intervals, together)

    def _solved(self, site: Site) -> Held:
        """Return the nominal world at a site."""
        self._nominal = held(site, NOMINAL, self._nominal, exactly=True, even=True)
        return self._nominal

    def _narrow(
        self, here: Held, site: Site, quantity: Coordinate, ends: dict[tuple[str, int], End]
    ) -> None:
        """Bring in both ends of an interval to what one more site tolerates."""
        line: Deviations | None = None
        for side in (LOW, HIGH):
            key, wanted = (quantity.label, side), ends[quantity.label, side]
            most = quantity.within(site, side)
            if abs(most) < abs(wanted.x):
                wanted = ends[key] = End(most)
            found = self._known.get((site.key, key))
            if found is None or (
                found.ending is IntervalEnd.LIMIT and abs(found.x) < abs(wanted.x)
            ):
                line = line or Deviations(site, quantity, here, self._trail)
                found = self._known[site.key, key] = _end(line, wanted.x, site.step)
            if abs(found.x) < abs(wanted.x):
                ends[key] = End(found.x, found.ending, site.step)

    def _together(self, here: Held, site: Site, factor: Factor) -> Factor:
        """Return a factor brought down to what one more site tolerates."""
        holds, fails = reach(Boxes(site, self._ranges, here, self._cases), factor.x, CLOSE)
        if holds.x == factor.x:
            return factor
        world = None if fails is None else fails.world
        ending = IntervalEnd.PROOF if world is None else IntervalEnd.FAILS
        return Factor(holds.x, ending, site.step, world)


def _end(line: Deviations, most: float, step: int) -> End:
    """Return how far a quantity may go at a site."""
    if most == 0.0:
        return End(0.0)
    holds, fails = reach(line, most, CLOSE)
    if holds.x == most:
        return End(most)
    return End(holds.x, IntervalEnd.PROOF if fails is None else IntervalEnd.FAILS, step)


def narrowest(steps: Iterable[StepTolerance]) -> tuple[Interval, ...]:
    """Return the intervals in which all steps hold."""
    columns = zip(*(step.intervals for step in steps), strict=True)
    return tuple(
        Interval(
            column[0].quantity,
            max((interval.low for interval in column), key=lambda end: end.x),
            min((interval.high for interval in column), key=lambda end: end.x),
        )
        for column in columns
    )


def least(steps: Iterable[StepTolerance]) -> Factor | None:
    """Return the factor at which all steps hold; None without ranges."""
    factors = [step.together for step in steps if step.together is not None]
    return min(factors, key=lambda factor: factor.x, default=None)
