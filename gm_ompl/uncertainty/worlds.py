"""Worlds: what the uncertain quantities may really be, and an instant of manipulation in one."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gm_ompl.arrays import Array, IntArray, cross
from gm_ompl.uncertainty.ranges import Three, Uncertainty

if TYPE_CHECKING:
    from gm_ompl.contact.state import Instant

ROUNDED = 12
"""Cases equal to so many decimals are one."""

NEAR = 0.9
"""A normal within this cosine of the object's x axis has its tangents from the y axis instead."""


@dataclass(frozen=True)
class World:
    """How one world differs from the nominal one, in the scenario's units.

    An empty tuple stands for zeros; per finger are those that touch, in an instant, or all of them.

    Attributes:
        environment_friction: added to the Coulomb coefficient of static contacts with the
            environment: one number, or the floor's and then each obstacle's.
        sliding_friction: likewise of sliding contacts. In any one world the two are equal; cases
            (``corners``) take the worst of each.
        finger_friction: (n,), added to that of each finger.
        mass: added to M.
        centre_of_mass: where it is, in the object frame, whose origin is the nominal one.
        position: (n, 2), how far each finger's contact is shifted along the two ``tangents``.
        command: (n,), relative error of each commanded force.
        tilt: gravity points along -(z + a x + b y), the axes of the world.
    """

    environment_friction: tuple[float, ...] = ()
    sliding_friction: tuple[float, ...] = ()
    finger_friction: tuple[float, ...] = ()
    mass: float = 0.0
    centre_of_mass: Three = (0.0, 0.0, 0.0)
    position: tuple[tuple[float, float], ...] = ()
    command: tuple[float, ...] = ()
    tilt: tuple[float, float] = (0.0, 0.0)

    def of(self, fingers: tuple[int, ...]) -> World:
        """Return the same world to the given fingers alone, as where others are lifted."""
        return dataclasses.replace(
            self,
            finger_friction=tuple(self.finger_friction[i] for i in fingers if self.finger_friction),
            position=tuple(self.position[i] for i in fingers if self.position),
            command=tuple(self.command[i] for i in fingers if self.command),
        )

    def commanded(self, f_com: Array, f_max: Array) -> Array:
        """Return what commands (n,) really press with: f_com (1 + e) within [0, f_max]."""
        errors = np.asarray(self.command) if self.command else np.zeros(len(f_com))
        pressed: Array = np.clip(f_com * (1.0 + errors), 0.0, f_max)
        return pressed


NOMINAL = World()


@functools.lru_cache(maxsize=64)
def corners(uncertainty: Uncertainty, fingers: int, mass: float) -> tuple[World, ...]:
    """Return the cases: worlds at the corners of the ranges, whose least z is z_rob.

    Forces that hold in all of them hold in every world of the ranges as far as load, commands and
    static friction go, and a single sliding contact; see docs/background for the others.
    Friction of static contacts and fingers is least in all cases, as z can only fall with it.

    Args:
        uncertainty: the ranges.
        fingers: how many touch.
        mass: M, the nominal one.
    """
    # Between two leaning corners gravity is shorter than at either: a little mass makes up for it.
    stretch = math.sqrt(1.0 + 2.0 * uncertainty.tilt**2)
    heavy = (mass + uncertainty.mass) * stretch - mass
    masses = (-uncertainty.mass, heavy) if heavy else (0.0,)
    low = tuple(-width for width in uncertainty.environment_friction)
    tips = tuple(-width for width in uncertainty.finger_friction)
    sliding = _signed(uncertainty.environment_friction)
    slopes = _signed((uncertainty.tilt, uncertainty.tilt))
    centres = _signed(uncertainty.centre_of_mass)
    command = _signed((uncertainty.command,) * fingers)
    at_fingers = _signed((uncertainty.position,) * (2 * fingers))
    return tuple(
        World(
            low, slide, tips, added, (x, y, z), tuple(zip(at[::2], at[1::2], strict=True)), errors,
            (a, b),
        )
        for slide, added, (x, y, z), at, errors, (a, b) in itertools.product(
            sliding, masses, centres, at_fingers, command, slopes
        )
    )  # fmt: skip


def corner_count(uncertainty: Uncertainty, fingers: int) -> int:
    """Return how many cases ``corners`` returns."""
    surfaces = sum(map(bool, uncertainty.environment_friction))
    load = sum(map(bool, uncertainty.centre_of_mass)) + 2 * bool(uncertainty.tilt)
    load += bool(uncertainty.mass or uncertainty.tilt)
    hand = bool(uncertainty.command) + 2 * bool(uncertainty.position)
    count: int = 2 ** (surfaces + load + hand * fingers)
    return count


def draw(
    uncertainty: Uncertainty, fingers: int, rng: np.random.Generator, scale: float = 1.0
) -> World:
    """Return a world drawn evenly from the ranges times ``scale``."""
    ranges = uncertainty.scaled(scale)

    def within(widths: Sequence[float]) -> tuple[float, ...]:
        return tuple(float(width * rng.uniform(-1.0, 1.0)) for width in widths)

    environment = within(ranges.environment_friction)
    at = within((ranges.position,) * (2 * fingers))
    x, y, z = within(ranges.centre_of_mass)
    a, b = within((ranges.tilt, ranges.tilt))
    return World(
        environment, environment, within(ranges.finger_friction), within((ranges.mass,))[0],
        (x, y, z), tuple(zip(at[::2], at[1::2], strict=True)),
        within((ranges.command,) * fingers), (a, b),
    )  # fmt: skip


