"""The contact state: what the mechanics needs to know of the object's contacts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gm_ompl.arrays import Array, IntArray, fix, surfaces_of
from gm_ompl.uncertainty.ranges import Uncertainty


@dataclass(frozen=True, eq=False)
class ContactState:
    """Contacts between the object and its environment at an instant, object frame.

    Attributes:
        points: (m, 3), contact points.
        normals: (m, 3), unit, pointing into the object.
        slip: (m, 3), unit tangential velocity of the object's point where the contact slides
            (C_slide), zero where it is static (C_stat). Separating contacts are left out.
        rotation: (3, 3), object to world; its rows are the world's axes in the object frame,
            which fix the cones' reference directions and the direction of gravity.
        surfaces: (m,), what each touches: 0 the floor, i + 1 obstacle i. May be left out where
            all are alike.
    """

    points: Array
    normals: Array
    slip: Array
    rotation: Array
    surfaces: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        fix(self, points=(None, 3), rotation=(3, 3))
        m = len(self.points)
        fix(self, normals=(m, 3), slip=(m, 3))
        object.__setattr__(self, "surfaces", surfaces_of(self.surfaces, m))


@dataclass(frozen=True, eq=False)
class Instant:
    """One mode decision's whole input: manipulation at an instant (Sec. 2.2), object frame.

    Attributes:
        contacts: the environment contacts.
        points: (n, 3), contact points of the fingers that touch.
        normals: (n, 3), unit, pointing into the object.
        friction: (n,), Coulomb coefficient of each finger.
        max_normal_force: (n,), f_max.
        environment_friction: Coulomb coefficient of every environment contact.
        mass: M.
        inertia: (3, 3), J about the centre of mass.
        gravity: g; its direction is the world's -z.
        cone_edges: s, unit edge vectors per friction cone.
        soft: (n,), length L of each finger: beside its cone a soft fingertip has a moment of up
            to mu L about the normal per unit of normal force; 0 is a point. Where
            all are points it may be left out.
        contact_friction: (m,), Coulomb coefficient of each environment contact, where they
            differ; left out, all have ``environment_friction`` (see ``friction_at_contacts``).
        excess: (6,), wrench about the origin on top of the nominal weight, in a world in which
            mass, centre of mass or gravity differ. Norm and unit of force stay the nominal ones.
        uncertainty: ranges of what is not known exactly, for these fingers. Sec. 3.4 then chooses
            for all cases at once, and z is the least of theirs.
    """

    contacts: ContactState
    points: Array
    normals: Array
    friction: Array
    max_normal_force: Array
    environment_friction: float
    mass: float
    inertia: Array
    gravity: float
    cone_edges: int = 6
    soft: Array = field(default_factory=lambda: np.zeros(0))
    contact_friction: Array = field(default_factory=lambda: np.zeros(0))
    excess: Array = field(default_factory=lambda: np.zeros(6))
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __post_init__(self) -> None:
        fix(self, points=(None, 3), inertia=(3, 3))
        n = len(self.points)
        if not np.any(self.soft):
            object.__setattr__(self, "soft", np.zeros(n))
        fix(self, normals=(n, 3), friction=(n,), max_normal_force=(n,), soft=(n,), excess=(6,))
        if len(self.contact_friction):
            fix(self, contact_friction=(len(self.contacts.points),))

    @property
    def friction_at_contacts(self) -> Array:
        """Coulomb coefficient (m,) of each environment contact."""
        if len(self.contact_friction):
            return self.contact_friction
        return np.full(len(self.contacts.points), self.environment_friction)

    @property
    def force_scale(self) -> float:
        """Unit of force used inside the programs: M g, else the largest f_max, else 1."""
        if self.gravity > 0:
            return self.mass * self.gravity
        return float(self.max_normal_force.max(initial=0.0)) or 1.0
