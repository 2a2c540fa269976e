"""The floor graph has every attitude that the contact lattice comes to, and every rotation."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from gm_ompl.geometry.pose import rotation_about
from gm_ompl.graph.floor_graph import floor_graph, looks, nearest, on_open_floor
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.problem import Problem
from tests.free_scenes import DEGREE, box_between, free_problem, steps
from tests.goals_near import towards
from tests.graph.floor_scenes import arcs_on_floor, open_floor, standing

NODES = 250
SEEDS = range(16)
TWO: dict[str, Any] = {
    "count": 2, "radius": 0.05, "max_normal_force": 20,
    "placements": {"grid": [1, 1], "faces": "all"},
}  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_every_rotation_of_the_lattice_is_in_it(seed: int) -> None:
    """Wherever on the floor it begins, and whether it was under way."""
    problem = open_floor(seed)
    graph, lattice, D = floor_graph(problem), problem.object_graph, problem.body.diagonal
    assert graph is not None
    arcs = set(zip(graph.tails.tolist(), graph.heads.tolist(), strict=True))
    for tail, arc in arcs_on_floor(problem, NODES):
        poses = [lattice.pose(node) for node in (tail, arc.head)]
        R = np.array([pose.rotation for pose in poses])
        p = np.array([pose.position for pose in poses])
        here, there = nearest(graph.looks, looks(R, p, D)).tolist()
        assert min(here, there) >= 0
        assert here == there or (here, there) in arcs
        assert graph.arrived[there] or not lattice.in_goal(arc.head)


def _cube(**settings: Any) -> Problem:
    given: dict[str, Any] = {"fingers": TWO, "by": steps(rotate=None), **settings}
    return free_problem(**given)


def test_what_is_an_open_floor() -> None:
    """Obstacles, hands that lift, wide tolerances and starts in the air or on a point are not."""
    assert on_open_floor(_cube())
    assert not on_open_floor(_cube(obstacles={"block": box_between([3, 3, 0], [4, 4, 1])}))
    assert not on_open_floor(_cube(fingers=TWO | {"count": 3}))
    assert not on_open_floor(_cube(mechanics={"z_min": 0.0}))
    assert not on_open_floor(_cube(start=(0, 0, 0.7)))
    assert not on_open_floor(_cube(mechanics={"contact_tolerance": 1e-3}))


def _on_a_corner() -> Problem:
    """A cube that stands on a corner, a little nearer to one edge."""
    cube = _cube(by=steps(0.5, 30.0, (0, 1), ((1, 0, 0),)))
    down = rotation_about([1.0, 0.0, 0.0], 20 * DEGREE) @ rotation_about([0.0, 1.0, 0.0], 0.5)
    start, motion = standing(cube, down), cube.motion
    assert isinstance(motion, FreeMotion)
    goal = PoseGoal(start.position, start.position, None, None, 1e-3, 0.1)
    begun = FreeMotion(start, goal, np.array([[-1, -1, 0], [1, 1, 3]]), motion.steps)
    return dataclasses.replace(cube, motion=begun)


def test_a_start_on_a_point_is_left_to_others() -> None:
    """There a rotation may go on about a line that is no contact line any more."""
    problem = _on_a_corner()
    assert not on_open_floor(problem)
    graph, lattice = floor_graph(problem), problem.object_graph
    assert graph is not None
    heads = np.array([arc.head for _, arc in arcs_on_floor(problem, NODES)])
    R, p = lattice.poses(heads)  # type: ignore[attr-defined]
    assert (nearest(graph.looks, looks(R, p, problem.body.diagonal)) < 0).any()


def test_short_arcs_are_divided_as_on_the_lattice() -> None:
    """They have two segments at least where these are judged at their ends."""
    costs = {"samples_per_arc": 2}
    problem = _cube(by=steps(rotation=40.0, rotate=None), cost=costs)
    for ends in (False, True):
        problem.motion.ends = ends
        graph = floor_graph(problem)
        assert graph is not None
        assert graph.courses.parts.min() == (2 if ends else 1)


def test_attitudes_at_the_edge_of_the_goal_count() -> None:
    """Those that rounding alone keeps out of it arrive: poses near them may do so."""
    problem = _cube(by=steps(rotation=45.0, rotate=None))
    place = np.array([0.0, 0.0, 0.5])
    for off in (-1e-9, 1e-9):
        angle = 45.0 * DEGREE + off
        goal = PoseGoal(place, place, np.eye(3), None, 1e-3, angle)
        graph = floor_graph(towards(problem, goal))
        assert graph is not None
        turns = np.abs(graph.looks[:, 9] * problem.body.diagonal - 0.5) < 1e-6
        upright = turns & (np.abs(graph.looks[:, 8] - 1.0) < 1e-6)
        assert graph.arrived[upright].sum() == 3