def in_world(instant: Instant, world: World) -> Instant:
    """Return the instant in a world; norm (7), reference point and unit of force stay nominal."""
    points, friction = instant.points, instant.friction
    if world.position:
        points = points + shifts(instant.normals, np.asarray(world.position))
    if world.finger_friction:
        friction = np.maximum(friction + np.asarray(world.finger_friction), 0.0)
    return dataclasses.replace(
        instant,
        points=points,
        friction=friction,
        contact_friction=contact_friction(instant, world),
        excess=excess_load(instant, world),
        uncertainty=Uncertainty(),
    )


def cases_of(instant: Instant) -> tuple[tuple[Instant, World], ...]:
    """Return the instant in each of its cases, equal ones once; itself where nothing is uncertain.

    Which case is an instant's own is a question of its contacts: where none slides, that friction
    may be larger is none.
    """
    if not instant.uncertainty:
        return ((instant, NOMINAL),)
    found: dict[bytes, tuple[Instant, World]] = {}
    for world in corners(instant.uncertainty, len(instant.points), instant.mass):
        there = in_world(instant, world)
        arrays = (there.points, there.friction, there.friction_at_contacts, there.excess)
        # Loads that differ by rounding alone are one: a vertical shift of the centre of mass.
        key = b"".join(array.tobytes() for array in _relative(instant, *arrays))
        found.setdefault(key + repr(world.command).encode(), (there, world))
    return tuple(found.values())


def squeezing(instant: Instant) -> tuple[Instant, ...]:
    """Return instants whose columns together are those with which Problem (5) is asked.

    Static contacts and fingers have their highest friction, sliding ones both their lowest and
    their highest, and every finger touches at each corner of its range. All columns of any world
    lie in the cone that these span; what they cannot squeeze no world can, not even one in which
    friction differs from contact to contact.
    """
    ranges = instant.uncertainty
    if not ranges:
        return (instant,)
    n, high = len(instant.points), ranges.environment_friction
    own = [
        World(high, slide, ranges.finger_friction, position=((a, b),) * n)
        for slide in dict.fromkeys((high, tuple(-width for width in high)))
        for a, b in shift_corners(ranges.position)
    ]
    return tuple(in_world(instant, world) for world in own)


def contact_friction(instant: Instant, world: World) -> Array:
    """Return the Coulomb coefficient (m,) of each environment contact in a world."""
    contacts = instant.contacts
    static, sliding = (
        _at_contacts(values, contacts.surfaces)
        for values in (world.environment_friction, world.sliding_friction)
    )
    added = np.where(contacts.slip.any(axis=1), sliding, static)
    least: Array = np.maximum(instant.friction_at_contacts + added, 0.0)
    return least


def excess_load(instant: Instant, world: World) -> Array:
    """Return (6,) what gravity's wrench is more in a world, about the nominal centre of mass."""
    x, y, z = instant.contacts.rotation
    a, b = world.tilt
    down = -(z + a * x + b * y) / math.sqrt(1.0 + a * a + b * b)
    weight = (instant.mass + world.mass) * instant.gravity * down
    moment = cross(np.asarray(world.centre_of_mass), weight)
    nominal = -instant.mass * instant.gravity * z
    excess: Array = instant.excess + np.concatenate([weight - nominal, moment])
    return excess


def shift_corners(position: float) -> list[tuple[float, float]]:
    """Return the corners of the range of one finger's shift along its face's two tangents."""
    return [(a, b) for a, b in _signed((position, position))]


def shifts(normals: Array, along: Array) -> Array:
    """Return shifts (n, 3) of contacts: ``along`` (n, 2) the tangents of faces with ``normals``."""
    x, y, _ = np.eye(3)
    axis = np.where(np.abs(normals[:, :1]) >= NEAR, y, x)
    t1 = axis - (axis * normals).sum(axis=1, keepdims=True) * normals
    t1 = t1 / np.linalg.norm(t1, axis=1, keepdims=True)
    t2 = cross(normals, t1)
    shifted: Array = along[:, :1] * t1 + along[:, 1:] * t2
    return shifted


def _relative(instant: Instant, *arrays: Array) -> Iterator[Array]:
    """Yield the arrays of ``cases_of`` without units and rounded."""
    points, friction, contact_friction, excess = arrays
    size = float(np.linalg.norm(instant.points, axis=1).max(initial=0.0)) or 1.0
    scale = instant.force_scale or 1.0
    arm = math.sqrt(float(np.trace(instant.inertia)) / instant.mass)
    moments = excess / scale / np.array([1.0, 1.0, 1.0, arm, arm, arm])
    for array in (points / size, friction, contact_friction, moments):
        yield np.round(array, ROUNDED) + 0.0


def _at_contacts(values: tuple[float, ...], surfaces: IntArray) -> Array:
    """Return the value (m,) at each contact, of one for all surfaces or one for each."""
    if len(values) > 1:
        return np.asarray(values)[surfaces]
    return np.full(len(surfaces), values[0] if values else 0.0)


def _signed(widths: Sequence[float]) -> list[tuple[float, ...]]:
    """Return the corners of a box of half-widths; one value where a width is zero."""
    ends = [(-width, width) if width else (0.0,) for width in widths]
    return list(itertools.product(*ends))
