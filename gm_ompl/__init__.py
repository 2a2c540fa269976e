"""Planning of graspless manipulation by multifingered robot hands.

Public names load on first use (PEP 562): ``import gm_ompl`` alone imports no library. No package
inside has the name of a public function: importing it would take the function's place.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from gm_ompl.api import check, explain, load, plan, strong, tolerate
    from gm_ompl.errors import (
        GeometryError,
        GmOmplError,
        HandError,
        InputError,
        LimitError,
        MisfitError,
        MissingExtraError,
        PathError,
        PlanError,
        ScenarioError,
        ScenarioWarning,
        ShapeError,
        SolverError,
        UnknownPlannerError,
        UnsoundPlannerError,
    )
    from gm_ompl.geometry.pose import Pose, Twist
    from gm_ompl.instants import judge, placement_map
    from gm_ompl.planfile.model import Plan
    from gm_ompl.planners.ompl.public import plan_from, setup
    from gm_ompl.scenario.scenario import Scenario

_HOMES = {
    "GeometryError": "gm_ompl.errors",
    "GmOmplError": "gm_ompl.errors",
    "HandError": "gm_ompl.errors",
    "InputError": "gm_ompl.errors",
    "LimitError": "gm_ompl.errors",
    "MisfitError": "gm_ompl.errors",
    "MissingExtraError": "gm_ompl.errors",
    "PathError": "gm_ompl.errors",
    "Plan": "gm_ompl.planfile.model",
    "PlanError": "gm_ompl.errors",
    "Pose": "gm_ompl.geometry.pose",
    "Scenario": "gm_ompl.scenario.scenario",
    "ScenarioError": "gm_ompl.errors",
    "ScenarioWarning": "gm_ompl.errors",
    "ShapeError": "gm_ompl.errors",
    "SolverError": "gm_ompl.errors",
    "Twist": "gm_ompl.geometry.pose",
    "UnknownPlannerError": "gm_ompl.errors",
    "UnsoundPlannerError": "gm_ompl.errors",
    "check": "gm_ompl.api",
    "explain": "gm_ompl.api",
    "judge": "gm_ompl.instants",
    "load": "gm_ompl.api",
    "placement_map": "gm_ompl.instants",
    "plan": "gm_ompl.api",
    "plan_from": "gm_ompl.planners.ompl.public",
    "setup": "gm_ompl.planners.ompl.public",
    "strong": "gm_ompl.api",
    "tolerate": "gm_ompl.api",
}

__all__ = [
    "GeometryError",
    "GmOmplError",
    "HandError",
    "InputError",
    "LimitError",
    "MisfitError",
    "MissingExtraError",
    "PathError",
    "Plan",
    "PlanError",
    "Pose",
    "Scenario",
    "ScenarioError",
    "ScenarioWarning",
    "ShapeError",
    "SolverError",
    "Twist",
    "UnknownPlannerError",
    "UnsoundPlannerError",
    "__version__",
    "check",
    "explain",
    "judge",
    "load",
    "placement_map",
    "plan",
    "plan_from",
    "setup",
    "strong",
    "tolerate",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        value: Any = importlib.import_module("importlib.metadata").version("gm-ompl")
    elif name in _HOMES:
        value = getattr(importlib.import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
