"""Scenarios with a prescribed motion, written as free motion that leaves nothing else to do."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np

from gm_ompl.errors import ScenarioError
from gm_ompl.geometry.pose import Pose
from gm_ompl.scenario.load import load
from gm_ompl.scenario.scenario import Scenario

Tree = dict[str, Any]

ROOM = 1.01
"""How much higher than it must be a region is."""


def one_piece(seed: int) -> Tree | None:
    """A small random path of one slide along +x or one tumble towards +x; None: it has two."""
    tree: Tree = load(f"random/small/{seed}").resolved()
    return tree if len(tree["motion"]["path"]) == 1 else None


def free_path(tree: Tree) -> Tree:
    """The scenario of ``one_piece`` as free motion whose region and axes leave that path alone.

    A slide has its axis, and does not turn. A tumble may turn about lines along y; the only axis
    listed is y, in which the region is flat; along x, where the rims of its faces would let it
    slide, a step leads out of the region, and so do tumbles over other edges and farther ones.
    """
    new = copy.deepcopy(tree)
    (piece,), (count,) = tree["motion"]["path"], tree["lattice"]["segments"]
    start = tree["motion"]["start"]
    x, y, z = start["position"]
    if "slide" in piece:
        by = piece["slide"]["by"][0]
        region = {"x": [x, x + by], "y": [y, y], "z": [z, z]}
        ways = {"region": region, "translate": ["x"], "rotate": []}
        goal: Tree = {"position": [x + by, y, z], "yaw": "0 deg"}
        steps = {"translation": by / count, "rotation": "90 deg"}
    else:
        angle = float(piece["tumble"]["angle"].split()[0])
        a, _, c = tree["object"]["shape"]["box"]
        pose = Pose(np.eye(3), np.array([x, y, z])).turned([x + a / 2, y, 0], [0, 1, 0], angle)
        high = ROOM * math.hypot(a, c) / 2
        region = {"x": [x, float(pose.position[0])], "y": [y, y], "z": [0, high]}
        ways = {"region": region, "translate": ["y"], "rotate": ["y"]}
        turn = {"axis": [0, 1, 0], "angle": f"{angle!r} rad"}
        goal = {"position": pose.position.tolist(), "rotation": turn}
        steps = {"translation": 2 * (a + c), "rotation": f"{angle / count!r} rad"}
    new["motion"] = {"start": start, "goal": goal, "free": ways}
    new["lattice"] = {"steps": steps}
    return new


def small_plane(seed: int) -> Tree | None:
    """A small random planar scenario, a few steps each way, its yaw a full turn.

    None: a wall stands where the object must begin or end.
    """
    tree: Tree = load(f"random/planar/{seed}").resolved()
    placements, motion = tree["fingers"]["placements"], tree["motion"]
    placements["grid"] = [2, 1]
    placements["faces"] = ["-x", "+x", "-y"]
    tree["fingers"]["count"] = min(2, tree["fingers"]["count"])
    for key in ("radius", "max_normal_force", "soft", "clearance", "start", "goal"):
        tree["fingers"][key] = tree["fingers"][key][: tree["fingers"]["count"]]
    friction = tree["friction"]
    if isinstance(friction["finger"], list):
        friction["finger"] = friction["finger"][: tree["fingers"]["count"]]
    step, turn = tree["lattice"]["steps"]["x"], math.radians(45.0)
    rng = np.random.default_rng(seed)
    ways = [int(rng.integers(0, 3)), int(rng.integers(0, 2)), int(rng.integers(-2, 3))]
    ways[0] += not any(ways)
    x, y, z = motion["start"]["position"]
    motion["planar"] = {
        "x": [x - step, x + 2 * step], "y": [y, y + step],
        "yaw": [f"{-math.pi!r} rad", f"{math.pi!r} rad"],
    }  # fmt: skip
    motion["goal"] = {
        "position": [x + ways[0] * step, y + ways[1] * step, z],
        "yaw": f"{ways[2] * turn!r} rad",
    }
    tree["lattice"] = {"steps": {"x": step, "y": step, "yaw": f"{turn!r} rad"}}
    tree["cost"]["samples_per_arc"] = 1
    try:
        Scenario.from_resolved(tree)
    except ScenarioError:
        return None
    return tree


def free_plane(tree: Tree) -> Tree:
    """The scenario of ``small_plane`` as free motion that stays in the plane.

    Equal steps along x and y, a start on the lattice, a yaw that goes all round: then each arc of
    the planar lattice is one of the contact lattice, which turns about the line through the centre
    of mass. Walls only add arcs that end at them, and turns about the edges that touch them.
    """
    new = copy.deepcopy(tree)
    motion, steps = tree["motion"], tree["lattice"]["steps"]
    z = motion["start"]["position"][2]
    planar = motion["planar"]
    region = {"x": planar["x"], "y": planar["y"], "z": [z, z]}
    ways = {"region": region, "translate": ["x", "y"], "rotate": ["z"]}
    new["motion"] = {"start": motion["start"], "goal": motion["goal"], "free": ways}
    new["lattice"] = {"steps": {"translation": steps["x"], "rotation": steps["yaw"]}}
    return new
