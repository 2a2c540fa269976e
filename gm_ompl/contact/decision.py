"""The outcome of Sec. 3.4, shared by the kernel and the reference."""

from __future__ import annotations

import enum
import math
from typing import Final, NamedTuple

COMMANDS: Final = (8, 8, 8, 4)
"""By the number of force-controlled fingers, into how many equal steps f_max is divided where
f_com is looked for by trial; 2 for more fingers."""


def command_steps(forced: int) -> tuple[float, ...]:
    """Return the commands over f_max that are tried per force-controlled finger, large first."""
    steps = COMMANDS[forced] if forced < len(COMMANDS) else 2
    return tuple(k / steps for k in range(steps, -1, -1))


class ControlMode(enum.Enum):
    """How a finger is controlled (assumption 9)."""

    POSITION = "position"
    FORCE = "force"


class Outcome(enum.Enum):
    """How a mode decision ended; the value is a sentence for the user."""

    STABLE = "some modes build up no excessive internal force (5) and balance the object (3)"
    INTERNAL_FORCE = "every choice of modes lets fingers squeeze without bound: internal force (5)"
    BELOW = "z is smaller than the threshold asked about, for every choice of modes"
    NO_EQUILIBRIUM = (
        "no choice of modes free of excessive internal force (5) balances the object (3)"
    )
    UNDECIDED = "no answer could be proven, neither by the kernel nor by the reference"


class ModeDecision(NamedTuple):
    """The best combination of control modes at an instant.

    Attributes:
        outcome: how the decision ended.
        z: the stability margin in the scenario's units of force, never negative where
            ``outcome`` is STABLE; an upper bound on it where BELOW; else -inf.
        modes: per finger; empty unless STABLE.
        f_com: commanded normal force per finger, None under position control; empty unless
            STABLE.
        direction: number of the direction l_i that limits z (0..75), or -1.
        nominal: z of Problem (6) where ``z`` is z_strong; else None.
    """

    outcome: Outcome
    z: float
    modes: tuple[ControlMode, ...] = ()
    f_com: tuple[float | None, ...] = ()
    direction: int = -1
    nominal: float | None = None


def undecided(fingers: int, optimistic: bool) -> ModeDecision:
    """Return what stands for a decision that nobody could prove: none, or any z, for bounds."""
    if not optimistic:
        return ModeDecision(Outcome.UNDECIDED, -math.inf)
    modes = (ControlMode.POSITION,) * fingers
    return ModeDecision(Outcome.STABLE, math.inf, modes, (None,) * fingers)
