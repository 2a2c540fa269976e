"""Hybrid setups of a path and of a planar motion, and states for them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.ompl.setup import HybridSetup
from gm_ompl.scenario.load import load

SMALL = ["fingers.placements.grid=[2, 1]", "lattice.segments=3"]
TURN = ["fingers.placements.grid=[2, 2]"]


def _make(name: str, seed: int = 0) -> HybridSetup:
    problem = load(name, TURN if name.startswith("planar") else SMALL).problem
    return HybridSetup(Judge(problem, make_backend(problem)), np.random.default_rng(seed))


@pytest.fixture(scope="session")
def make_hybrid() -> Callable[..., HybridSetup]:
    """``make_hybrid(name, seed)``: a small version of a shipped scenario."""
    return _make
