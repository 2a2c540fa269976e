"""Compiled code that looks at types once: its callers give it the same types each time."""

from __future__ import annotations

import numpy as np
import pytest

import gm_ompl
from gm_ompl import compilation
from gm_ompl.direct import Types, direct

SCENARIOS = (
    "paper/regrasp", "paper/tumble", "fingers/three", "planar/corner", "random/small/3",
    "random/planar/5", "random/chain/2", "tasks/reorient",
)  # fmt: skip


@pytest.fixture(autouse=True)
def looking(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have types looked at in every call."""
    monkeypatch.setattr(Types, "looked_at", True)


def _double(values: np.ndarray) -> float:
    return 2.0 * float(values.sum())


def test_other_types_are_told_where_they_are_looked_at() -> None:
    """An array of whole numbers would be misread as one of numbers."""
    double = direct(compilation.compiled(_double))
    assert double(np.ones(3)) == 6.0
    assert double(np.arange(3.0)) == 6.0
    for other in (np.arange(3), np.ones((2, 2)), np.ones(6)[::2]):
        with pytest.raises(TypeError, match="_double was given"):
            double(other)


def test_types_are_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nobody asks for more, the second call goes straight to the machine code."""
    monkeypatch.setattr(Types, "looked_at", False)
    double = direct(compilation.compiled(_double))
    assert double(np.ones(3)) == 6.0
    monkeypatch.setattr(compilation, "numba_module", lambda: pytest.fail("looked at again"))
    assert double(np.ones(4)) == 8.0


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("planner", ["astar", "HybridRRTConnect", "HybridRRTstar"])
def test_searches_keep_to_their_types(name: str, planner: str) -> None:
    """Lanes, hubs, routes, cuts and decisions, on paths, in the plane and in space."""
    gm_ompl.plan(gm_ompl.load(name), planner, max_iterations=60, time_limit=20.0)
