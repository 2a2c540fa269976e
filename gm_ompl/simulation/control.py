"""What the fingers do: stiff position control, hybrid control, and the change between them."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.simulation.physics import TIP_MASS
from gm_ompl.simulation.timeline import Timeline

STIFFNESS = 2e3
"""Of a position-controlled fingertip [N/m]: the cork box's weight moves it by 0.45 mm. Contacts are
thirty times as stiff; a finger as stiff as they are would lose its lean where they give way."""

DAMPING = 2.0 * (STIFFNESS * TIP_MASS) ** 0.5
"""Critical [N s/m]."""

YIELDING = 2.0
"""Damping along the normal under force control [N s/m]: little, the force is what counts."""

FREE = 0.05
"""Time constant in which a finger in the air gives up the offset of its last contact [s]."""


class Servo:
    """The fingers' controller; its memory is one offset per finger along the normal.

    While a finger is under force control, or feels for the surface, the offset follows it, such
    that the spring of position control would press just as hard: a switch changes no force.

    Args:
        timeline: what is commanded, SI units.

    Attributes:
        offset: (n,), added to the target along the normal [m].
    """

    def __init__(self, timeline: Timeline) -> None:
        self._line, self.offset = timeline, np.zeros(timeline.fingers)

    def forces(self, k: int, centres: Array, velocities: Array) -> Array:
        """Return the forces (n, 3) on the fingertips [N] at instant ``k``.

        Args:
            k: number of the instant.
            centres: (n, 3), where the fingertips are.
            velocities: (n, 3), likewise.
        """
        line, n = self._line, self._line.normal[k]
        error, slower = line.centre[k] - centres, line.velocity[k] - velocities
        ahead = (error * n).sum(axis=1)
        closing = (slower * n).sum(axis=1)
        reach = np.where(line.landing[k], line.press[k], self.offset)
        pressed = (line.lean[k] * n).sum(axis=1)
        spring = pressed + STIFFNESS * (ahead + reach)
        held = np.minimum(spring + DAMPING * closing, line.limit[k])
        given = line.f_com[k] + YIELDING * closing
        normal = held + line.force_share[k] * (given - held)
        self._follow(k, ahead, np.minimum(spring, line.limit[k]) - pressed, pressed)
        sideways = STIFFNESS * (error - ahead[:, None] * n) + DAMPING * (
            slower - closing[:, None] * n
        )
        sideways = sideways + line.lean[k] - pressed[:, None] * n
        forces: Array = sideways + normal[:, None] * n + TIP_MASS * line.acceleration[k]
        return forces

    def _follow(self, k: int, ahead: Array, held: Array, pressed: Array) -> None:
        """Move the offsets to where position control would go on from here."""
        line = self._line
        forced = line.force_share[k] >= 1.0
        bumpless = np.where(forced, line.f_com[k] - pressed, held) / STIFFNESS - ahead
        fading = np.where(line.down[k], 1.0, np.exp(-line.dt / FREE))
        self.offset = np.where(forced | line.landing[k], bumpless, fading * self.offset)
