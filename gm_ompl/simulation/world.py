"""The simulated bodies in SI units: every object becomes as large as the cork box.

A quasi-static problem has two scales of its own, the object's size and its weight; lengths and
forces only count against them. A simulator has absolute ones: contact stiffness, time steps,
solver tolerances. So every scenario is simulated at the size, mass and gravity of the paper's
experiment (Sec. 5.3), which itself is left as it is, whatever its units.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError
from gm_ompl.hand.spec import HandSpec
from gm_ompl.problem import Problem

SIZE = 0.0172**0.5  # D of the cork box, 60 x 60 x 100 mm [m]
MASS = 0.092  # M of the cork box [kg]
GRAVITY = 9.8  # the paper's [m/s^2]


@dataclass(frozen=True)
class Units:
    """Factors that take a scenario's numbers to SI numbers in the simulator."""

    length: float  # metres per unit of length
    mass: float  # kilograms per unit of mass
    force: float  # newtons per unit of force
    gravity: float  # g in the simulator [m/s^2]; 0 where the scenario has none

    @classmethod
    def of(cls, problem: Problem) -> Units:
        """Return the units in which ``problem`` is simulated.

        Without gravity the unit of force is such that the largest f_max is the cork box's weight.

        Raises:
            InputError: no gravity, and no finger may press: nothing can be simulated.
        """
        unit = force_unit(problem)
        if problem.hand is not None:  # a robot has its size, mass and motors
            return cls(1.0, 1.0, 1.0, problem.mechanics.gravity)
        if unit <= 0:
            raise InputError("without gravity some finger must have a max_normal_force above 0")
        gravity = GRAVITY if problem.mechanics.gravity > 0 else 0.0
        length, mass = SIZE / problem.body.diagonal, MASS / problem.mass
        return cls(length, mass, MASS * GRAVITY / unit, gravity)


def force_unit(problem: Problem) -> float:
    """Return the object's weight, or the largest f_max where there is no gravity."""
    weight = problem.mass * problem.mechanics.gravity
    return weight or float(problem.fingers.max_normal_force.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies and friction, SI units."""

    pieces: tuple[Array, ...]  # per convex piece of the object its vertices (v, 3), object frame
    mass: float  # the object's
    inertia: Array  # (3, 3), about the centre of mass, object frame
    obstacles: tuple[Array, ...]  # per convex piece its vertices (v, 3), world frame
    floor: bool  # whether the half space z < 0 is solid
    radius: Array  # (n,), of the fingertips
    friction: Array  # (n,), Coulomb coefficient of each fingertip against the object
    environment_friction: float  # Coulomb coefficient of floor and obstacles against the object
    gravity: float  # g, along -z
    offset: Array  # (n, 3), error of each fingertip's place, object frame
    # (n,), L of soft fingertips: they hold the object by up to friction times L times normal force
    # against turning about the normal
    soft: Array
    # (3,), where the centre of mass really is, object frame, whose origin is the nominal one
    centre: Array = field(default_factory=lambda: np.zeros(3))
    # how much higher than planned the object starts, so that an object of another size does not
    # start inside the floor
    lift: float = 0.0
    hand: HandSpec | None = None  # the robot hand that the fingertips belong to

    @property
    def size(self) -> float:
        """D, the diagonal of the object's bounding box."""
        corners = np.concatenate(self.pieces)
        return float(np.linalg.norm(corners.max(axis=0) - corners.min(axis=0)))


def box_of(vertices: Array) -> tuple[Array, Array] | None:
    """Return the two outermost corners of a convex piece that is a box along the axes, or None."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    off = np.minimum(np.abs(vertices - low), np.abs(vertices - high)).max()
    if len(vertices) == 8 and off <= 1e-12 * (high - low).max():
        return low, high
    return None


def world(problem: Problem, units: Units) -> Bodies:
    """Return the scenario's bodies in SI units."""
    fingers, environment = problem.fingers, problem.environment
    return Bodies(
        pieces=tuple(units.length * piece.vertices for piece in problem.body.pieces),
        mass=units.mass * problem.mass,
        inertia=units.mass * units.length**2 * problem.inertia,
        obstacles=tuple(
            units.length * piece.vertices
            for obstacle in environment.obstacles
            for piece in obstacle.body.pieces
        ),
        floor=environment.floor,
        radius=units.length * fingers.radius,
        friction=np.array(fingers.friction),
        environment_friction=environment.friction,
        gravity=units.gravity,
        offset=np.zeros((fingers.count, 3)),
        soft=units.length * fingers.soft,
        hand=problem.hand,
    )


KINDS = ("friction", "mass", "size", "place")  # what a model may be wrong in


def varied(
    nominal: Bodies,
    share: float,
    normals: Array,
    rng: np.random.Generator,
    kinds: Collection[str] = KINDS,
) -> Bodies:
    """Return a world that differs from the model by up to ``share`` in what is hard to know.

    Each coefficient of friction, the mass and each side of the object are off by a factor drawn
    evenly from 1 - share to 1 + share; the place of each fingertip by up to ``share`` of the
    object's size D, in its surface. The numbers drawn do not depend on ``kinds``.

    Args:
        nominal: the world as modelled.
        share: 0.03 for three per cent.
        normals: (n, 3), the first placements' normals, object frame.
        rng: where the errors come from.
        kinds: which of ``KINDS`` are off; the others are as modelled.
    """
    n = len(nominal.radius)

    def factor(count: int, kind: str) -> Array:
        drawn: Array = rng.uniform(1.0 - share, 1.0 + share, count)
        return drawn if kind in kinds else np.ones(count)

    sides, heavier = factor(3, "size"), float(factor(1, "mass")[0])
    shift = rng.uniform(-share, share, (n, 3)) * nominal.size * ("place" in kinds)
    shift -= np.einsum("ni,ni->n", shift, normals)[:, None] * normals
    # J of a body stretched along its axes, from its second moments.
    moments = np.trace(nominal.inertia) / 2.0 * np.eye(3) - nominal.inertia
    moments = moments * np.outer(sides, sides)
    inertia = heavier * (np.trace(moments) * np.eye(3) - moments)
    return replace(
        nominal,
        pieces=tuple(piece * sides for piece in nominal.pieces),
        mass=heavier * nominal.mass,
        inertia=inertia,
        friction=nominal.friction * factor(n, "friction"),
        environment_friction=nominal.environment_friction * float(factor(1, "friction")[0]),
        offset=shift,
    )


def lifted(errant: Bodies, nominal: Bodies, rotation: Array) -> Bodies:
    """Return ``errant`` with its object raised or lowered so that it stands as the planned one.

    Its size is another; ``rotation`` (3, 3) takes object to world at the start.
    """
    down = rotation[2]
    lowest = [float((np.concatenate(w.pieces) @ down).min()) for w in (errant, nominal)]
    return replace(errant, lift=lowest[1] - lowest[0])
