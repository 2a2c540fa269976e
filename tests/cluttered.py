"""Random cluttered scenes, and a sampling planner for one fingertip, as a second opinion."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

import gm_ompl
from gm_ompl.arrays import Array
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.geometry.pose import Pose
from gm_ompl.plain.air import Air
from gm_ompl.problem import Problem


def cluttered(rng: np.random.Generator, **fingers: Any) -> dict[str, Any]:
    """Return a scenario: a cuboid in a shaft whose walls and mouth leave gaps of all widths."""
    size = rng.uniform(0.6, 1.4, size=3)
    radius = float(rng.uniform(0.08, 0.16))
    wide = size / 2.0 + rng.uniform(1.8, 3.2, size=3) * radius
    mouth = size / 2.0 + rng.uniform(0.4, 2.4, size=3) * radius
    out, top = wide + 4.0 * radius, float(size[2]) + float(rng.uniform(0.0, 1.5)) * radius
    boxes: dict[str, tuple[list[float], list[float]]] = {}
    for name, inner, low, high in (
        ("wall", wide, 0.0, top), ("lid", mouth, top, top + radius),
    ):  # fmt: skip
        x, y = float(inner[0]), float(inner[1])
        X, Y = float(out[0]), float(out[1])
        boxes[f"{name} west"] = [-X, -Y, low], [-x, Y, high]
        boxes[f"{name} east"] = [x, -Y, low], [X, Y, high]
        boxes[f"{name} south"] = [-x, -Y, low], [x, -y, high]
        boxes[f"{name} north"] = [-x, y, low], [x, Y, high]
    for name in rng.permutation(sorted(boxes))[: int(rng.choice([0, 0, 0, 1]))].tolist():
        del boxes[name]
    obstacles = {name: {"box": {"min": a, "max": b}} for name, (a, b) in boxes.items()}
    return {
        "object": {"shape": {"box": size.tolist()}, "mass": 1},
        "friction": {"environment": 0.5, "finger": 0.7},
        "fingers": {
            "count": 2, "radius": radius, "max_normal_force": 20,
            "placements": {"grid": [2, 2]}, **fingers,
        },
        "environment": {"obstacles": obstacles},
        "motion": {
            "start": {"position": [0, 0, float(size[2]) / 2.0]},
            "path": [{"slide": {"by": [0.001, 0, 0]}}],
        },
        "lattice": {"segments": 1},
    }  # fmt: skip


def shaft(rng: np.random.Generator) -> dict[str, Any]:
    """Return a scenario: the cuboid is slid up out of its shaft, by as many fingers as it takes."""
    tree = cluttered(rng)
    height, radius = tree["object"]["shape"]["box"][2], tree["fingers"]["radius"]
    names = [name for name in tree["environment"]["obstacles"] if name.startswith("wall")]
    walls = {name: tree["environment"]["obstacles"][name] for name in names}
    fingers = {**tree["fingers"], "count": 3, "placements": {"grid": [3, 3]}}
    motion = {**tree["motion"], "path": [{"slide": {"by": [0, 0, height + 2.0 * radius]}}]}
    return {
        **tree, "fingers": fingers, "motion": motion, "lattice": {"segments": 8},
        "environment": {"obstacles": walls}, "mechanics": {"z_min": 0.02},
        "cost": {"regrasp": 0.2, "stability": 0.01},
    }  # fmt: skip


def judged(tree: dict[str, Any]) -> tuple[Judge, Pose]:
    """Return a scenario's judge and the start's pose."""
    problem = gm_ompl.load(tree).problem
    return Judge(problem, make_backend(problem)), problem.motion.pose(problem.start)


def wider(problem: Problem) -> Problem:
    """Return the problem with fingertips as wide as the narrowest gap that must count."""
    hand = problem.fingers
    wide = dataclasses.replace(hand, radius=hand.radius + hand.clearance / 2.0)
    return dataclasses.replace(problem, fingers=wide)


def sampled_out(air: Air, row: int, rng: np.random.Generator, samples: int) -> bool:
    """Whether a random tree finds a way from a placement to far away; each stretch is swept."""
    table = air.problem.fingers.placements
    start = table.points[row] - (1.0 + 1e-9) * air.radius * table.normals[row]
    reach = float(np.abs(air.problem.body.vertices).max()) + 12.0 * air.radius
    nodes = new = start[None]
    while samples > 0:
        if air.clear(new, new + air.far * air.up).any():
            return True
        batch = min(max(len(nodes), 100), 2000)  # more at once as the tree grows
        samples -= batch
        aims = rng.uniform(-reach, reach, size=(batch, 3))
        tails = nodes[cKDTree(nodes).query(aims)[1]]
        steps = aims - tails
        length = np.linalg.norm(steps, axis=1, keepdims=True)
        longest = rng.uniform(0.5, 6.0, size=(batch, 1)) * air.radius
        heads = tails + steps * np.minimum(1.0, longest / length)
        new = heads[air.clear(tails, heads)]
        nodes = np.concatenate([nodes, new])
    return False


def way_is_clear(air: Air, way: Array, pieces: tuple[int, int]) -> list[str]:
    """Return what the stretches of a way (k, 3), world frame, meet, by the reference's test."""
    corners = air.pose.to_object(way)
    last = len(corners) - 2
    touched = {0: pieces[0], last: pieces[1]}
    met = [
        air.blocked(corners[k : k + 1], corners[k + 1 : k + 2], touched.get(k))[0]
        for k in range(last + 1)
    ]
    return [what for what in met if what]
