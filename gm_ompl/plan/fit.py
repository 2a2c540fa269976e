"""Whether a plan's steps can be those of its scenario: asked before a plan is shown or played.

A plan file may claim anything in the right form. ``gm_ompl.check`` judges what it claims; whoever
shows or plays a plan needs less, that numbers and lists fit the scenario, and asks here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from gm_ompl.errors import MisfitError, PlanError
from gm_ompl.plan.arc_model import RotationArc
from gm_ompl.plan.files import KIND, MAX_SHOWN
from gm_ompl.plan.model import DisplacementStep, Plan, RegraspStep
from gm_ompl.plan.places import where
from gm_ompl.plan.record import PoseRecord
from gm_ompl.problem import Problem
from gm_ompl.reading import one_line, read_text
from gm_ompl.scenario.scenario import Scenario

LARGEST = 1e30
"""Products of a few such numbers are still finite."""

UNIT = 1e-3
"""By how much the length of a unit vector may be off: what is drawn looks right."""

OUTSIDE = 1e-6
"""How far a coordinate may lie outside, over its range."""

TURNS = 1e4
"""So many periods a coordinate that wraps may be unwrapped."""

Place: TypeAlias = tuple[int | str, ...]
Mistake: TypeAlias = tuple[Place, str]


def problem_of(plan: Plan) -> Problem:
    """Return the problem inside ``plan``, to show or play the plan's steps with.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
        MisfitError: the steps cannot be those of the scenario.
    """
    problem = Scenario.from_resolved(plan.scenario, "scenario in the plan").problem
    found = list(mistakes(plan, problem))
    if found:
        raise MisfitError(found)
    return problem


def in_file(error: MisfitError, path: Path) -> PlanError:
    """Return ``error`` with the lines of the file that the plan came from."""
    text = read_text(path, KIND)
    lines = [f"{where(path, text, place)}: {wrong}" for place, wrong in error.mistakes[:MAX_SHOWN]]
    if len(error.mistakes) > MAX_SHOWN:
        lines.append(f"{path}: and {len(error.mistakes) - MAX_SHOWN} more mistakes")
    lines.append(f"`gm-ompl check {path}` judges the plan step by step")
    return PlanError("\n".join(map(one_line, lines)))


def mistakes(plan: Plan, problem: Problem) -> Iterator[Mistake]:
    """Yield where steps do not fit the scenario, or hold numbers that nothing can be done with."""
    for number, step in enumerate(plan.steps):
        place: Place = ("steps", number)
        yield from (
            _regrasp(place, step, problem)
            if isinstance(step, RegraspStep)
            else (_displacement(place, step, problem))
        )
    document = plan.to_dict()
    for key in ("steps", "cost", "lower_bound"):
        yield from _large((key,), document[key])
    yield from _large(("statistics", "history"), document["statistics"]["history"])


def _displacement(place: Place, step: DisplacementStep, problem: Problem) -> Iterator[Mistake]:
    yield from _coordinates((*place, "from"), step.from_, problem)
    yield from _coordinates((*place, "to"), step.to, problem)
    yield from _pose((*place, "pose_from"), step.pose_from)
    yield from _pose((*place, "pose_to"), step.pose_to)
    if isinstance(step.arc, RotationArc):
        yield from _unit((*place, "arc", "rotation", "axis"), step.arc.rotation.axis)
    yield from _per_finger(place, step, ("placements",), problem)
    for i, placement in enumerate(step.placements):
        yield from _unit((*place, "placements", i, "normal"), placement.normal)
    if not step.segments:
        yield (*place, "segments"), "[]: a displacement has at least one segment"
    for j, segment in enumerate(step.segments):
        yield from _per_finger((*place, "segments", j), segment, ("modes", "f_com"), problem)


def _regrasp(place: Place, step: RegraspStep, problem: Problem) -> Iterator[Mistake]:
    yield from _coordinates((*place, "at"), step.at, problem)
    yield from _per_finger(place, step, ("placements", "modes", "f_com"), problem)
    if step.finger >= problem.fingers.count:
        last = problem.fingers.count - 1
        yield (*place, "finger"), f"{step.finger}: the scenario's fingers are 0 to {last}"
    yield from _unit((*place, "from", "normal"), step.from_.normal)
    yield from _unit((*place, "to", "normal"), step.to.normal)
    for i, placement in enumerate(step.placements):
        yield from _unit((*place, "placements", i, "normal"), placement.normal)


def _coordinates(place: Place, q: Sequence[float], problem: Problem) -> Iterator[Mistake]:
    motion = problem.motion
    if len(q) != motion.dimension:
        names = ", ".join(motion.names)
        yield place, f"{list(q)}: must be {motion.dimension} numbers ({names})"
        return
    for k, (value, low, high, period) in enumerate(
        zip(q, motion.low, motion.high, motion.periods, strict=True)
    ):
        margin = OUTSIDE * (high - low) if period is None else TURNS * period
        if not low - margin <= value <= high + margin:
            yield (*place, k), f"{value:g}: the scenario's {motion.names[k]} is {low:g} to {high:g}"


def _per_finger(
    place: Place, part: Any, names: Sequence[str], problem: Problem
) -> Iterator[Mistake]:
    count = problem.fingers.count
    for name in names:
        have = len(getattr(part, name))
        if have != count:
            yield (*place, name), f"{have} given; the scenario in the plan has {count} fingers"


def _pose(place: Place, pose: PoseRecord) -> Iterator[Mistake]:
    yield from _unit((*place, "quaternion"), pose.quaternion)


def _unit(place: Place, vector: Sequence[float]) -> Iterator[Mistake]:
    length = math.hypot(*vector)
    if not abs(length - 1.0) <= UNIT:
        yield place, f"{list(vector)}: must have length 1, has {length:g}"


def _large(place: Place, value: Any) -> Iterator[Mistake]:
    if isinstance(value, (dict, list)):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _large((*place, key), item)
    elif isinstance(value, (int, float)) and abs(value) > LARGEST:
        yield place, f"{value:g}: must be from {-LARGEST:g} to {LARGEST:g}"
