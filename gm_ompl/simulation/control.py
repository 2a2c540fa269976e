"""What the fingers do: stiff position control, hybrid control, and the change between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.simulation.physics import TIP_MASS

STIFFNESS = 2e3
"""Of a position-controlled fingertip [N/m]: the cork box's weight moves it by 0.45 mm. Contacts are
thirty times as stiff; a finger as stiff as they are would lose its lean where they give way."""

DAMPING = 2.0 * (STIFFNESS * TIP_MASS) ** 0.5
"""Critical [N s/m]."""

YIELDING = 2.0
"""Damping along the normal under force control [N s/m]: little, the force is what counts."""

FREE = 0.05
"""Time constant in which a finger in the air gives up the offset of its last contact [s]."""


@dataclass(frozen=True, eq=False)
class Command:
    """One instant of the timeline for n fingers, SI units, world frame.

    Attributes:
        centre: (n, 3).
        velocity: (n, 3).
        acceleration: (n, 3).
        normal: (n, 3), into the object.
        force_share: (n,).
        f_com: (n,).
        lean: (n, 3).
        limit: (n,).
        press: (n,).
        down: (n,) bool.
        landing: (n,) bool.
    """

    centre: Array
    velocity: Array
    acceleration: Array
    normal: Array
    force_share: Array
    f_com: Array
    lean: Array
    limit: Array
    press: Array
    down: BoolArray
    landing: BoolArray


@dataclass
class Servo:
    """The fingers' controller; its memory is one offset per finger along the normal.

    While a finger is under force control, or feels for the surface, the offset follows it, such
    that the spring of position control would press just as hard: a switch changes no force.

    Attributes:
        count: number of fingers n.
        step: time step [s].
        offset: (n,), added to the target along the normal [m].
    """

    count: int
    step: float
    offset: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        self.offset = np.zeros(self.count)

    def forces(self, command: Command, centres: Array, velocities: Array) -> Array:
        """Return the forces (n, 3) on the fingertips [N]."""
        n = command.normal
        error, slower = command.centre - centres, command.velocity - velocities
        ahead = (error * n).sum(axis=1)
        closing = (slower * n).sum(axis=1)
        reach = np.where(command.landing, command.press, self.offset)
        pressed = (command.lean * n).sum(axis=1)
        spring = pressed + STIFFNESS * (ahead + reach)
        held = np.minimum(spring + DAMPING * closing, command.limit)
        given = command.f_com + YIELDING * closing
        normal = held + command.force_share * (given - held)
        self._follow(command, ahead, np.minimum(spring, command.limit) - pressed, pressed)
        sideways = STIFFNESS * (error - ahead[:, None] * n) + DAMPING * (
            slower - closing[:, None] * n
        )
        sideways = sideways + command.lean - pressed[:, None] * n
        forces: Array = sideways + normal[:, None] * n + TIP_MASS * command.acceleration
        return forces

    def _follow(self, command: Command, ahead: Array, held: Array, pressed: Array) -> None:
        """Move the offsets to where position control would go on from here."""
        forced = command.force_share >= 1.0
        follows = forced | command.landing
        bumpless = np.where(forced, command.f_com - pressed, held) / STIFFNESS - ahead
        fading = np.where(command.down, 1.0, np.exp(-self.step / FREE))
        self.offset = np.where(follows, bumpless, fading * self.offset)
