"""A small plan made of plain values; what it claims need not be right."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from gm_ompl.planfile.model import Plan

POSE = {"position": [0.0, 0.0, 2.5], "quaternion": [1.0, 0.0, 0.0, 0.0]}
TOP = {"face": "+z", "cell": [1, 2], "point": [0.1, 0.2, 2.5], "normal": [0.0, 0.0, -1.0]}
BACK = {"face": "-x", "cell": [0, 0], "point": [-2.5, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
SEGMENT = {"modes": ["force", "position"], "f_com": [3.25, None], "z": 1.0 / 3.0}


def plain_plan() -> dict[str, Any]:
    """Return a plan with one step of each kind, as the file holds it."""
    return {
        "format": "gm-ompl-plan/2",
        "status": "solved",
        "planner": "astar",
        "seed": 3,
        "parameters": {"weight": 1.5, "names": ["a", "b"]},
        "optimal": True,
        "cost": 101.5,
        "lower_bound": 101.5,
        "regrasps": 1,
        "scenario": {"name": "test", "fingers": {"radius": [1, 0.1]}, "note": "Käfig"},
        "statistics": {
            "time_s": 0.25,
            "expanded": 12,
            "mode_decisions": 34,
            "history": [[0.1, None, 3.0], [0.2, 101.5, 101.5]],
            "peak_memory_mb": 99,
        },
        "steps": [
            {
                "kind": "displacement",
                "from": [0.0],
                "to": [0.1],
                "arc": {"translation": [1.0, 0.0, 0.0]},
                "pose_from": POSE,
                "pose_to": POSE,
                "placements": [TOP, BACK],
                "segments": [SEGMENT, SEGMENT],
                "cost": 1.5,
            },
            {
                "kind": "regrasp",
                "at": [0.1],
                "finger": 1,
                "from": BACK,
                "to": TOP,
                "way": None,
                "placements": [TOP, BACK],
                "modes": ["force", None],
                "f_com": [-0.0, None],
                "z": 1e-17,
                "cost": 100.0,
            },
        ],
    }


@pytest.fixture
def document() -> dict[str, Any]:
    """The plan as plain values, free to change."""
    return copy.deepcopy(plain_plan())


@pytest.fixture
def plan() -> Plan:
    """The plan as a value."""
    return Plan.model_validate_json(json.dumps(plain_plan()))
