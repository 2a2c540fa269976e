"""What a player asks of a simulator."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any, Literal, Protocol, TypeAlias, get_args

from gm_ompl.arrays import Array
from gm_ompl.simulation.world import Bodies

STEP = 5e-4  # time step [s]: a sixteenth of the period of a finger on its servo
TIP_MASS = 0.1  # what a servo moves: a fingertip and its share of the finger [kg]

TIP_INERTIA = 1.0
"""So large that a fingertip turns as it is told, whatever the contact does [kg m^2]."""

EngineName: TypeAlias = Literal["mujoco", "dart"]
"""MuJoCo: soft contacts, convex. DART: rigid ones, Coulomb's law solved by sweeps."""

ENGINES: tuple[str, ...] = get_args(EngineName)


class Engine(Protocol):
    """A world in motion.

    The object is free; the fingertips are free spheres that are pushed by forces and turned by
    decree. They touch the object alone: that their way is clear of everything else is the
    planner's business.
    """

    world: Bodies

    @property
    def position(self) -> Array:
        """(3,), the object's centre of mass as modelled: the origin of its frame."""

    @property
    def quaternion(self) -> Array:
        """(4,), the object's orientation (w, x, y, z)."""

    @property
    def centres(self) -> Array:
        """(n, 3), the fingertips' centres."""

    @property
    def velocities(self) -> Array:
        """(n, 3), of the fingertips' centres."""

    def step(
        self, forces: Array, quaternion: Array, spin: Array, wrench: Array | None = None
    ) -> None:
        """Advance by one time step.

        Args:
            forces: (n, 3), on the fingertips [N].
            quaternion: (4,), the fingertips' orientation.
            spin: (3,), their angular velocity, in their own frame [rad/s].
            wrench: (6,), a disturbance of the object, world frame, about its ``position``.
        """

    def normal_forces(self) -> Array:
        """Return (n,), each fingertip's normal force on the object in the last step [N]."""

    def state(self) -> Array:
        """Return everything that the future depends on."""

    def restore(self, state: Array) -> None:
        """Go back to a former ``state``."""

    def camera(self, look_at: Array, width: int, height: int) -> AbstractContextManager[Any]:
        """Give a function that returns the view of ``look_at``, (height, width, 3) bytes.

        Raises:
            InputError: this engine shows nothing.
        """
