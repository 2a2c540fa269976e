"""The uncertain quantities one by one: how far each may go, and the world in which it has."""

from __future__ import annotations

import enum
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from gm_ompl.arrays import Array
from gm_ompl.problem import Problem
from gm_ompl.tolerance.sites import Site
from gm_ompl.uncertainty.worlds import World

STEEPEST: Final = 1.0
"""Tangent of the tilt that is looked at, at most: 45 degrees."""


class Entrance(enum.Enum):
    """How a quantity enters the mechanics; the value says why an interval of it is certain."""

    LOAD = "z is concave in it, so that what holds at two values holds between them"
    TURNS = "the load turns with it: between two values it lies a known way beside their chord"
    NESTED = "friction cones only grow with it: (6) is decided at one end and (5) at the other"
    COLUMNS = "columns change evenly with it: forces between two values leave a known rest"


@dataclass(frozen=True)
class Quantity:
    """One number that may not be known exactly, as what is added to its nominal value.

    Attributes:
        name: what it is, as the scenario's key ``uncertainty`` says.
        part: which of several: a finger, an axis, a surface; "" where there is one.
        low: the least value that is looked at, at most 0.
        high: the greatest, at least 0.
        nominal: what values are set against to say them in per cent; None where a length or an
            angle speaks for itself.
        limits: in words, what the two ends mean.
    """

    name: str
    part: str
    low: float
    high: float
    nominal: float | None
    limits: tuple[str, str]

    @property
    def label(self) -> str:
        """Name and part."""
        return f"{self.name} {self.part}".rstrip()


@dataclass(frozen=True)
class Coordinate(Quantity):
    """A quantity with its place in ``World``.

    Attributes:
        field: the field of ``World``.
        index: place in it; for positions, 2 i + k is tangent k of finger i.
        size: how long the field's tuple is.
    """

    field: str
    index: int
    size: int

    def world(self, x: float) -> World:
        """Return the world in which the quantity is off by ``x``, all others nominal."""
        values = [0.0] * self.size
        values[self.index] = x
        if self.field == "mass":
            return World(mass=x)
        if self.field == "friction":
            return World(environment_friction=tuple(values), sliding_friction=tuple(values))
        if self.field == "position":
            return World(position=tuple(zip(values[::2], values[1::2], strict=True)))
        return World(**{self.field: tuple(values)})  # type: ignore[arg-type]

    def entrance(self, site: Site) -> Entrance:
        """Return how it enters at a site."""
        if self.field == "friction":
            contacts = site.instant.contacts
            here = self.size == 1 or (contacts.surfaces == self.index)
            slides = (contacts.slip.any(axis=1) & here).any()
            return Entrance.COLUMNS if slides else Entrance.NESTED
        return ENTRANCES[self.field]

    def within(self, site: Site, side: int) -> float:
        """Return how far it is looked at on one side, -1 or 1, at a site: to the face's rim."""
        most = self.high if side > 0 else self.low
        if self.field != "position":
            return most
        i, k = divmod(self.index, 2)
        room = float(site.room[site.fingers.index(i), k, 1 if side > 0 else 0])
        return side * min(abs(most), room)

    def concerns(self, site: Site) -> bool:
        """Whether it can make a difference at a site."""
        if self.field in ("finger_friction", "position", "command"):
            finger = self.index // 2 if self.field == "position" else self.index
            if finger not in site.fingers:
                return False
            return self.field != "command" or bool(site.f_com[site.fingers.index(finger)] > 0.0)
        if self.field == "friction" and self.size > 1:
            return bool((site.instant.contacts.surfaces == self.index).any())
        return self.field != "friction" or len(site.instant.contacts.points) > 0


ENTRANCES: Final = {
    "finger_friction": Entrance.NESTED,
    "mass": Entrance.LOAD,
    "centre_of_mass": Entrance.LOAD,
    "position": Entrance.COLUMNS,
    "command": Entrance.LOAD,
    "tilt": Entrance.TURNS,
}

NOTHING, TWICE = "nothing", "twice"
AXES: Final = ("x", "y", "z")


def quantities(problem: Problem) -> tuple[Coordinate, ...]:
    """Return every quantity of a problem."""
    environment = problem.environment
    surfaces = ("the floor", *(obstacle.name for obstacle in environment.obstacles))
    several = len(problem.uncertainty.environment_friction) > 1
    return (
        *frictions(environment.friction, problem.fingers.friction, surfaces if several else ("",)),
        *loads_and_places(problem.mass, problem.fingers.count, problem.body.diagonal),
    )


def frictions(environment: float, fingers: Array, surfaces: Sequence[str]) -> Iterator[Coordinate]:
    """Yield the coefficients of friction: of surfaces with these names, and of fingers (n,)."""
    for k, part in enumerate(surfaces):
        yield _relative("environment_friction", part, environment, ("friction", k, len(surfaces)))
    for i, own in enumerate(fingers.tolist()):
        yield _relative("finger_friction", f"finger {i}", own, ("finger_friction", i, len(fingers)))


def loads_and_places(mass: float, n: int, size: float) -> Iterator[Coordinate]:
    """Yield the other quantities of an object of this size D and a hand of n fingers."""
    yield _relative("mass", "", mass, ("mass", 0, 1))
    half, rim = ("half of D", "half of D"), ("the face's rim", "the face's rim")
    for k, axis in enumerate(AXES):
        place = ("centre_of_mass", k, 3)
        yield Coordinate("centre_of_mass", axis, -size / 2.0, size / 2.0, None, half, *place)
    for i, k in itertools.product(range(n), range(2)):
        name = f"finger {i}, tangent {k + 1}"
        yield Coordinate("position", name, -size, size, None, rim, "position", 2 * i + k, 2 * n)
    for i in range(n):
        yield _relative("command", f"finger {i}", 1.0, ("command", i, n))
    for k, axis in enumerate(AXES[:2]):
        steep = ("45 deg", "45 deg")
        yield Coordinate("tilt", axis, -STEEPEST, STEEPEST, None, steep, "tilt", k, 2)


def _relative(name: str, part: str, nominal: float, place: tuple[str, int, int]) -> Coordinate:
    """Return a quantity that is looked at from none of it to twice as much."""
    return Coordinate(name, part, -nominal, nominal, nominal, (NOTHING, TWICE), *place)


def shown(quantity: Quantity, x: float) -> str:
    """Return a value in words: per cent, degrees, or the scenario's unit of length."""
    if quantity.name == "tilt":
        return f"{math.degrees(math.atan(x)):+.3g} deg"
    if quantity.nominal is None:
        return f"{x:+.3g}"
    return f"{100.0 * x / quantity.nominal:+.3g}%" if quantity.nominal else f"{x:+.3g}"
