"""Rotations as a scenario writes them, against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gm_ompl.scenario.fields import RotationModel
from gm_ompl.scenario.motions import rotation_matrix


@pytest.mark.parametrize("seed", range(10))
def test_all_ways_agree_with_scipy(seed: int) -> None:
    """Axis and angle, quaternion of any length, yaw: the same matrices as SciPy's."""
    rng = np.random.default_rng(seed)
    axis, angle, q = rng.normal(size=3), rng.uniform(-4.0, 4.0), rng.normal(size=4)
    made = RotationModel.model_validate({"axis": axis.tolist(), "angle": f"{angle!r} rad"})
    want = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    np.testing.assert_allclose(rotation_matrix(made), want, atol=1e-14)
    made = RotationModel.model_validate({"quaternion": (100.0 * q).tolist()})
    want = Rotation.from_quat(q, scalar_first=True).as_matrix()
    np.testing.assert_allclose(rotation_matrix(made), want, atol=1e-14)
    made = RotationModel.model_validate({"yaw": f"{angle!r} rad"})
    want = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    np.testing.assert_allclose(rotation_matrix(made), want, atol=1e-14)


def test_quarter_turns_are_exact() -> None:
    """A part turned from y up to z up has the numbers of its file, not others 1e-16 off."""
    made = RotationModel.model_validate({"axis": [1, 0, 0], "angle": "90 deg"})
    np.testing.assert_array_equal(rotation_matrix(made), [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
