"""Small scenes on an open floor, by chance, for tests of what bounds plans there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.separation import TOUCHING
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.problem import Problem
from tests.free_scenes import DEGREE, free_problem, steps

L_SHAPED: Final = {"pieces": [
    {"box": {"min": [0, 0, 0], "max": [1, 1, 0.5]}},
    {"box": {"min": [0, 0, 0.5], "max": [0.5, 1, 1]}},
]}  # fmt: skip
WEDGE: Final = {"hull": [
    [x, y, z] for x, z in ((-0.5, -0.5), (0.7, -0.5), (-0.5, 0.5)) for y in (-0.4, 0.4)
]}  # fmt: skip
SHAPES: Final = ({"box": [1, 1, 0.5]}, {"box": [0.6, 0.8, 1]}, L_SHAPED, WEDGE)
ANGLES: Final = (30.0, 40.0, 45.0, 90.0)
AXES: Final = ((0,), (1,), (0, 1), (0, 2), (2,), (0, 1, 2), ())
TURNS: Final = (None, None, None, ((0, 0, 1),), ((1, 0, 0), (0, 1, 0)), ((0, 1, 0),))


def standing(problem: Problem, rotation: Array) -> Pose:
    """The object on the floor, turned so."""
    turned = Pose(rotation, np.zeros(3))
    return Pose(rotation, np.array([0.0, 0.0, -turned.apply(problem.body.vertices)[:, 2].min()]))


def open_floor(seed: int) -> Problem:
    """A body on the floor with one or two fingers; a goal that a few steps may lead to."""
    rng = np.random.default_rng([seed, 71])
    ends, parts = bool(rng.random() < 0.4), int(rng.integers(1, 4))
    count = 1 if rng.random() < 0.15 else 2
    turns = TURNS[rng.integers(len(TURNS))]
    shape = SHAPES[rng.integers(len(SHAPES) if turns else 2)]  # else attitudes are too many
    by = steps(
        float(rng.choice([0.25, 0.4, 0.5])), float(rng.choice(ANGLES)),
        AXES[rng.integers(len(AXES))], turns,
    )  # fmt: skip
    fingers: dict[str, Any] = {
        "count": count, "radius": 0.05, "max_normal_force": float(rng.choice([10.0, 20.0, 40.0])),
        "placements": {"grid": [1, int(rng.integers(1, 3))], "faces": "all"},
    }  # fmt: skip
    if count == 2 and rng.random() < 0.4:
        fingers |= {"radius": [0.05, 0.08], "max_normal_force": [15.0, 30.0]}
    plain = free_problem(
        object={"shape": shape, "mass": 1},
        region=((-1.2, -1.2, 0), (1.2, 1.2, float(rng.choice([0.6, 3.0])))),
        by=by,
        fingers=fingers,
        friction={"environment": round(rng.uniform(0.2, 0.6), 3), "finger": 0.8},
        mechanics={"z_min": float(rng.choice([0.02, 0.2])),
                   "cone_edges": int(rng.choice([4, 6, 8]))},
        cost={"samples_per_arc": max(parts, 1 + ends), "samples_at": "ends" if ends else "middles",
              "regrasp": 100.0, "stability": float(rng.choice([0.0, 0.01, 1.0]))},
    )  # fmt: skip
    start = standing(plain, rotation_about(np.array([0.0, 0.0, 1.0]), rng.choice([0.0, 0.3])))
    return aimed(plain, start, rng, ends=ends)


def arcs_on_floor(problem: Problem, nodes: int) -> Iterator[tuple[int, GraphArc]]:
    """Arcs of the contact lattice from up to so many nodes, those that leave the floor left out."""
    graph, D, seen = problem.object_graph, problem.body.diagonal, [0]
    for tail in seen:
        for arc in graph.arcs_from(tail):
            low = graph.pose(arc.head).apply(problem.body.vertices)[:, 2].min()
            if arc.bare or low > TOUCHING * D:
                continue
            yield tail, arc
            if arc.head not in seen and len(seen) < nodes:
                seen.append(arc.head)


def aimed(problem: Problem, start: Pose, rng: np.random.Generator, *, ends: bool) -> Problem:
    """The problem from a start to a goal about a pose a few arcs away, of any kind."""
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    D = problem.body.diagonal
    none = PoseGoal(start.position, start.position, None, None, 1e-3 * D, 0.5 * DEGREE)
    begun = FreeMotion(start, none, motion.region, motion.steps)
    begun.ends = ends
    begun_problem = replace(problem, motion=begun)
    graph, node = begun_problem.object_graph, 0
    for _ in range(int(rng.integers(2, 5))):
        arcs = [arc for arc in graph.arcs_from(node) if not arc.bare]
        node = arcs[rng.integers(len(arcs))].head if arcs else node
    end, kind = graph.pose(node), int(rng.integers(4))
    distance, angle = (1e-3 * D, 0.5 * DEGREE) if rng.random() < 0.6 else (0.1, 20.0 * DEGREE)
    size = rng.choice([0.0, 0.0, 0.2]) * rng.random(3)
    up = end.rotation.T[:, 2] if kind == 1 else None
    rotation = end.rotation if kind > 1 else None
    goal = PoseGoal(end.position - size, end.position + size, rotation, up, distance, angle)
    there = FreeMotion(start, goal, motion.region, motion.steps)
    there.ends = ends
    return replace(begun_problem, motion=there)
