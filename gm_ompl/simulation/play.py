"""Play a timeline back: the loop of commands, forces and steps, and what it saw."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.simulation.control import Servo
from gm_ompl.simulation.physics import Physics
from gm_ompl.simulation.timeline import Timeline
from gm_ompl.simulation.units import Units
from gm_ompl.simulation.world import World

EVERY = 4
"""Steps between two rows of a recording: 2 ms."""

Wrench = Callable[[int, Array], Array | None]
"""Disturbance at an instant, given the object's quaternion: (6,), world frame [N, N m]."""


@dataclass(frozen=True, eq=False)
class Recording:
    """What happened, K rows ``EVERY`` steps apart; world frame, SI units.

    Attributes:
        rows: (K,), the instants of the timeline.
        position: (K, 3), the object's centre of mass.
        quaternion: (K, 4), its orientation (w, x, y, z).
        centre: (K, n, 3), the fingertips' centres.
        normal_force: (K, n), mean over the row's steps.
        tangential_force: (K, n), likewise.
    """

    rows: IntArray
    position: Array
    quaternion: Array
    centre: Array
    normal_force: Array
    tangential_force: Array


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Where a play can be taken up again.

    Attributes:
        instant: the next instant of the timeline.
        physics: the simulator's state.
        offset: (n,), the servo's memory.
    """

    instant: int
    physics: Array
    offset: Array


class Player:
    """Plays a timeline in a world.

    Args:
        timeline: what is to happen, scenario's units, its time step ``STEP``.
        units: from the scenario's to the simulator's.
        world: where it happens, SI units.
    """

    def __init__(self, timeline: Timeline, units: Units, world: World) -> None:
        self.timeline, self.units, self.world = timeline, units, world
        self._si = timeline.scaled(units.length, units.force, world.offset)
        start = self._si.position[0] + np.array([0.0, 0.0, world.lift])
        self.physics = Physics(world, start, timeline.quaternion[0], self._si.centre[0])
        self.servo = Servo(self._si)
        self.instant = 0

    def snapshot(self) -> Snapshot:
        """Return where the play stands."""
        return Snapshot(self.instant, self.physics.state(), self.servo.offset.copy())

    def resume(self, snapshot: Snapshot) -> None:
        """Go back to where the play once stood."""
        self.instant = snapshot.instant
        self.physics.restore(snapshot.physics)
        self.servo.offset = snapshot.offset.copy()

    def play(
        self,
        until: int | None = None,
        wrench: Wrench | None = None,
        watch: Callable[[int], None] | None = None,
    ) -> Recording:
        """Play on to an instant (default: to the end).

        Args:
            until: the instant to stop before; beyond the end, the last command is held.
            wrench: a disturbance.
            watch: called with every instant, after its step.
        """
        until = len(self.timeline) if until is None else until
        rows, places, tips, forces = [], [], [], []
        n = self.timeline.fingers
        normal, sideways, count = np.zeros(n), np.zeros(n), 0
        while self.instant < until:
            k, here = self.instant, self.physics
            self._step(min(k, len(self.timeline) - 1), wrench)
            touches = here.touches()
            normal, sideways = normal + touches.normal, sideways + touches.tangential
            count += 1
            if count == EVERY or self.instant == until:
                rows.append(min(k, len(self.timeline) - 1))
                places.append(np.concatenate([here.position, here.quaternion]))
                tips.append(here.centres)
                forces.append((normal / count, sideways / count))
                normal, sideways, count = np.zeros(n), np.zeros(n), 0
            if watch is not None:
                watch(k)
        poses = np.array(places).reshape(-1, 7)
        return Recording(
            np.array(rows, dtype=np.int64), poses[:, :3], poses[:, 3:],
            np.array(tips).reshape(-1, n, 3),
            np.array([pair[0] for pair in forces]).reshape(-1, n),
            np.array([pair[1] for pair in forces]).reshape(-1, n),
        )  # fmt: skip

    def _step(self, k: int, wrench: Wrench | None) -> None:
        line, here = self._si, self.physics
        forces = self.servo.forces(k, here.centres, here.velocities)
        disturbance = None if wrench is None else wrench(self.instant, here.quaternion)
        here.step(forces, self.timeline.quaternion[k], line.own_spin[k], disturbance)
        self.instant += 1
