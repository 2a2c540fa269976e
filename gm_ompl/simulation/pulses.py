"""Pulses of disturbance against an execution, and whether they are withstood."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.reference.statics import scaling_root
from gm_ompl.simulation.engine import STEP
from gm_ompl.simulation.execute import Setup
from gm_ompl.simulation.measure import rotations
from gm_ompl.simulation.play import Player, Snapshot
from gm_ompl.simulation.timeline import PHASES
from gm_ompl.writing import plain

RISE, HOLD = 0.1, 0.1
"""A pulse rises as a raised cosine, stays, and falls likewise, in these times [s]."""

PULSE = 2.0 * RISE + HOLD  # its length [s]
REST = 0.3  # time after the pulse until the object must be back [s]
BACK = 0.01  # how near it must be, every corner, to where it would be without the pulse [D]

WHOLE = round(PULSE / STEP) + round(REST / STEP)
"""Time steps from the beginning of a pulse to its judgement."""

STILL = 0.001
"""Most that a fingertip may still move over the object in the second half of ``REST`` [D]."""


def shape(instants: int) -> float:
    """Return the strength of a pulse ``instants`` time steps after its beginning, peak 1."""
    into = min(instants, round(PULSE / STEP) - instants) * STEP
    return float((1.0 - np.cos(np.pi * min(max(into / RISE, 0.0), 1.0))) / 2.0)


@dataclass(frozen=True)
class Trial:
    """One pulse."""

    time: float  # when it begins [s]
    phase: str  # what happens then
    direction: int  # number of the direction l_i, or -1 for a random one
    strength: float  # its peak in the norm (7), scenario's units
    z: float  # the least stability margin that the plan states during the pulse, at least its z_min
    offset: float  # how far the object's farthest corner was from its place afterwards [D]
    slip: float  # how far a fingertip still moved over the object afterwards [D]
    withstood: bool  # whether both are small


@dataclass(frozen=True)
class PulseReport:
    """Pulses of one strength."""

    fraction: float  # peak of the pulses over z
    trials: tuple[Trial, ...]  # in order of time
    pulse: float = PULSE  # their length [s]
    rest: float = REST  # time from the end of a pulse to the judgement [s]

    @property
    def lost(self) -> tuple[Trial, ...]:
        """The pulses that were not withstood."""
        return tuple(trial for trial in self.trials if not trial.withstood)

    @property
    def share(self) -> float:
        """Share of the pulses withstood; 1 where there is nothing to try."""
        return 1.0 - len(self.lost) / max(len(self.trials), 1)

    @property
    def findings(self) -> tuple[str, ...]:
        """The pulses that were not withstood, in words."""
        return tuple(
            f"a z of {trial.z:.4g} is claimed at {trial.time:.2f} s ({trial.phase}), but "
            f"{self.fraction:g} of it in {direction_name(trial.direction)} leaves the object "
            f"{100 * trial.offset:.2g}% of D off, slipping by {100 * trial.slip:.2g}%"
            for trial in self.lost
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, ready for JSON."""
        tree: dict[str, Any] = {"share": self.share, **plain(self)}
        return tree

    def table(self) -> str:
        """Return the report as lines of text."""
        tried = len(self.trials)
        lines = [
            f"{tried} pulses of {self.pulse:g} s and {self.fraction:g} z: "
            f"{tried - len(self.lost)} of {tried} withstood ({100 * self.share:.1f}%)"
        ]
        phases = Counter(trial.phase for trial in self.trials)
        lost = Counter(trial.phase for trial in self.lost)
        lines += [f"  while {p:8} {n - lost[p]} of {n}" for p, n in phases.items()]
        return "\n".join([*lines, *(f"NOT: {finding}" for finding in self.findings[:10])])


def direction_name(direction: int) -> str:
    """Return a direction of Problem (6) in words; -1 is a random one."""
    return "a random direction" if direction < 0 else f"direction l_{direction}"


class Disturber:
    """Puts pulses, from any of ``instants`` on, on an execution once played without them."""

    def __init__(self, setup: Setup, instants: Sequence[int]) -> None:
        self._setup, self._player = setup, setup.player()
        self._root = np.linalg.inv(scaling_root(setup.problem.mass, setup.problem.inertia))
        self._corners = setup.problem.body.vertices * setup.units.length
        self._pulse, self._rest = round(PULSE / STEP), round(REST / STEP)
        self._snapshots: dict[int, Snapshot] = {}
        self._undisturbed: dict[int, Array] = {}
        begins = set(instants)
        for instant in sorted(begins | {begin + WHOLE for begin in begins}):
            self._player.advance(instant)
            if instant in begins:
                self._snapshots[instant] = self._player.snapshot()
            self._undisturbed[instant] = self.configuration(self._player)

    def adopt(self, begin: Snapshot, end: Array) -> None:
        """Take up an execution that was played elsewhere, for a pulse that begins at ``begin``.

        ``end`` is its configuration when the pulse will be judged.
        """
        self._snapshots[begin[0]] = begin
        self._undisturbed[begin[0] + WHOLE] = end

    def configuration(self, player: Player) -> Array:
        """Return the object's corners, world frame, and the fingertips' centres, object frame."""
        here = player.physics
        rotation = rotations(here.quaternion[None])[0]
        corners = self._corners @ rotation.T + here.position
        tips = (here.centres - here.position) @ rotation
        return np.concatenate([corners, tips])

    def trial(self, instant: int, direction: Array, number: int, fraction: float) -> Trial:
        """Put one pulse on the execution.

        Args:
            instant: where it begins; one of those given at the beginning.
            direction: (6,), in the scaled space of (6): unit, or an l_i itself.
            number: of the direction, or -1.
            fraction: peak over z, or over the z_min that every plan promises where that is more.
        """
        line, units = self._setup.timeline, self._setup.units
        z = float(line.z[instant : instant + self._pulse].min())
        z = max(z, self._setup.problem.mechanics.z_min)
        peak = fraction * z * (self._root @ direction)
        force, moment = units.force * peak[:3], units.force * units.length * peak[3:]

        def wrench(k: int, quaternion: Array) -> Array | None:
            if k >= instant + self._pulse:
                return None
            rotation = rotations(quaternion[None])[0]
            acting: Array = np.concatenate([rotation @ force, rotation @ moment])
            return shape(k - instant) * acting

        self._player.resume(self._snapshots[instant])
        judged = instant + self._pulse + self._rest
        between = judged - self._rest // 2
        self._player.advance(between, wrench)
        halfway = self.configuration(self._player)
        self._player.advance(judged, wrench)
        end = self.configuration(self._player)
        n, size = line.fingers, self._setup.world.size
        off = end - self._undisturbed[judged]
        offset = float(np.linalg.norm(off[: len(off) - n], axis=1).max()) / size
        # A finger on its way elsewhere moves against the object in any case.
        down = line.down[[min(k, len(line) - 1) for k in (between, judged)]].all(axis=0)
        moved = np.linalg.norm((end - halfway)[len(off) - n :], axis=1)[down]
        slip = float(moved.max(initial=0.0)) / size
        return Trial(
            time=float(line.time[instant]),
            phase=PHASES[int(line.phase[instant])],
            direction=number,
            strength=fraction * z * float(np.linalg.norm(direction)),
            z=z,
            offset=offset,
            slip=slip,
            withstood=offset <= BACK and slip <= STILL,
        )
