"""How fast: smooth starts and stops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError


@dataclass(frozen=True)
class Pace:
    """Speeds and times; lengths in diagonals D of the object, times in seconds.

    Attributes:
        speed: of the object's fastest vertex while it moves [D/s].
        ramp: time to reach that speed and to stop [s].
        settle: time to come to rest, at the beginning and at the end [s].
        switch: time in which modes and commanded forces change, the object at rest [s].
        lift: time to leave a surface, and to come down on it [s].
        transit: a lifted finger's speed [D/s].
        clearance: height of a finger above its placement when lifted [D].
        reach: how far beyond its placement a finger goes to find the surface [D].
    """

    speed: float = 0.3
    ramp: float = 0.3
    settle: float = 0.3
    switch: float = 0.3
    lift: float = 0.4
    transit: float = 0.6
    clearance: float = 0.015
    reach: float = 0.015

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
