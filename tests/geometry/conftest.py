"""Random shapes for the geometry tests."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import ConvexPiece, hull


@pytest.fixture(scope="session")
def random_hull() -> Callable[[np.random.Generator, float], ConvexPiece]:
    """Return a maker of hulls of 8 to 30 points of about the given size."""

    def make(rng: np.random.Generator, size: float) -> ConvexPiece:
        return hull(rng.normal(size=(int(rng.integers(8, 30)), 3)) * size)

    return make


@pytest.fixture(scope="session")
def random_pose() -> Callable[[np.random.Generator, float], Pose]:
    """Return a maker of poses at any orientation, positions of about the given size."""

    def make(rng: np.random.Generator, size: float) -> Pose:
        return Pose.from_quaternion(rng.normal(size=3) * size, rng.normal(size=4))

    return make
