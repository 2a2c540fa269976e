"""What a scenario says is not known exactly: ranges, relative or absolute."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Annotated, TypeAlias

from pydantic import BeforeValidator, Discriminator, Field, Tag, WithJsonSchema
from pydantic_core import PydanticCustomError

from gm_ompl.errors import did_you_mean
from gm_ompl.geometry.solids import Body
from gm_ompl.scenario.document import Path
from gm_ompl.scenario.fields import Angle, OneOrMany, Strict
from gm_ompl.uncertainty.ranges import Uncertainty

PERCENT = re.compile(r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*%\s*", re.ASCII)

STEEPEST = math.radians(30.0)
"""The largest tilt: contacts are kept as they are, which nobody believes beyond."""

FLOOR = "floor"
"""What the floor is called beside the obstacles' names."""


def _amount(value: object) -> float | str:
    if isinstance(value, str) and PERCENT.fullmatch(value):
        return value.strip()
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value < math.inf:
        return float(value)
    raise PydanticCustomError(
        "amount", "must be a number >= 0 or a percentage, for example 0.05 or 10 %"
    )


Amount: TypeAlias = Annotated[
    float | str,
    BeforeValidator(_amount),
    WithJsonSchema(
        {"anyOf": [{"type": "number", "minimum": 0},
                   {"type": "string", "pattern": r"^\s*[0-9.]+([eE][-+]?[0-9]+)?\s*%\s*$"}]}
    ),
]  # fmt: skip
OneOrNamed: TypeAlias = Annotated[
    Annotated[Amount, Tag("<one>")] | Annotated[dict[str, Amount], Tag("<many>")],
    Discriminator(lambda value: "<many>" if isinstance(value, dict) else "<one>"),
]
OneOrVector: TypeAlias = Annotated[
    Annotated[Amount, Tag("<one>")]
    | Annotated[tuple[Amount, ...], Field(min_length=3, max_length=3), Tag("<many>")],
    Discriminator(lambda value: "<many>" if isinstance(value, (list, tuple)) else "<one>"),
]


class UncertaintyModel(Strict):
    """Half-widths of ranges; what is left out is known exactly."""

    environment_friction: OneOrNamed | None = Field(
        default=None, description="one for all, or by name: floor and obstacles"
    )
    finger_friction: OneOrMany[Amount] | None = None
    mass: Amount | None = None
    centre_of_mass: OneOrVector | None = Field(
        default=None, description="along the object's axes; percentages are of its sides"
    )
    position: Amount | None = Field(
        default=None, description="of a fingertip on its face; a percentage is of the object's size"
    )
    command: Amount | None = Field(
        default=None, description="of f_com, a percentage of what is commanded"
    )
    tilt: Angle | None = Field(
        default=None, description="of gravity against object and contacts, about x and about y"
    )


def uncertainty_findings(
    given: UncertaintyModel, friction: tuple[float, tuple[float, ...]], mass: float,
    names: tuple[str, ...],
) -> Iterator[tuple[Path, object, str]]:  # fmt: skip
    """Yield the mistakes in ``uncertainty`` that need no shape.

    Args:
        given: the section.
        friction: Coulomb coefficients of the environment and of each finger.
        mass: M.
        names: the floor and the obstacles.
    """
    environment, fingers = friction
    path: Path = ("uncertainty", "environment_friction")
    by_name = given.environment_friction
    for name, amount in by_name.items() if isinstance(by_name, dict) else ():
        if name not in names:
            hint = did_you_mean(name, names)
            yield (*path, name), ..., f"no such surface{hint}; there are: {', '.join(names)}"
        yield from _at_most((*path, name), amount, environment, "friction.environment")
    if not isinstance(by_name, dict):
        yield from _at_most(path, by_name, environment, "friction.environment")
    path = ("uncertainty", "finger_friction")
    tips = given.finger_friction
    if isinstance(tips, tuple) and len(tips) != len(fingers):
        wanted = f"needs one entry per finger: {len(fingers)} (fingers.count)"
        yield path, list(tips), wanted
    elif tips is not None:
        many = isinstance(tips, tuple)
        for i, (amount, mu) in enumerate(zip(_each(tips, len(fingers)), fingers, strict=True)):
            if many or i == 0:
                least = mu if many else min(fingers)
                where = (*path, i) if many else path
                yield from _at_most(where, amount, least, "friction.finger")
    if given.mass is not None and half_width(given.mass, mass) > 0.9 * mass:
        wanted = f"must be at most 90 % of object.mass, {mass:g}: some mass must be left"
        yield ("uncertainty", "mass"), given.mass, wanted
    if given.command is not None and not (
        isinstance(given.command, str) and half_width(given.command, 1.0) <= 0.9
    ):
        wanted = "must be a percentage of what is commanded, from 0 % to 90 %"
        yield ("uncertainty", "command"), given.command, wanted
    if given.tilt is not None and not 0.0 <= given.tilt <= STEEPEST:
        wanted = f"must be from 0 deg to {math.degrees(STEEPEST):g} deg: contacts are kept"
        yield ("uncertainty", "tilt"), f"{math.degrees(given.tilt):g} deg", wanted


def _at_most(
    path: Path, amount: float | str | None, nominal: float, key: str
) -> Iterator[tuple[Path, object, str]]:
    if amount is not None and half_width(amount, nominal) > nominal:
        wanted = f"must be at most {key}, {nominal:g} (100 %): a coefficient is never negative"
        yield path, amount, wanted


def half_width(amount: float | str | None, whole: float) -> float:
    """Return half the width of a range; percentages are of ``whole``."""
    if amount is None:
        return 0.0
    if isinstance(amount, str):
        match = PERCENT.fullmatch(amount)
        assert match is not None, "the model accepts no other text"
        return float(match[1]) / 100.0 * whole
    return amount


def make_uncertainty(
    given: UncertaintyModel, body: Body, friction: tuple[float, tuple[float, ...]], mass: float,
    obstacles: tuple[str, ...],
) -> Uncertainty:  # fmt: skip
    """Return the ranges in numbers.

    Args:
        given: the section, without mistakes.
        body: the object.
        friction: Coulomb coefficients of the environment and of each finger.
        mass: M.
        obstacles: the obstacles' names, in the problem's order.
    """
    environment, fingers = friction
    by_name, tips, centre = given.environment_friction, given.finger_friction, given.centre_of_mass
    if isinstance(by_name, dict):
        surfaces = tuple(half_width(by_name.get(name), environment) for name in (FLOOR, *obstacles))
    else:
        surfaces = () if by_name is None else (half_width(by_name, environment),)
    sides = (body.vertices.max(axis=0) - body.vertices.min(axis=0)).tolist()
    centres = centre if isinstance(centre, tuple) else (centre,) * 3
    x, y, z = (half_width(amount, side) for amount, side in zip(centres, sides, strict=True))
    tip_widths = (
        ()
        if tips is None
        else tuple(
            half_width(amount, mu)
            for amount, mu in zip(_each(tips, len(fingers)), fingers, strict=True)
        )
    )
    return Uncertainty(
        environment_friction=surfaces,
        finger_friction=tip_widths,
        mass=half_width(given.mass, mass),
        centre_of_mass=(x, y, z),
        position=half_width(given.position, body.diagonal),
        command=half_width(given.command, 1.0),
        tilt=math.tan(given.tilt or 0.0),
    )


def _each(value: float | str | tuple[float | str, ...], count: int) -> tuple[float | str, ...]:
    return value if isinstance(value, tuple) else (value,) * count
