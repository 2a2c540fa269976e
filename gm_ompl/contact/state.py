"""The contact state: what the mechanics needs to know of the object's contacts."""

from __future__ import annotations

from dataclasses import dataclass

from gm_ompl.arrays import Array, read_only


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
    """

    points: Array
    normals: Array
    slip: Array
    rotation: Array

    def __post_init__(self) -> None:
        for name in ("points", "normals", "slip"):
            object.__setattr__(self, name, read_only(getattr(self, name), (None, 3), name))
        object.__setattr__(self, "rotation", read_only(self.rotation, (3, 3), "rotation"))


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

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", read_only(self.points, (None, 3), "points"))
        n = len(self.points)
        object.__setattr__(self, "normals", read_only(self.normals, (n, 3), "normals"))
        object.__setattr__(self, "friction", read_only(self.friction, (n,), "friction"))
        limits = read_only(self.max_normal_force, (n,), "max_normal_force")
        object.__setattr__(self, "max_normal_force", limits)
        object.__setattr__(self, "inertia", read_only(self.inertia, (3, 3), "inertia"))

    @property
    def force_scale(self) -> float:
        """Unit of force used inside the programs: M g, else the largest f_max, else 1."""
        if self.gravity > 0:
            return self.mass * self.gravity
        return float(self.max_normal_force.max(initial=0.0)) or 1.0
