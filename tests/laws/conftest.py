"""Scenarios changed as whole trees, and their optimal costs."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.planners.planner import Budget, SearchResult, Status
from gm_ompl.planners.registry import make_planner
from gm_ompl.scenario.scenario import Scenario

Tree = dict[str, Any]
Vector = list[float]

TURNED = {"+x": "+y", "+y": "-x", "-x": "-y", "-y": "+x"}


def _search(tree: Tree, planner: str = "astar") -> SearchResult:
    problem = Scenario.from_resolved(tree).problem
    judge = Judge(problem, make_backend(problem))
    return make_planner(planner).solve(problem, judge, Budget(), np.random.default_rng(0))


@pytest.fixture(scope="session")
def optimum() -> Callable[..., float]:
    """``optimum(tree)``: the optimal cost, +inf where there is no plan."""

    def solve(tree: Tree, planner: str = "astar") -> float:
        found = _search(tree, planner)
        if found.status is Status.INFEASIBLE:
            return math.inf
        assert found.optimal and found.cost is not None
        return found.cost

    return solve


def degrees(text: str) -> float:
    value, unit = text.split()
    return math.degrees(float(value)) if unit == "rad" else float(value)


def moved(tree: Tree, of: Callable[[float, float], tuple[float, float]], angle: float) -> Tree:
    """A scenario whose world is mapped by ``of`` (x, y), turned by ``angle`` [deg]."""
    new = copy.deepcopy(tree)
    (ox, oy) = of(0.0, 0.0)

    def at(v: Vector) -> Vector:
        return [*of(v[0], v[1]), v[2]]

    for obstacle in new["environment"]["obstacles"].values():
        ends = at(obstacle["box"]["min"]), at(obstacle["box"]["max"])
        obstacle["box"] = {"min": [min(p) for p in zip(*ends, strict=True)],
                           "max": [max(p) for p in zip(*ends, strict=True)]}  # fmt: skip
    motion = new["motion"]
    for key in ("start", "goal"):
        pose = motion.get(key)
        if pose is not None:
            pose["position"] = at(pose["position"])
            pose["yaw"] = f"{degrees(pose.get('yaw', '0 deg')) + angle} deg"
    for piece in motion.get("path", []):
        if "slide" in piece:
            x, y, z = piece["slide"]["by"]
            fx, fy = of(x, y)
            piece["slide"]["by"] = [fx - ox, fy - oy, z]
        else:
            for _ in range(round(angle / 90) % 4):
                piece["tumble"]["towards"] = TURNED[piece["tumble"]["towards"]]
    return new


@pytest.fixture(scope="session")
def change() -> dict[str, Callable[..., Tree]]:
    """The changes of a scenario that must not change its optimal cost."""
    return {
        "translation": lambda tree: moved(tree, lambda x, y: (x + 7.25, y - 3.5), 0.0),
        "quarter turn": lambda tree: moved(tree, lambda x, y: (-y, x), 90.0),
        "half turn": lambda tree: moved(tree, lambda x, y: (-x, -y), 180.0),
        "mirror": mirrored,
        "units": in_units,
        "renumbering": renumbered,
    }


def mirrored(tree: Tree) -> Tree:
    """The scenario seen in a mirror along x and z: y becomes -y."""
    new = moved(tree, lambda x, y: (x, -y), 0.0)
    for key in ("start", "goal"):
        if new["motion"].get(key):
            new["motion"][key]["yaw"] = f"{-degrees(new['motion'][key]['yaw'])} deg"
    swap = {"+y": "-y", "-y": "+y"}
    faces = new["fingers"]["placements"]["faces"]
    if faces != "all":
        new["fingers"]["placements"]["faces"] = [swap.get(face, face) for face in faces]
    planar = new["motion"].get("planar")
    if planar is not None:
        low, high = planar["y"]
        planar["y"] = [-high, -low]
        low, high = (degrees(value) for value in planar["yaw"])
        planar["yaw"] = [f"{-high} deg", f"{-low} deg"]
    return new


def in_units(tree: Tree, length: float = 0.025, mass: float = 40.0, time: float = 3.0) -> Tree:
    """The scenario with lengths, masses and times in other units; costs are lengths."""
    new, force = copy.deepcopy(tree), mass * length / time**2
    factors = {
        "box": length, "min": length, "max": length, "hull": length, "position": length,
        "by": length, "x": length, "y": length, "z": length, "translation": length,
        "radius": length, "soft": length, "regrasp": length,
        "clearance": length,
        "mass": mass, "gravity": length / time**2,
        "max_normal_force": force, "z_min": force, "stability": force,
    }  # fmt: skip

    def times(value: Any, factor: float) -> Any:
        if isinstance(value, list):
            return [times(part, factor) for part in value]
        return value * factor if isinstance(value, (int, float)) else value

    def walk(part: Any) -> Any:
        if not isinstance(part, dict):
            return [walk(item) for item in part] if isinstance(part, list) else part
        return {
            key: times(value, factors[key])
            if key in factors and not isinstance(value, dict)
            else walk(value)
            for key, value in part.items()
        }

    return dict(walk(new))


def renumbered(tree: Tree) -> Tree:
    """The scenario with its fingers listed the other way round."""
    new = copy.deepcopy(tree)
    fingers = new["fingers"]
    for holder, key in ((fingers, "radius"), (fingers, "max_normal_force"), (fingers, "soft"),
                        (fingers, "start"), (fingers, "goal"), (fingers, "clearance"),
                        (new["friction"], "finger")):  # fmt: skip
        if isinstance(holder[key], list):
            holder[key] = holder[key][::-1]
    return new
