"""Turned about the vertical: the same z by the pyramid's symmetries, else within its error."""

from __future__ import annotations

import math

import pytest

from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.scenario.load import load

HANDS = ((20, 30), (0, 12), (3, 25))


@pytest.mark.parametrize("edges", [6, 12, 24, 48])
def test_at_rest_z_hangs_on_the_angle_as_far_as_the_pyramid_does(edges: int) -> None:
    """The pyramid's sides are 1 - cos(pi / s) inside the cone; z at any angle differs by less."""
    problem = load("planar/turn", [f"mechanics.cone_edges={edges}"]).problem
    judge = Judge(problem, make_backend(problem))

    def z(hand: tuple[int, int], degrees: float) -> float:
        pose = problem.motion.pose((0.0, 0.0, math.radians(degrees)))
        return judge.rest(pose, (0, 1), hand).z

    differ = 0.0
    for hand in HANDS:
        z_0 = z(hand, 0.0)
        assert z_0 > 1.0
        assert z(hand, 360.0 / edges) == pytest.approx(z_0, rel=1e-7)
        for degrees in (2.0, 7.0, 17.0, 23.0, 40.0):
            error = abs(z(hand, degrees) / z_0 - 1.0)
            assert error <= 1.0 - math.cos(math.pi / edges)
            differ = max(differ, error)
    assert differ > 1e-6
