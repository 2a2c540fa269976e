"""A lifted finger's way: what is clear, and that a way around is found, clear and not absurd."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gm_ompl.arrays import Array
from gm_ompl.geometry.pose import Pose
from gm_ompl.problem import Problem
from gm_ompl.scenario.load import load
from gm_ompl.simulation.transit import Clearance, shortest


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Return a cuboid on the floor and two fingers."""
    return load("paper/slide").problem


def _pose(problem: Problem) -> Pose:
    return problem.motion.pose(problem.start)


def _corners(problem: Problem) -> Array:
    corners = np.concatenate([piece.vertices for piece in problem.body.pieces])
    placed: Array = _pose(problem).apply(corners)
    return placed


def _clearance(problem: Problem, margin: float = 0.0, **other: bool) -> Clearance:
    return Clearance(problem, _pose(problem), 0, np.empty((0, 3)), np.empty(0), margin, **other)


def test_clear_is_a_radius_and_the_margin_away(problem: Problem) -> None:
    """Above the object a fingertip is clear from a radius and the margin on, not before."""
    top, middle = _corners(problem)[:, 2].max(), _corners(problem).mean(axis=0)
    radius = float(problem.fingers.radius[0])
    for margin in (0.0, 0.5 * radius):
        clearance = _clearance(problem, margin)
        for share, free in ((0.99, False), (1.01, True)):
            point = np.array([middle[0], middle[1], top + share * (radius + margin)])
            assert clearance.free(point[None])[0] == free
    assert not _clearance(problem).free(middle[None])[0]


def test_floor_and_other_fingers_count(problem: Problem) -> None:
    """Below the floor or at another fingertip nothing is clear; of the object alone it is."""
    far = _corners(problem).max(axis=0) + problem.body.diagonal
    under = np.array([far[0], far[1], -0.01 * problem.body.diagonal])
    assert not _clearance(problem).free(under[None])[0]
    assert _clearance(problem, object_alone=True).free(under[None])[0]
    radius = float(problem.fingers.radius[0])
    beside = Clearance(problem, _pose(problem), 0, far[None], np.array([radius]), 0.0)
    steps = far + np.outer([1.9, 2.1], [radius, 0.0, 0.0])
    assert beside.free(steps).tolist() == [False, True]


def test_a_way_around_the_object(problem: Problem) -> None:
    """From one side to the other: clear all along, and little longer than over the top."""
    low, high = _corners(problem).min(axis=0), _corners(problem).max(axis=0)
    middle, gap = 0.5 * (low + high), 0.2 * problem.body.diagonal
    start = np.array([low[0] - gap, middle[1], middle[2] + gap])
    end = np.array([high[0] + gap, middle[1], middle[2] + gap])
    clearance = _clearance(problem, 0.01 * problem.body.diagonal)
    assert not clearance.line(start, end, 0.01 * gap)
    way = shortest(clearance, start, end, problem.body.diagonal)
    assert way is not None
    np.testing.assert_array_equal(way[[0, -1]], [start, end])
    for a, b in itertools.pairwise(way):
        assert _clearance(problem).line(a, b, 0.01 * gap)
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert (
        np.linalg.norm(end - start)
        < length
        < np.linalg.norm(end - start) + 4.0 * problem.body.diagonal
    )


def test_no_way_into_the_object(problem: Problem) -> None:
    """None is found to a place inside."""
    low, high = _corners(problem).min(axis=0), _corners(problem).max(axis=0)
    outside = high + problem.body.diagonal
    assert shortest(_clearance(problem), outside, 0.5 * (low + high), 0.2) is None
