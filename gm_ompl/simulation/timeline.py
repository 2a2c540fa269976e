"""Time laid over a plan: how fast, where everything should be, and what is commanded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from gm_ompl.arrays import Array, BoolArray, IntArray
from gm_ompl.errors import InputError


@dataclass(frozen=True)
class Pace:
    """Speeds and times; lengths in diagonals D of the object, times in seconds."""

    # of the object's fastest vertex while it moves [D/s]: plans are quasi-static
    speed: float = 0.1
    ramp: float = 0.3  # time to reach that speed and to stop [s]
    settle: float = 0.3  # time to come to rest, at the beginning and at the end [s]
    switch: float = 0.3  # time in which modes and commanded forces change, the object at rest [s]
    lift: float = 0.4  # time to leave a surface, and to come down on it [s]
    transit: float = 0.6  # a lifted finger's speed [D/s]
    clearance: float = 0.015  # height of a finger above its placement when lifted [D]
    reach: float = 0.015  # how far beyond its placement a finger goes to find the surface [D]

    def __post_init__(self) -> None:
        if not (np.isfinite(self.speed) and 0 < self.speed <= 100):
            raise InputError(f"speed: {self.speed}: must be above 0, at most 100 diagonals per s")


def ramp(samples: int) -> Array:
    """Return (samples,), a smooth way from above 0 to 1, at rest at both ends."""
    share: Array = (1.0 - np.cos(np.pi * np.arange(1, samples + 1) / samples)) / 2.0
    return share


def progress(length: float, speed: float, rise: float, dt: float) -> Array:
    """Return the way travelled at times dt, 2 dt, ..., ending at exactly ``length``.

    The speed rises and falls as a raised cosine in ``rise`` [s]; a short way is travelled slower.
    """
    cruise = max(length / speed - rise, 0.0)
    peak = length / (cruise + rise)
    samples = max(1, round((cruise + 2.0 * rise) / dt))
    t = np.linspace(0.0, cruise + 2.0 * rise, samples + 1)[1:]

    def risen(time: Array) -> Array:
        within = np.clip(time, 0.0, rise)
        return peak / 2.0 * (within - rise / np.pi * np.sin(np.pi * within / rise))

    steady = peak * np.clip(t - rise, 0.0, cruise)
    fall = np.clip(t - rise - cruise, 0.0, rise)
    way: Array = risen(t) + steady + peak * fall - risen(fall)
    way[-1] = length
    return way


def between(along: Array, nodes: Array, values: Array) -> Array:
    """Return ``values`` (S, ...) given at ``nodes`` (S,) at the places ``along`` (K,), linearly."""
    flat = values.reshape(len(nodes), -1)
    mixed = np.stack([np.interp(along, nodes, column) for column in flat.T], axis=1)
    return mixed.reshape(len(along), *values.shape[1:])


PHASES = ("settle", "approach", "switch", "move", "lift", "transit", "land")
"""What happens: fingers stand off, come down, modes and forces change, the object moves, and a
finger leaves, is in transit, comes down."""


@dataclass(frozen=True, eq=False)
class Timeline:
    """The plan over time, T instants ``dt`` apart, n fingers; world frame, scenario's units."""

    dt: float  # time step [s]
    position: Array  # (T, 3), the centre of mass
    rotation: Array  # (T, 3, 3), object to world
    centre: Array  # (T, n, 3), the fingertips' centres
    normal: Array  # (T, n, 3), unit, into the object at the finger's placement
    # (T, n), 1 under force control, 0 under position control, between in a switch
    force_share: Array
    f_com: Array  # (T, n), commanded normal force; counts by ``force_share``
    # (T, n, 3), forces that the fingers lean on the object with, as far as they are under
    # position control
    lean: Array
    # (T, n), least normal force with which the object can be in balance; NaN where the object
    # rests or no balance exists
    least: Array
    most: Array  # (T, n), the greatest
    limit: Array  # (T, n), the most that a finger may press
    press: Array  # (T, n), how far beyond its placement a finger reaches for the surface
    down: BoolArray  # (T, n) bool, whether the finger is to be in contact
    # (T, n) bool, whether it looks for the surface: it then remains where it finds it
    landing: BoolArray
    step: IntArray  # (T,), step of the plan, -1 before the first
    segment: IntArray  # (T,), segment of that step, -1 where the object rests
    z: Array  # (T,), the stability margin stated by the plan at that place
    phase: IntArray  # (T,), index into ``PHASES``
    joints: Array  # (T, k), a hand's hinges [rad]; k is 0 without a hand
    notes: tuple[str, ...] = ()  # what could not be done as wished

    def __len__(self) -> int:
        return len(self.position)

    @property
    def fingers(self) -> int:
        """Number of fingers n."""
        return int(self.centre.shape[1])

    @cached_property
    def time(self) -> Array:
        """(T,), seconds since the beginning."""
        seconds: Array = self.dt * np.arange(len(self), dtype=np.float64)
        return seconds

    def scaled(self, length: float, force: float, offset: Array) -> Timeline:
        """Return the timeline in SI units: ``length`` metres and ``force`` newtons per unit.

        The fingertips' places are off by ``offset`` (n, 3), object frame [m].
        """
        moved = length * self.centre + np.einsum("tij,nj->tni", self.rotation, offset)
        lengths = {name: length * getattr(self, name) for name in ("position", "press")}
        forces = {name: force * getattr(self, name) for name in ("f_com", "limit", "lean")}
        return replace(self, centre=moved, **lengths, **forces)

    @cached_property
    def settling(self) -> BoolArray:
        """(T, n), whether all come under force control before the object first moves."""
        moved = np.logical_or.accumulate(self.phase == PHASES.index("move"))
        standing: BoolArray = (self.phase == PHASES.index("switch")) & ~moved
        alone = (self.force_share > 0.0).all(axis=1)
        return self.down & (standing & alone)[:, None]

    @cached_property
    def quaternion(self) -> Array:
        """(T, 4), the object's orientation, w x y z, without jumps of sign."""
        rows = Rotation.from_matrix(self.rotation).as_quat()[:, [3, 0, 1, 2]]
        turned = np.append(1.0, np.where((rows[1:] * rows[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
        whole: Array = rows * np.cumprod(turned)[:, None]
        return whole

    @cached_property
    def own_spin(self) -> Array:
        """(T, 3), the angular velocity in the object's frame [rad/s]."""
        return np.asarray(np.einsum("tji,tj->ti", self.rotation, self.spin))

    @cached_property
    def joint_speed(self) -> Array:
        """(T, k), of the hinges [rad/s]."""
        return _rate(self.joints, self.dt)

    @cached_property
    def spin(self) -> Array:
        """(T, 3), angular velocity of the object and of the fingertips [rad/s]."""
        step: Array = np.einsum("tij,tkj->tik", self.rotation[1:], self.rotation[:-1])
        skew = (step - step.transpose(0, 2, 1)) / 2.0
        turn: Array = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1) / self.dt
        whole: Array = np.concatenate([turn, turn[-1:]])
        return whole

    @cached_property
    def velocity(self) -> Array:
        """(T, n, 3), of the fingertips' centres."""
        return _rate(self.centre, self.dt)

    @cached_property
    def acceleration(self) -> Array:
        """(T, n, 3), of the fingertips' centres."""
        return _rate(self.velocity, self.dt)

    def inertia_wrench(self, mass: float, inertia: Array, length: float) -> Array:
        """Return (T, 6), the wrench that moving like this takes, about the centre, object frame.

        ``mass`` is M [kg], ``inertia`` (3, 3) is J [kg m^2], ``length`` is metres per unit.
        """
        acceleration = length * _rate(_rate(self.position, self.dt), self.dt)
        force = mass * np.einsum("tji,tj->ti", self.rotation, acceleration)
        momentum = np.einsum("tij,jk,tlk,tl->ti", self.rotation, inertia, self.rotation, self.spin)
        moment = np.einsum("tji,tj->ti", self.rotation, _rate(momentum, self.dt))
        return np.concatenate([force, moment], axis=1)


def _rate(values: Array, dt: float) -> Array:
    return np.asarray(np.gradient(values, dt, axis=0), dtype=np.float64)


def joined(parts: Sequence[Timeline]) -> Timeline:
    """Return the parts one after the other."""
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in Timeline.__dataclass_fields__
        if name not in ("dt", "notes")
    }
    notes = tuple(note for part in parts for note in part.notes)
    return Timeline(dt=parts[0].dt, notes=notes, **arrays)
