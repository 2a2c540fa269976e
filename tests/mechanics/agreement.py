"""Kernel against reference at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gm_ompl.contact.decision import ModeDecision
from gm_ompl.contact.state import Instant
from gm_ompl.mechanics.instant import decide_instant
from gm_ompl.reference.internal_force import InternalForce, excessive_internal_force
from gm_ompl.reference.modes import combinations, decide_modes
from gm_ompl.reference.statics import force_unit, statics

AGREE = 1e-6
"""Largest difference in z, over max(z, 1e-3 M g)."""


@dataclass(frozen=True)
class Agreement:
    """How two decisions compare.

    Attributes:
        holds: same outcome, same modes, z within ``AGREE``.
        error: of z; +inf where outcomes or modes differ.
        note: both in words.
    """

    holds: bool
    error: float
    note: str


def compare(instant: Instant) -> Agreement:
    """Decide an instant twice."""
    return compared(decide_instant(instant), decide_modes(instant), force_unit(instant))


def compared(mine: ModeDecision, theirs: ModeDecision, unit: float) -> Agreement:
    """Compare two decisions whose forces are of the order of ``unit``."""
    error = np.inf
    if mine.outcome is theirs.outcome and mine.modes == theirs.modes:
        error = 0.0 if mine.z == theirs.z else z_error(mine.z, theirs.z, unit)
    return Agreement(error <= AGREE, error, f"kernel {mine}, reference {theirs}")


def z_error(mine: float, theirs: float, unit: float) -> float:
    """Return the difference of two margins over max(z, 1e-3 M g)."""
    return abs(mine - theirs) / max(abs(theirs), 1e-3 * unit)


def borderline(instant: Instant) -> bool:
    """Whether Problem (5) is too close to call for some set of position-controlled fingers."""
    model = statics(instant)
    for modes in combinations(model.fingers):
        position = [i for i, mode in enumerate(modes) if mode.value == "position"]
        if _close(excessive_internal_force(model, position)):
            return True
    return False


def _close(verdict: InternalForce) -> bool:
    if verdict.marginal:
        return True
    if verdict.excessive:
        return verdict.residual > 1e-10
    return verdict.margin < 1e-8
