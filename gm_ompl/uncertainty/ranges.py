"""The ranges within which a scenario's quantities may lie."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

Three = tuple[float, float, float]


@dataclass(frozen=True)
class Uncertainty:
    """Half-widths of ranges about the nominal values, in the scenario's units; default: none.

    An empty tuple stands for zeros.

    Attributes:
        environment_friction: Coulomb coefficient of the environment: one number for all of it,
            or the floor's and then each obstacle's.
        finger_friction: (n,), Coulomb coefficient of each finger.
        mass: M.
        centre_of_mass: along the axes of the object frame.
        position: where a finger touches, along two tangents of the face.
        command: relative error of a commanded force.
        tilt: how far gravity leans against object and contacts: tangent of an angle, along the
            world's x and as much along its y.
    """

    environment_friction: tuple[float, ...] = ()
    finger_friction: tuple[float, ...] = ()
    mass: float = 0.0
    centre_of_mass: Three = (0.0, 0.0, 0.0)
    position: float = 0.0
    command: float = 0.0
    tilt: float = 0.0

    def __bool__(self) -> bool:
        """Whether anything is uncertain."""
        plain = (self.mass, self.position, self.command, self.tilt)
        lists = (self.environment_friction, self.finger_friction, self.centre_of_mass)
        return any(plain) or any(any(values) for values in lists)

    def scaled(self, factor: float) -> Uncertainty:
        """Return all ranges ``factor`` times as wide."""
        x, y, z = self.centre_of_mass
        return Uncertainty(
            tuple(factor * width for width in self.environment_friction),
            tuple(factor * width for width in self.finger_friction),
            factor * self.mass,
            (factor * x, factor * y, factor * z),
            factor * self.position,
            factor * self.command,
            factor * self.tilt,
        )

    def of(self, fingers: tuple[int, ...]) -> Uncertainty:
        """Return what concerns the given fingers alone."""
        if not self.finger_friction:
            return self
        own = tuple(self.finger_friction[i] for i in fingers)
        return dataclasses.replace(self, finger_friction=own)
