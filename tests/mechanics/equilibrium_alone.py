"""Whether forces balance the load, asked plainly: what ``z_min: 0`` is held to."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from gm_ompl.contact.state import Instant
from gm_ompl.reference.statics import Statics, statics

SURE = (1e-10, 1e-8)
"""What is missing of equilibrium, over M g, is below the one or above the other; else unsure."""


def balanced(instant: Instant) -> bool | None:
    """Return whether Eq. (3) has a solution, by scipy; None where that is too close to call."""
    least = missing(statics(instant))
    return None if SURE[0] < least < SURE[1] else least <= SURE[0]


def missing(model: Statics) -> float:
    """Return the least that any forces leave of the load, the largest entry in norm (7)."""
    A = np.hstack([model.env_wrenches, model.rob_wrenches])
    normal = np.hstack([np.zeros((model.fingers, model.env_wrenches.shape[1])), model.normal_parts])
    one = np.ones((6, 1))
    above, below = np.hstack([A, -one]), np.hstack([-A, -one])
    limits = np.hstack([normal, np.zeros((model.fingers, 1))])
    found = linprog(
        np.append(np.zeros(A.shape[1]), 1.0),
        A_ub=np.vstack([above, below, limits]),
        b_ub=np.concatenate([-model.load, model.load, model.f_max]),
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    assert found.status == 0, found.message
    return float(found.x[-1])
