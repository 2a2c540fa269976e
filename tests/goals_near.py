"""Goals of free motion near things, random ones for tests, and how objects arrive at them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.motion.object_graph import GraphArc
from gm_ompl.plain.contact_lattice import PlainContactLattice
from gm_ompl.problem import Problem
from tests.free_scenes import box_between, free_problem, steps

NODES: Final = 40
"""Of a lattice that is looked at."""

TURNS = ((), ((0, 1, 0),), ((0, 0, 1),), ((1, 0, 0), (0, 0, 1)), None)
AXES = ((2,), (0, 2), (1, 2), (0, 1, 2))

SHAPES = (
    {"box": [1, 1, 0.5]},
    {"box": [0.5, 1, 1]},
    {"pieces": [{"box": {"min": [0, 0, 0], "max": [1, 1, 0.4]}},
                {"box": {"min": [0, 0, 0.4], "max": [0.4, 1, 1]}}]},
)  # fmt: skip


def turn(rng: np.random.Generator, angle: float) -> Array:
    """A rotation by an angle about any axis."""
    axis = rng.normal(size=3)
    return rotation_about(axis / np.linalg.norm(axis), angle)


def open_air(seed: int) -> Problem:
    """A body over the floor, a block beside it, its motion of any kind; its goal is not asked."""
    rng = np.random.default_rng(seed)
    shape, parts = SHAPES[rng.integers(len(SHAPES))], int(rng.integers(1, 4))
    ends = bool(rng.random() < 0.4)
    problem = free_problem(
        obstacles={"block": box_between([0.9, -1, 0], [2, 1, rng.choice([0.5, 1.0])])},
        start=(0, 0, rng.choice([0.6, 1.0, 1.5])),
        region=((-1, -1, 0), (1, 1, 3)),
        by=steps(
            float(rng.choice([0.1, 0.25, 0.5])), float(rng.choice([5.0, 20.0, 60.0])),
            AXES[rng.integers(len(AXES))], TURNS[rng.integers(len(TURNS))],
        ),
        object={"shape": shape, "mass": 1},
        fingers={"count": 3, "radius": 0.05, "max_normal_force": rng.choice([5.0, 15.0, 20.0]),
                 "placements": {"grid": [2, 1], "faces": "all"}},
        mechanics={"z_min": 0.3},
        cost={"samples_per_arc": max(parts, 1 + ends), "samples_at": "ends" if ends else "middles"},
    )  # fmt: skip
    problem.motion.ends = ends
    return problem


@cache
def arriving_at(seed: int) -> tuple[Problem, list[GraphArc]]:
    """A problem whose goal is about a pose of the lattice, and the arcs that lead to goals."""
    rng, problem = np.random.default_rng(100 + seed), open_air(seed)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    lattice, found = PlainContactLattice(problem, motion), list[GraphArc]()
    nodes, node = 1, 0
    while node < min(nodes, NODES):
        found += lattice.arcs_from(node)
        nodes, node = max([nodes, *(arc.head + 1 for arc in found)]), node + 1
    chosen = lattice.pose(found[rng.integers(len(found))].head)
    distance, angle = rng.choice([1e-3, 0.05]), rng.choice([0.01, 0.2])
    size = rng.choice([0.0, 0.0, 0.1]) * rng.random(3)
    place = chosen.position + rng.uniform(-0.5, 0.5, 3) * distance
    turned = turn(rng, rng.random() * angle) @ chosen.rotation
    goal = PoseGoal(place - size, place + size, turned, None, distance, angle)
    arriving = [arc for arc in found if goal.contains(lattice.pose(arc.head))]
    return towards(problem, goal), arriving


def towards(problem: Problem, goal: PoseGoal) -> Problem:
    """The problem with another goal."""
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    there = FreeMotion(motion.start, goal, motion.region, motion.steps)
    there.ends = motion.ends
    return replace(problem, motion=there)


def near_things(seed: int, height: float) -> Problem:
    """A goal so high over the floor, beside the block; off the family of rotations or in it."""
    rng, problem = np.random.default_rng(300 + seed), open_air(seed)
    motion = problem.motion
    assert isinstance(motion, FreeMotion)
    rotate, rotation = motion.steps.rotate, turn(rng, rng.random() * np.pi)
    if rotate is not None and len(rotate) < 2:
        rotation = np.eye(3)
        for axis in rotate:
            rotation = turn(rng, 0.1 * rng.random()) @ rotation_about(axis, rng.uniform(-3, 3))
    distance, angle = rng.choice([1e-3, 0.05, 0.3]), rng.choice([0.12, 0.3])
    place = np.array([rng.uniform(-1.0, 0.3), 0.0, height])
    size = rng.choice([0.0, 0.0, 0.1]) * rng.random(3)
    return towards(problem, PoseGoal(place, place + size, rotation, None, distance, angle))


def arrivals(problem: Problem, rng: np.random.Generator) -> Iterator[Pose]:
    """Poses half a segment before one in the goal: after a slide, or a turn about a corner."""
    motion, parts = problem.motion, problem.cost.samples_per_arc
    assert isinstance(motion, FreeMotion)
    goal, by, half = motion.goal, motion.steps, 1.0 / (2 * parts)
    assert goal.rotation is not None
    for _ in range(40):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        rotation = (
            rotation_about(axis, rng.choice([1.0, rng.random()]) * goal.angle) @ goal.rotation
        )
        turns = by.rotate is None or len(by.rotate) > 0
        if by.rotate is not None and len(by.rotate) == 1:
            (axis,) = by.rotate
            seen = rotation @ motion.start.rotation.T
            rotation = rotation_about(axis, _angle_about(axis, seen)) @ motion.start.rotation
        elif by.rotate is not None and turns:
            axis = by.rotate[rng.integers(len(by.rotate))]
        elif not turns:
            rotation = motion.start.rotation
        way = rng.normal(size=3)
        way *= goal.distance * rng.choice([rng.random(), 1.0 - 1e-9]) / np.linalg.norm(way)
        end = Pose(rotation, rng.choice([0.0, 1.0], 3) * (goal.high - goal.low) + goal.low + way)
        if not goal.contains(end):
            continue
        corner = end.apply(problem.body.vertices)[rng.integers(len(problem.body.vertices))]
        before = end.turned(corner, axis, rng.choice([-1.0, 1.0]) * half * by.rotation)
        if not turns or rng.random() < 0.3:
            slide = rng.choice([-1.0, 1.0]) * half * by.translation * np.eye(3)[rng.integers(3)]
            before = Pose(end.rotation, end.position + slide)
        if (
            np.abs(before.position - motion.region.mean(axis=0))
            <= np.ptp(motion.region, axis=0) / 2
        ).all():
            yield before


def _angle_about(axis: Array, turn: Array) -> float:
    """By how much a rotation (3, 3) turns about an axis."""
    aside = np.cross(axis, np.roll(axis, 1))
    aside /= np.linalg.norm(aside)
    there = turn @ aside
    return float(np.arctan2(there @ np.cross(axis, aside), there @ aside))
