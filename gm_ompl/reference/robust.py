"""Sec. 3.4 where friction, mass and placement are known within ranges, stated plainly.

Modes and f_com are common to all cases; a case is a world at a corner of the ranges.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.reference.equilibrium import BALANCED
from gm_ompl.reference.modes import Modes
from gm_ompl.reference.stability import stability_at
from gm_ompl.reference.statics import statics
from gm_ompl.uncertainty.worlds import World, in_world


def margin_in(
    instant: Instant, modes: Modes, f_com: Sequence[float | None], world: World,
    allowed: float = BALANCED,
) -> float:  # fmt: skip
    """Return z of stored modes and f_com in a world; Problem (5) is not asked.

    Args:
        instant: the nominal contacts, fingers and object.
        modes: per finger.
        f_com: per finger, its commanded normal force; None under position control.
        world: how it differs, to these fingers.
        allowed: what may be missing of equilibrium, over M g.

    Raises:
        SolverError: the solver returned no answer.
    """
    model = statics(in_world(instant, world))
    force = np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
    commanded = np.array([0.0 if f is None else f for f in f_com], dtype=np.float64)
    pressed = world.commanded(commanded, instant.max_normal_force)
    found = stability_at(model, modes, np.where(force, pressed, 0.0) / model.scale, allowed)
    return found.z * model.scale
