"""Along walls that the object touches: what slides along is allowed, what runs into them is not."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.contact.environment import environment_contacts
from gm_ompl.feasibility.backends import make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.motion.arc import Moment
from gm_ompl.problem import Problem
from gm_ompl.sampling.motions import CoordinateModel
from gm_ompl.scenario.load import load

APPROACH = 1e-9
"""Of the fastest vertex's speed: slower counts as none."""


@pytest.fixture(scope="module")
def corner() -> Problem:
    """A box at rest in a corner: walls at x = -2 and y = 2, both touched."""
    return load("planar/corner").problem


def fastest_approach(problem: Problem, moment: Moment) -> float:
    """The greatest speed of a contact into what it touches, of the fastest vertex's speed."""
    pose, twist = moment.pose, moment.twist
    assert twist is not None
    contacts = environment_contacts(problem.body, problem.environment, pose)
    into = -(twist.at(contacts.points - pose.position) * contacts.normals).sum(axis=1)
    corners = twist.at(problem.body.vertices @ pose.rotation.T)
    return float(into.max(initial=0.0) / np.linalg.norm(corners, axis=1).max())


def test_no_motion_that_geometry_admits_has_a_contact_that_moves_into_a_wall(
    corner: Problem,
) -> None:
    """Random motions from poses at the walls: those into a wall end in it, and are refused."""
    rng = np.random.default_rng(5)
    model = CoordinateModel(corner, Judge(corner, make_backend(corner)))
    admitted = refused = 0
    for _ in range(300):
        touching = rng.integers(3)
        start = (0.0 if touching != 1 else rng.uniform(1, 6), 0.0 if touching else -1.0, 0.0)
        step = rng.choice([-1.0, 0.0, 1.0], size=3) * rng.uniform(1e-6, 1.0, size=3)
        if not step.any():
            continue
        end = tuple((np.array(start) + step * [1.0, 1.0, 0.2]).tolist())
        line = model.line(start, end)
        free = model.judge.along(line.arc).object_free
        at_wall = fastest_approach(corner, line.arc.moment(0.0)) > APPROACH
        if at_wall:
            assert not free
            refused += 1
        elif free:
            worst = max(fastest_approach(corner, moment) for moment in line.middles)
            assert worst <= APPROACH
            admitted += 1
    assert admitted > 20
    assert refused > 100
