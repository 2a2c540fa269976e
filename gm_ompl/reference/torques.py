"""Whether a hand's motors can hold: Eq. (3) with the torques that its fingers' forces take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import sparse

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.reference import highs
from gm_ompl.reference.equilibrium import blocks
from gm_ompl.reference.program import LinearProgram, LpStatus
from gm_ompl.reference.statics import Statics

ROOM: Final = 0.9
"""Share of a motor's torque that plans count on; the rest is for control."""


@dataclass(frozen=True, eq=False)
class Motors:
    """A hand's motors at an instant; n touching fingers, k hinges.

    Attributes:
        levers: (n, 6, k), the torques levers[i].T @ (f, m) that finger i's force f and moment m
            on the object take, object frame.
        weight: (k,), the torques that hold the links up.
        most: (k,), the most that each motor gives.
    """

    levers: Array
    weight: Array
    most: Array

    def rows(self, model: Statics) -> Array:
        """Return (k, r), torques over ``most`` per unit of each of the fingers' columns."""
        found = np.zeros((len(self.most), model.C_rob.shape[1]))
        for i, columns in enumerate(model.columns):
            force = model.C_rob[3 * i : 3 * i + 3, columns]
            whole = np.vstack([force, model.M_rob[:, columns]])
            found[:, columns] = model.scale * self.levers[i].T @ whole
        rows: Array = found / self.most[:, None]
        return rows

    @property
    def idle(self) -> Array:
        """(k,), the share of its torque that each motor gives without any finger's force."""
        share: Array = self.weight / self.most
        return share


def turned(levers: Array, rotation: Array) -> Array:
    """Return levers (n, 6, k), object frame, of ones in the world frame."""
    parts = levers.reshape(len(levers), 2, 3, -1)
    found: Array = np.einsum("ji,npjk->npik", rotation, parts).reshape(levers.shape)
    return found


def least_share(
    model: Statics, force: BoolArray, f_com: Array, motors: Motors
) -> tuple[float, int] | None:
    """Return the least share of its torque that some motor must give, and which motor.

    Over all solutions of Eq. (3) with the commanded forces; None where it has none.

    Args:
        model: the mechanics.
        force: (n,), which fingers are force-controlled.
        f_com: (n,), commanded normal forces; counts where ``force``.
        motors: of the hand.

    Raises:
        SolverError: the solver returned no answer.
    """
    A, normal = blocks(model)
    edges, k = A.shape[1], len(motors.most)
    torque = np.hstack([np.zeros((k, edges - model.C_rob.shape[1])), motors.rows(model)])
    rows = np.vstack([A, normal, torque, -torque])
    share = np.concatenate([np.zeros(len(A) + len(normal)), np.full(2 * k, -1.0)])
    limits = np.where(force, f_com / model.scale, model.f_max)
    found = highs.solve(
        LinearProgram(
            cost=np.append(1.0, np.zeros(edges)),
            matrix=sparse.csc_array(np.hstack([share[:, None], rows])),
            row_lower=np.concatenate(
                [-model.load, np.where(force, limits, -np.inf), np.full(2 * k, -np.inf)]
            ),
            row_upper=np.concatenate([-model.load, limits, -motors.idle, motors.idle]),
            col_lower=np.zeros(1 + edges),
            col_upper=np.full(1 + edges, np.inf),
        )
    )
    if found.status is not LpStatus.OPTIMAL:
        return None
    used = np.abs(torque @ found.x[1:] + motors.idle)
    return float(used.max(initial=0.0)), int(used.argmax())
