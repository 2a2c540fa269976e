"""Whether a plan's steps can be those of its scenario: asked before a plan is shown or played.

A plan file may claim anything in the right form. ``gm_ompl.check`` judges what it claims; whoever
shows or plays a plan needs less, that numbers and lists fit the scenario, and asks here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from gm_ompl.errors import MisfitError, PlanError
from gm_ompl.planfile.files import KIND, Mistake, Place, located
from gm_ompl.planfile.model import Plan
from gm_ompl.planfile.points import with_points
from gm_ompl.problem import Problem
from gm_ompl.reading import read_text
from gm_ompl.scenario.scenario import Scenario

LARGEST = 1e30  # products of a few such numbers are still finite
UNIT = 1e-3  # by how much the length of a unit vector may be off: what is drawn looks right
OUTSIDE = 1e-6  # how far a coordinate may lie outside, over its range
TURNS = 1e4  # so many periods a coordinate that wraps may be unwrapped


def problem_of(plan: Plan) -> Problem:
    """Return the problem inside ``plan``, to show or play the plan's steps with.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
        MisfitError: the steps cannot be those of the scenario.
    """
    scenario = Scenario.from_resolved(plan.scenario, "scenario in the plan")
    problem = with_points(scenario.problem, plan)
    found = list(mistakes(plan, problem))
    if found:
        raise MisfitError(found)
    return problem


def in_file(error: MisfitError, path: Path) -> PlanError:
    """Return ``error`` with the lines of the file that the plan came from."""
    advice = f"`gm-ompl check {path}` judges the plan step by step"
    return located(path, read_text(path, KIND), error.mistakes, advice)


UNIT_VECTORS = ("quaternion", "axis", "normal")
PER_FINGER = ("placements", "modes", "f_com")
"""Keys of a step, at any depth, whose values are of length 1; that have an entry per finger."""


def mistakes(plan: Plan, problem: Problem) -> Iterator[Mistake]:
    """Yield where steps do not fit the scenario, or hold numbers that nothing can be done with."""
    document, count = plan.to_dict(), problem.fingers.count
    for number, step in enumerate(document["steps"]):
        place: Place = ("steps", number)
        regrasp = step["kind"] == "regrasp"
        for key in ("at",) if regrasp else ("from", "to"):
            yield from _coordinates((*place, key), step[key] or [], problem)
        if regrasp and step["finger"] >= count:
            fingers = f"0 to {count - 1}"
            yield (*place, "finger"), f"{step['finger']}: the scenario's fingers are {fingers}"
        if not regrasp and not step["segments"]:
            yield (*place, "segments"), "[]: a displacement has at least one segment"
        yield from _anywhere(place, step, count)
    for key in ("cost", "lower_bound"):
        yield from _anywhere((key,), document[key], count)
    yield from _anywhere(("statistics", "history"), document["statistics"]["history"], count)


def _coordinates(place: Place, q: Sequence[float], problem: Problem) -> Iterator[Mistake]:
    motion = problem.motion
    if len(q) != motion.dimension:
        names = ", ".join(motion.names)
        right = f"{motion.dimension} numbers ({names})" if names else "null with free motion"
        yield place, f"{list(q) or 'null'}: must be {right}"
        return
    for k, (value, low, high, period) in enumerate(
        zip(q, motion.low, motion.high, motion.periods, strict=True)
    ):
        margin = OUTSIDE * (high - low) if period is None else TURNS * period
        if not low - margin <= value <= high + margin:
            yield (*place, k), f"{value:g}: the scenario's {motion.names[k]} is {low:g} to {high:g}"


def _anywhere(place: Place, value: Any, count: int) -> Iterator[Mistake]:
    """Yield what is wrong with a value by its key, at any depth, and with numbers."""
    if place[-1] in UNIT_VECTORS and not abs(math.hypot(*value) - 1.0) <= UNIT:
        yield place, f"{value}: must have length 1, has {math.hypot(*value):g}"
    if place[-1] in PER_FINGER and len(value) != count:
        yield place, f"{len(value)} given; the scenario in the plan has {count} fingers"
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _anywhere((*place, key), item, count)
    elif isinstance(value, int | float) and abs(value) > LARGEST:
        yield place, f"{value:g}: must be from {-LARGEST:g} to {LARGEST:g}"
