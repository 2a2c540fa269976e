"""What a hand's motors must give at rest: against its weight, and for its fingertips' forces."""

from __future__ import annotations

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.hand.model import HandModel
from gm_ompl.hand.parsing import mujoco


class Efforts:
    """Torques of a hand that stands where its model was placed.

    Args:
        model: the hand.
        gravity: g, along the world's -z [m/s^2].
    """

    def __init__(self, model: HandModel, gravity: float) -> None:
        self._mujoco, self._model = mujoco(), model
        model.model.opt.gravity[:] = (0.0, 0.0, -gravity)
        self._all = np.zeros(model.model.nv)

    def weight(self) -> Array:
        """Return (k,), the torques that hold the links up."""
        model, data = self._model.model, self._model.data
        self._mujoco.mj_comPos(model, data)
        self._mujoco.mj_rne(model, data, 0, self._all)
        return np.array(self._all[self._model.columns])

    def levers(self, points: Array) -> Array:
        """Return (n, 6, k), what forces and moments of fingertips load the hinges with.

        A fingertip's force f and moment m on what it touches at its point, (n, 3), world frame,
        take the torques levers[i].T @ (f, m).
        """
        model, data = self._model.model, self._model.data
        self._mujoco.mj_comPos(model, data)
        whole = np.zeros((len(points), 6, model.nv))
        for i, point in enumerate(points):
            body = self._model.tip_body(i)
            self._mujoco.mj_jac(model, data, whole[i, :3], whole[i, 3:], point, body)
        return whole[:, :, self._model.columns]
