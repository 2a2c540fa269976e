"""Plans to execute, and plans made wrong on purpose."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from gm_ompl import api
from gm_ompl.planfile.model import Plan

Tamper = Callable[[dict[str, Any]], None]


@pytest.fixture(scope="session")
def cork_plan() -> Plan:
    """The paper's experiment: a cork box, tumbled by pinching."""
    return api.plan("paper/cork")


@pytest.fixture(scope="session")
def slide_plan() -> Plan:
    """A short slide: one finger pushes, one presses."""
    way = "motion.path=[{slide: {by: [2, 0, 0]}}]"
    overrides = ["lattice.segments=3", "fingers.placements.grid=[3, 3]", way]
    return api.plan(api.load("paper/slide", overrides))


@pytest.fixture(scope="session")
def regrasp_plan() -> Plan:
    """The paper's tumble past two walls, with a regrasp."""
    return api.plan("paper/regrasp")


@pytest.fixture(scope="session")
def tampered() -> Callable[[Plan, Tamper], Plan]:
    """Return a plan after a change to its plain values."""

    def change(plan: Plan, tamper: Tamper) -> Plan:
        draft = json.loads(json.dumps(plan.to_dict()))
        tamper(draft)
        return Plan.model_validate_json(json.dumps(draft))

    return change
