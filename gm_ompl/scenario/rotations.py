"""Rotations as a scenario writes them: axis and angle, quaternion, or yaw."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from gm_ompl.arrays import Array
from gm_ompl.scenario.fields import Angle, Number, Strict, Vector

Quaternion: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=4, max_length=4)]

EXAMPLE = "{axis: [0, 0, 1], angle: 90 deg}, {quaternion: [1, 0, 0, 0]} or {yaw: 30 deg}"


class RotationModel(Strict):
    """A rotation: ``axis`` and ``angle``, or ``quaternion`` (w, x, y, z), or ``yaw``."""

    axis: Vector | None = None
    angle: Angle | None = None
    quaternion: Quaternion | None = Field(None, description="w, x, y, z; of any length but 0")
    yaw: Angle | None = Field(None, description="about z")

    @model_validator(mode="after")
    def _one_way(self) -> RotationModel:
        """Refuse none or several of the ways to write a rotation, and lengths of 0."""
        given = {key for key in type(self).model_fields if getattr(self, key) is not None}
        if given not in ({"axis", "angle"}, {"quaternion"}, {"yaw"}):
            raise PydanticCustomError("rotation", f"must be one of {EXAMPLE}")
        if not any(self.axis or self.quaternion or (1.0,)):
            raise PydanticCustomError("rotation", "an axis or quaternion must not be all zeros")
        return self


def rotation_matrix(rotation: RotationModel) -> Array:
    """Return the rotation as a matrix (3, 3); quarter turns about the axes are exact."""
    if rotation.quaternion is not None:
        w, *v = np.array(rotation.quaternion) / np.abs(rotation.quaternion).max()
        vector = np.array(v)
    else:
        if rotation.yaw is not None:
            axis, angle = np.array([0.0, 0.0, 1.0]), rotation.yaw
        else:
            assert rotation.axis is not None
            assert rotation.angle is not None
            axis = np.array(rotation.axis) / np.abs(rotation.axis).max()
            angle = rotation.angle
        w = np.cos(angle / 2)
        vector = np.sin(angle / 2) * axis / np.linalg.norm(axis)
    length = np.hypot(w, np.linalg.norm(vector))
    w, (x, y, z) = w / length, vector / length
    matrix = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    whole = np.round(matrix)
    exact: Array = np.where(np.abs(matrix - whole) < 1e-15, whole, matrix) + 0.0
    return exact
