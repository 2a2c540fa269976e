"""How much narrower ranges of what is not known exactly would have to be."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.diagnosis.knobs import TO_ZERO, Knob
from gm_ompl.problem import Problem
from gm_ompl.uncertainty.ranges import Uncertainty

PLAIN = ("environment_friction", "finger_friction", "mass", "centre_of_mass", "position")
"""Ranges that a scenario may state as numbers, or lists of them."""


@dataclass(frozen=True, kw_only=True)
class AllRanges(Knob):
    """All ranges together; its value is a factor.

    Attributes:
        problem: whose.
    """

    problem: Problem

    @property
    def name(self) -> str:
        """What its values are said to be of."""
        return "a factor of all ranges"

    def shown(self, values: Array) -> str:
        """Return the ranges as in a scenario."""
        ranges = self.problem.uncertainty.scaled(float(values[0]))
        return f"{{{', '.join(_written(ranges, self.problem))}}}"

    def told(self, values: Array) -> str:
        """Return the factor."""
        return super().shown(values)


def narrower(problem: Problem) -> Iterator[Knob]:
    """Yield the ranges, all together and each alone: what holds in wide ones holds in narrow ones.

    Of those alone, the ones that are written with a unit, or by name, are left out.
    """
    ranges = problem.uncertainty
    alone = list(_alone(problem))
    if ranges and len(list(_written(ranges, problem))) > 1:
        yield AllRanges(
            "uncertainty", np.ones(1), partial(_scaled, problem), False, True, TO_ZERO,
            problem=problem,
        )  # fmt: skip
    yield from alone


def _alone(problem: Problem) -> Iterator[Knob]:
    for key in PLAIN:
        widths = np.atleast_1d(np.asarray(getattr(problem.uncertainty, key), dtype=np.float64))
        if widths.any() and not (key == "environment_friction" and len(widths) > 1):
            yield Knob(
                f"uncertainty.{key}", widths, partial(_with_range, problem, key), False, True,
                TO_ZERO,
            )  # fmt: skip


def _with_range(problem: Problem, key: str, widths: Array) -> Problem:
    values: Any = tuple(widths.tolist())
    value = values if isinstance(getattr(problem.uncertainty, key), tuple) else values[0]
    ranges = dataclasses.replace(problem.uncertainty, **{key: value})
    return dataclasses.replace(problem, uncertainty=ranges)


def _scaled(problem: Problem, factor: Array) -> Problem:
    return dataclasses.replace(problem, uncertainty=problem.uncertainty.scaled(float(factor[0])))


def _written(ranges: Uncertainty, problem: Problem) -> Iterator[str]:
    """Yield the entries of ``uncertainty`` that state these ranges, those of no width left out.

    They are written to nine digits: what is tried and what is named differ by no more.
    """
    surfaces = ("floor", *(obstacle.name for obstacle in problem.environment.obstacles))
    for key in PLAIN:
        value = getattr(ranges, key)
        texts = [f"{width:.9g}" for width in np.atleast_1d(np.asarray(value)).tolist()]
        if not any(float(text) for text in texts):
            continue
        if key == "environment_friction" and len(texts) > 1:
            named = (f"{name}: {text}" for name, text in zip(surfaces, texts, strict=True))
            yield f"{key}: {{{', '.join(named)}}}"
        else:
            alike = len(set(texts)) == 1
            yield f"{key}: {texts[0]}" if alike else f"{key}: [{', '.join(texts)}]"
    if ranges.command > 0.0:
        yield f"command: {100.0 * ranges.command:.9g} %"
    if ranges.tilt > 0.0:
        yield f"tilt: {math.atan(ranges.tilt):.9g} rad"
