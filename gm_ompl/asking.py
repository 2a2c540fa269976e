"""What the public functions are asked with: scenarios, limits, coordinates, placements."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, SupportsFloat, SupportsIndex, TypeAlias

from numpy.typing import NDArray

from gm_ompl.arguments import finite, kind_of, plain, positive, whole
from gm_ompl.errors import InputError
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.surface import PlacementTable
from gm_ompl.planners.planner import Budget
from gm_ompl.planners.prepare import prepare
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load as load_scenario
from gm_ompl.scenario.overrides import Changes
from gm_ompl.scenario.scenario import Scenario

OUTSIDE = 1e-9
"""Coordinates beyond a motion's range by less than this part of it are on its end."""

Coordinates: TypeAlias = Sequence[float] | NDArray[Any]
"""Object coordinates, or their rates: a list or an array."""

ScenarioLike: TypeAlias = Scenario | str | os.PathLike[str] | Mapping[str, Any]
"""A loaded scenario, a shipped name, a file, or a mapping with a file's keys."""


PlacementLike: TypeAlias = SupportsIndex | tuple[str, Sequence[int] | NDArray[Any]]
"""A row of the placement table, or (face, cell), for example ``("-x", (3, 2))``."""

PlacementsLike: TypeAlias = Sequence[PlacementLike] | NDArray[Any]
"""One placement per finger."""


def seconds(value: object) -> float:
    """Return a time limit that may be 0.

    Raises:
        InputError: it is no number of seconds.
    """
    if plain(value) == 0 and not isinstance(value, bool):
        return 0.0
    return positive("time limit", value, "seconds, or 0")


def budget(
    time_limit: SupportsFloat | None,
    max_iterations: SupportsIndex | None,
    memory_limit: SupportsFloat | None,
) -> Budget:
    """Return a search's limits.

    Raises:
        InputError: one is no positive number.
    """
    return Budget(
        None if time_limit is None else positive("time limit", time_limit, "seconds"),
        None if max_iterations is None else whole("max iterations", max_iterations, 1),
        None if memory_limit is None else positive("memory limit", memory_limit, "MiB"),
    )


def coordinates(name: str, values: object, problem: Problem) -> tuple[float, ...]:
    """Return object coordinates, once it is known that the motion has them.

    Raises:
        InputError: they are too few or too many, no finite numbers, or outside the motion.
    """
    motion = problem.motion
    if not motion.names:
        raise InputError(
            f"{name}: {plain(values)}: with free motion the object has no coordinates; judge a "
            "pose: gm_ompl.judge(scenario, pose=..., twist=..., placements=...)"
        )
    q = finite(name, values, motion.names)
    bounds = zip(motion.names, q, motion.low, motion.high, motion.periods, strict=True)
    for coordinate, value, low, high, period in bounds:
        slack = OUTSIDE * (high - low)
        if period is None and not low - slack <= value <= high + slack:
            text = f"{name}: {list(q)}: {coordinate} = {value:g} is outside the scenario's motion"
            raise InputError(f"{text}; must be from {low:g} to {high:g}")
    return q


def placed(problem: Problem, placements: PlacementsLike) -> tuple[int, ...]:
    """Return the placements' rows in the table."""
    table, count = problem.fingers.placements, problem.fingers.count
    given = plain(placements)
    if not isinstance(given, list):
        wanted = "must be a list, per finger a row or (face, (i, j))"
        raise InputError(f"placements: {kind_of(placements)}: {wanted}")
    if len(given) != count:
        raise InputError(f"placements: {len(given)} given; the scenario has {count} fingers")
    found = []
    for finger, place in enumerate(given):
        row = _row(table, place)
        if row is None or not 0 <= row < len(table):
            raise InputError(
                f"placements[{finger}]: {place}: no such placement; there are {len(table)}, "
                f"on the faces {', '.join(table.labels)}; give a row or (face, (i, j))"
            )
        found.append(row)
    return tuple(found)


def _row(table: PlacementTable, place: object) -> int | None:
    """Return a placement's row in the table; None where there is none, or ``place`` is none."""
    if isinstance(place, int) and not isinstance(place, bool):
        return place
    if not (isinstance(place, list) and len(place) == 2):
        return None
    face, cell = place
    if not (isinstance(cell, list) and len(cell) == 2 and all(isinstance(k, int) for k in cell)):
        return None
    return table.find(str(face), cell)


def load(
    name_or_path: str | os.PathLike[str] | Mapping[str, Any], overrides: Changes = ()
) -> Scenario:
    """Return the scenario of a shipped name ("paper/slide"), a random family's, or a file.

    Args:
        name_or_path: the name, or the file; or a mapping with a file's keys, whose numbers and
            arrays may be numpy's.
        overrides: what replaces values: "KEY=VALUE", where KEY is a dotted path, list items by
            number, and VALUE is read as YAML; a list of such; or values by their keys:
            ``{"fingers.max_normal_force": 5}``.

    Raises:
        ScenarioError: no such scenario, or one line per mistake in it.
    """
    return load_scenario(name_or_path, overrides)


def loaded(scenario: ScenarioLike) -> Scenario:
    """Return the scenario itself, whatever way it is given in."""
    return scenario if isinstance(scenario, Scenario) else load(scenario)


def warned(scenario: Scenario) -> Scenario:
    """Return the scenario after a warning for everything in it that looks like a mistake."""
    for warning in scenario.warnings:
        warnings.warn(warning, stacklevel=3)
    return scenario


def judge_of(problem: Problem) -> Judge:
    """Return a judge of a problem, whose kernel is compiled."""
    prepare(problem)
    return Judge(problem, make_backend(problem))
