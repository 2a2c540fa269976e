from __future__ import annotations

import math

import numpy as np

from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.problem import Problem
from tests.free_scenes import ACROSS, DEGREE, box_between, free_problem, hull_of, lattice_of, steps
from tests.lattices import differences


def found(problem: Problem, nodes: int) -> list[str]:
    """How the planner's lattice differs from the reference's, so many nodes long."""
    reference = lattice_of(problem)
    return list(differences(problem.object_graph, reference, problem.body.diagonal, nodes))


def test_any_rotation_among_obstacles() -> None:
    """A wall, a ledge and a beam, slides along three axes and turns about any line."""
    obstacles = {
        "wall": box_between([1.3, -5, 0], [2, 5, 3]),
        "ledge": box_between([-3, -5, 0], [-0.75, 5, 0.3]),
        "beam": box_between([-0.3, 0.9, 0], [0.2, 1.4, 0.4]),
    }
    by = steps(0.4, 40.0, (0, 1, 2), None)
    problem = free_problem(obstacles=obstacles, region=((-2, -2, 0), (2, 2, 3)), by=by)
    assert found(problem, 8) == []


def test_on_a_slope() -> None:
    """Up and down a slope of 30 deg, over its foot and its top."""
    slope = hull_of([(0, y, 0) for y in (-5, 5)] + [(4, y, 0) for y in (-5, 5)]
                    + [(4, y, 4 * math.tan(30 * DEGREE)) for y in (-5, 5)])  # fmt: skip
    place = 2.0 * np.array([math.sqrt(0.75), 0, 0.5]) + 0.5 * np.array([-0.5, 0, math.sqrt(0.75)])
    start = Pose(rotation_about(ACROSS, -30 * DEGREE), place)
    problem = free_problem(
        obstacles={"slope": slope}, start=start, region=((-9, 0, 0), (9, 0, 9)),
        by=steps(0.5, 25.0, (0, 2)),
    )  # fmt: skip
    assert found(problem, 20) == []


def test_a_difference_is_seen() -> None:
    """Lattices of other steps differ."""
    one, other = free_problem(), free_problem(by=steps(rotation=30.0))
    assert list(differences(one.object_graph, lattice_of(other), 1.0, 1))
