"""Inverse kinematics: damped least squares on MuJoCo's Jacobians, from several beginnings.

A mesh of hinge angles' samples says which beginnings are near; each is followed by Newton's steps
within the limits. What no beginning reaches may still be reachable: every answer is "over what
these restarts reached".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from gm_ompl.arrays import Array, BoolArray
from gm_ompl.hand.model import HandModel

if TYPE_CHECKING:
    from scipy.spatial import KDTree

SAMPLES: Final = 4096
"""Random configurations per finger from which beginnings are chosen."""

RESTARTS: Final = 6
"""Beginnings that are followed."""

STEPS: Final = 25
"""Newton's steps from one beginning."""

PATIENCE: Final = 4
"""In so many steps the error must halve: at the edge of what is reachable it no longer does."""

ACCURACY: Final = 1e-7
"""How near a fingertip's centre must come to where it is asked for [m]."""

DAMPING: Final = 1e-8
"""Added to J J^T [m^2]: near a singular configuration steps stay finite."""

STRIDE: Final = 0.5
"""The longest Newton's step [rad]."""

SAME: Final = 1e-3
"""Two configurations no hinge of which differs by more are one [rad]."""


class InverseKinematics:
    """Finds configurations whose fingertips are where they are asked for.

    Args:
        model: the hand; it is left where the last question put it.
        seed: of the beginnings.
    """

    def __init__(self, model: HandModel, seed: int = 0) -> None:
        self._model, self._rng = model, np.random.default_rng(seed)
        self._tables: dict[int, tuple[Array, KDTree]] = {}

    def follow(
        self, q: Array, fingers: Sequence[int], targets: Array, moving: BoolArray
    ) -> Array | None:
        """Return the configuration (k,) that Newton's steps from ``q`` lead to, or None.

        Args:
            q: (k,), where they begin.
            fingers: whose fingertips are asked for.
            targets: (len(fingers), 3), where, world frame.
            moving: (k,), the hinges that may move.
        """
        model, spec = self._model, self._model.spec
        q, columns, rows, before = q.copy(), np.flatnonzero(moving), list(fingers), np.inf
        for step_number in range(STEPS):
            model.place(q)
            error = (targets - model.tips()[rows]).ravel()
            off = float(np.abs(error).max(initial=0.0))
            if off <= ACCURACY:
                return q
            if step_number % PATIENCE == PATIENCE - 1:
                if off > before / 2.0:
                    return None
                before = off
            J = np.concatenate([model.jacobian(i) for i in rows])[:, columns]
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(J)), error)
            step *= min(1.0, STRIDE / max(float(np.abs(step).max()), 1e-12))
            q[columns] = np.clip(q[columns] + step, spec.low[columns], spec.high[columns])
        return None

    def solutions(
        self, finger: int, target: Array, q: Array, moving: BoolArray | None = None
    ) -> Iterator[Array]:
        """Yield different configurations (k,) with one fingertip at ``target`` (3,).

        Args:
            finger: whose fingertip.
            target: its centre, world frame.
            q: (k,), where the hinges stay that do not move it; tried first.
            moving: (k,), the hinges that may move: the finger's chain by default.
        """
        chain = self._model.chains[finger] if moving is None else moving
        samples, tree = self._table(finger)
        beginnings = samples[tree.query(target, RESTARTS)[1]]
        found: list[Array] = []
        for beginning in (q, *beginnings):
            start = np.where(chain, beginning, q)
            end = self.follow(start, (finger,), target[None], chain)
            if end is not None and all(np.abs(end - old).max() > SAME for old in found):
                found.append(end)
                yield end

    def _table(self, finger: int) -> tuple[Array, KDTree]:
        """Return configurations (SAMPLES, k) and where they put a fingertip."""
        from scipy.spatial import KDTree  # takes long to load

        if finger not in self._tables:
            spec, model = self._model.spec, self._model
            samples = self._rng.uniform(spec.low, spec.high, (SAMPLES, len(spec.low)))
            places = np.empty((SAMPLES, 3))
            for row, q in enumerate(samples):
                model.place(q)
                places[row] = model.tips()[finger]
            self._tables[finger] = samples, KDTree(places)
        return self._tables[finger]
