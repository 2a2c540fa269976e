"""Plays a timeline back: the fingers' control, the loop of forces and steps, and what it saw."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.errors import InputError
from gm_ompl.simulation.engine import TIP_MASS, Engine, EngineName
from gm_ompl.simulation.engines import start
from gm_ompl.simulation.robot import Robot
from gm_ompl.simulation.timeline import Timeline
from gm_ompl.simulation.world import Bodies, Units

STIFFNESS = 1e3
"""Of a position-controlled fingertip [N/m]: the cork box's weight moves it by 0.9 mm. Where it errs
by a tenth of a millimetre it presses wrongly by 11% of that weight; stiffer ones, which err by more
than the margin, lose plans that hold."""

DAMPING = 2.0 * (STIFFNESS * TIP_MASS) ** 0.5  # critical [N s/m]

YIELDING = DAMPING
"""Damping along the normal under force control [N s/m]: a finger keeps pace with the plan even
where nothing but its own force drives the object."""

FREE = 0.05
"""Time constant in which a finger in the air gives up the offset of its last contact [s]."""

SETTLING = 0.05
"""Time constant in which fingers that are all force-controlled give up what their springs pull
sideways before the object first moves [s]: nothing but what they then lean with drives it."""


class Servo:
    """The fingers' controller; its memory is one offset per finger.

    While a finger is under force control, or feels for the surface, the offset along the normal
    follows it, such that the spring of position control would press just as hard: a switch changes
    no force. Where forces alone drive the object, the offset beside the normal settles first.

    Args:
        timeline: what is commanded, SI units.

    Attributes:
        offset: (n,), added to the target along the normal [m].
        beside: (n, 3), added to it along the surface, object frame [m].
    """

    def __init__(self, timeline: Timeline) -> None:
        self._line, self.offset = timeline, np.zeros(timeline.fingers)
        self.beside = np.zeros((timeline.fingers, 3))

    def forces(self, k: int, centres: Array, velocities: Array) -> Array:
        """Return the forces (n, 3) on the fingertips [N] at instant ``k``.

        The fingertips are at ``centres`` (n, 3) and move with ``velocities`` (n, 3).
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
        along = error - ahead[:, None] * n
        self._settle(k, along)
        sideways = STIFFNESS * (along + self.beside @ line.rotation[k].T) + DAMPING * (
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

    def _settle(self, k: int, along: Array) -> None:
        """Move the offsets beside the normal to where the springs, ``along`` (n, 3) off, rest."""
        line = self._line
        step = np.where(line.settling[k], line.dt / SETTLING, 0.0)[:, None]
        down = (line.down[k] | line.landing[k])[:, None]
        self.beside = down * ((1.0 - step) * self.beside - step * (along @ line.rotation[k]))


EVERY = 4  # steps between two rows of a recording: 2 ms

Wrench = Callable[[int, Array], Array | None]
"""Disturbance at an instant, given the object's quaternion: (6,), world frame [N, N m]."""


@dataclass(frozen=True, eq=False)
class Recording:
    """What happened, K rows ``EVERY`` steps apart; world frame, SI units."""

    rows: IntArray  # (K,), the instants of the timeline
    position: Array  # (K, 3), the object's centre of mass
    quaternion: Array  # (K, 4), its orientation (w, x, y, z)
    centre: Array  # (K, n, 3), the fingertips' centres
    normal_force: Array  # (K, n), mean over the row's steps


Snapshot: TypeAlias = tuple[int, Array, Array, Array]
"""Where a play can be taken up again: the next instant, the simulator's state, the servo's
offsets."""


class Player:
    """Plays a timeline (scenario's units, time step ``STEP``) in a world (SI units)."""

    def __init__(
        self, timeline: Timeline, units: Units, world: Bodies, engine: EngineName = "mujoco"
    ) -> None:
        self.timeline, self.units, self.world = timeline, units, world
        self._si = timeline.scaled(units.length, units.force, world.offset)
        place = self._si.position[0] + np.array([0.0, 0.0, world.lift])
        turned = timeline.quaternion[0]
        self.robot: Robot | None = None
        if world.hand is not None:
            if engine != "mujoco":
                raise InputError("robot hands are simulated in MuJoCo alone: leave --engine away")
            self.robot = Robot(world, place, turned, timeline.joints[0])
        self.physics: Engine = self.robot or start(engine, world, place, turned, self._si.centre[0])
        self.servo = Servo(self._si)
        self.instant = 0

    def snapshot(self) -> Snapshot:
        """Return where the play stands."""
        servo = self.servo
        return self.instant, self.physics.state(), servo.offset.copy(), servo.beside.copy()

    def resume(self, snapshot: Snapshot) -> None:
        """Go back to where the play once stood."""
        self.instant, state, offset, beside = snapshot
        self.physics.restore(state)
        self.servo.offset, self.servo.beside = offset.copy(), beside.copy()

    def play(
        self,
        until: int | None = None,
        wrench: Wrench | None = None,
        watch: Callable[[int], None] | None = None,
    ) -> Recording:
        """Play on to the end or before ``until``; beyond the end the last command is held.

        ``wrench`` is a disturbance; ``watch`` is called with every instant, after its step.
        """
        until = len(self.timeline) if until is None else until
        rows, places, tips, forces = [], [], [], []
        last = len(self.timeline) - 1
        pressed: list[Array] = []
        while self.instant < until:
            k, here = self.instant, self.physics
            self._step(min(k, last), wrench)
            pressed.append(here.normal_forces())
            if len(pressed) == EVERY or self.instant == until:
                rows.append(min(k, last))
                places.append(np.concatenate([here.position, here.quaternion]))
                tips.append(here.centres)
                forces.append(np.mean(pressed, axis=0))
                pressed = []
            if watch is not None:
                watch(k)
        poses, n = np.array(places).reshape(-1, 7), self.timeline.fingers
        return Recording(
            np.array(rows, dtype=np.int64), poses[:, :3], poses[:, 3:],
            np.array(tips).reshape(-1, n, 3), np.array(forces).reshape(-1, n),
        )  # fmt: skip

    def advance(self, until: int, wrench: Wrench | None = None) -> None:
        """Play on before ``until`` as ``play`` does, but record nothing."""
        last = len(self.timeline) - 1
        while self.instant < until:
            self._step(min(self.instant, last), wrench)

    def _step(self, k: int, wrench: Wrench | None) -> None:
        line, here = self._si, self.physics
        if self.robot is not None:
            arms = self.world.radius[:, None] * line.normal[k]
            self.robot.aim(line.joints[k], line.joint_speed[k], arms)
        forces = self.servo.forces(k, here.centres, here.velocities)
        disturbance = None if wrench is None else wrench(self.instant, here.quaternion)
        here.step(forces, self.timeline.quaternion[k], line.own_spin[k], disturbance)
        self.instant += 1
