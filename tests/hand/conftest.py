"""Plans by a robot hand, made once."""

from __future__ import annotations

import copy
from typing import Any

import pytest

import gm_ompl
from gm_ompl.planfile.model import Plan
from gm_ompl.scenario.load import read
from gm_ompl.scenario.scenario import Scenario

pytest.importorskip("mujoco")
pytest.importorskip("pinocchio")


@pytest.fixture(scope="session")
def push() -> Scenario:
    return gm_ompl.load("robot/trifinger-push")


@pytest.fixture(scope="session")
def pushed(push: Scenario) -> Plan:
    """A plan that pushes and turns the cube."""
    return gm_ompl.plan(push, "HybridRRTConnect", seed=1)


@pytest.fixture
def tree() -> dict[str, Any]:
    """The scenario's keys and values, free to change."""
    found = read("robot/trifinger-push").tree
    assert isinstance(found, dict)
    return copy.deepcopy(found)
