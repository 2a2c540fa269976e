"""Whether a junction holds: Eq. (3) with the commands at an end of its ramp, stated plainly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.contact.decision import ControlMode
from gm_ompl.contact.state import Instant
from gm_ompl.errors import SolverError
from gm_ompl.reference import highs
from gm_ompl.reference.cases import cases, hardest
from gm_ompl.reference.equilibrium import in_equilibrium
from gm_ompl.reference.exact import Effort, balanced
from gm_ompl.reference.statics import Statics


def equilibrium(
    instant: Instant, modes: Sequence[ControlMode], f_com: Sequence[float | None]
) -> bool:
    """Whether forces within cones and limits balance the load, the commands as given.

    Where something is uncertain they must in every case.

    Args:
        instant: the contacts, the fingers, the object.
        modes: per finger.
        f_com: per finger, its commanded normal force in the scenario's units; None under position
            control.

    Raises:
        SolverError: neither solver returned an answer.
    """
    force = np.array([mode is ControlMode.FORCE for mode in modes], dtype=bool)
    commanded = np.array([0.0 if f is None else f for f in f_com], dtype=np.float64)
    for case in hardest(cases(instant)):
        limits = np.where(force, case.commanded(commanded / case.model.scale), case.model.f_max)
        if not _balanced(case.model, limits, force):
            return False
    return True


def _balanced(model: Statics, limits: Array, force: BoolArray) -> bool:
    """Whether forces balance the load in one case.

    Forces found by least squares prove themselves; where there are none, HiGHS is asked, and exact
    arithmetic decides what it does not.
    """
    if _balance(model, limits, force):
        return True
    try:
        return in_equilibrium(model, limits, force)
    except SolverError:
        return balanced(model, limits, force, Effort())


def _balance(model: Statics, limits: Array, force: BoolArray) -> bool:
    """Whether the forces of least squares balance the load; where not, others still may."""
    env, rob = model.env_wrenches, model.rob_wrenches
    slack = np.eye(6 + model.fingers)[:, 6:][:, ~force]
    normal = np.hstack([np.zeros((model.fingers, env.shape[1])), model.normal_parts])
    columns = np.hstack([np.vstack([np.hstack([env, rob]), normal]), slack])
    right = np.append(-model.load, limits)
    try:
        k = nnls(columns, right)[0]
    except RuntimeError:  # too many iterations
        return False
    return bool(np.abs(columns @ k - right).max() <= highs.TOLERANCE)
