"""Poses brought onto what they touch: contacts exact, nearest in the norm (7)."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, Obstacle, environment_contacts
from gm_ompl.contact.projection import UPRIGHT_WAYS, projected
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.solids import Body, box, hull, mass_properties

BRICK = Body((box([-1, -2, -0.5], [1, 2, 0.5]),))
SPREAD = mass_properties(BRICK, 1.0).inertia
FLOOR = Environment(True, (), 0.5)
SLAB = Environment(False, (Obstacle("slab", Body((box([-9, -9, -1], [9, 9, 0]),))),), 0.5)
CORNER = Environment(
    True,
    tuple(
        Obstacle(name, Body((box(low, high),)))
        for name, low, high in (("east", [1, -9, 0], [3, 9, 4]), ("north", [-9, 2, 0], [9, 4, 4]))
    ),
    0.5,
)


def disturbed(seed: int, part: float = 0.3) -> Pose:
    """Return a brick's pose on the ground, off by a part of the contact tolerance."""
    rng = np.random.default_rng(seed)
    size = part * 1e-5
    turn = rotation_about(rng.normal(size=3), size * rng.uniform(-1, 1))
    return Pose(turn, np.array([0, 0, 0.5]) + size * rng.uniform(-1, 1, size=3))


@pytest.mark.parametrize("environment", [FLOOR, SLAB, CORNER])
@pytest.mark.parametrize("seed", range(10))
def test_contacts_become_exact(environment: Environment, seed: int) -> None:
    """Every corner of every contact patch lies in its plane to 1e-10 D, as did none before."""
    before = disturbed(seed)
    after = projected(BRICK, environment, before, SPREAD)
    corners = after.apply(BRICK.vertices)
    assert abs(corners[:, 2].min()) <= 1e-10 * BRICK.diagonal
    assert np.ptp(np.sort(corners[:, 2])[:4]) <= 1e-10 * BRICK.diagonal
    if environment is CORNER:
        assert abs(corners[:, 0].max() - 1) <= 1e-10 * BRICK.diagonal
        assert abs(corners[:, 1].max() - 2) <= 1e-10 * BRICK.diagonal
    assert abs(before.apply(BRICK.vertices)[:, 2].min()) > 1e-8 * BRICK.diagonal
    assert len(environment_contacts(BRICK, environment, after).points) == (
        12 if environment is CORNER else 4
    )


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_pose_is_taken(seed: int) -> None:
    """No other pose on the floor is nearer in |v|^2 + w . (J / M) w: found by scipy, too."""
    before = disturbed(seed)
    after = projected(BRICK, FLOOR, before, SPREAD)
    scale = 1e-5

    def moved(d: Array) -> Pose:
        turn = rotation_about([1, 0, 0], d[3]) @ rotation_about([0, 1, 0], d[4])
        turn = turn @ rotation_about([0, 0, 1], d[5])
        return Pose(turn @ before.rotation, before.position + d[:3])

    def distance(d: Array) -> float:
        return float(d[:3] @ d[:3] + d[3:] @ SPREAD @ d[3:])

    feet = np.argsort(before.apply(BRICK.vertices)[:, 2])[:4]
    found = scipy.optimize.minimize(
        distance,
        np.zeros(6),
        method="SLSQP",
        constraints={
            "type": "eq",
            "fun": lambda d: moved(d * scale).apply(BRICK.vertices)[feet[:3], 2] / scale,
        },
        options={"ftol": 1e-14, "maxiter": 200},
    )
    other = moved(found.x * scale)
    assert np.abs(other.position - after.position).max() <= 1e-4 * scale
    assert np.abs(other.rotation - after.rotation).max() <= 1e-4 * scale


def test_an_exact_pose_stays_as_it_is() -> None:
    """To the bit: what touches already is not moved."""
    pose = Pose(np.eye(3), np.array([0.3, -0.2, 0.5]))
    assert projected(BRICK, FLOOR, pose, SPREAD) is pose
    far = Pose(np.eye(3), np.array([0.3, -0.2, 0.7]))
    assert projected(BRICK, FLOOR, far, SPREAD) is far


def test_ways_are_kept_to() -> None:
    """A planar motion's start rises and tilts; x, y and yaw are the user's."""
    before = disturbed(3)
    after = projected(BRICK, CORNER, before, SPREAD, UPRIGHT_WAYS)
    assert after.position[:2].tolist() == before.position[:2].tolist()
    assert abs(after.apply(BRICK.vertices)[:, 2].min()) <= 1e-10 * BRICK.diagonal


def test_a_corner_that_lies_in_no_plane_is_shared_out() -> None:
    """Four feet, one of them 30 nm high: the least sum of squares leaves a quarter at each."""
    corners = np.array(box([-0.05, -0.05, -0.05], [0.05, 0.05, 0.05]).vertices)
    corners[0, 2] += 3e-8
    body = Body((hull(corners),))
    spread = mass_properties(body, 1.0).inertia
    pose = Pose(np.eye(3), np.array([0, 0, 0.05 + 2e-8]))
    after = projected(body, FLOOR, pose, spread)
    heights = np.sort(after.apply(body.vertices)[:, 2])[:4]
    assert heights == pytest.approx([-7.5e-9, -7.5e-9, 7.5e-9, 7.5e-9], abs=1e-12)


def test_short_levers_do_not_fling_the_object() -> None:
    """A body on a knife's edge of two corners close together is not turned to fit their noise."""
    corners = [[0, 0, 0], [2e-4, 0, 1e-6], [-1, -1, 1], [1, -1, 1], [0, 1, 1]]
    wedge = Body((hull(np.array(corners)),))
    pose = Pose(np.eye(3), np.array([0, 0, 1e-6]))
    after = projected(wedge, FLOOR, pose, np.eye(3))
    moved = after.apply(wedge.vertices) - pose.apply(wedge.vertices)
    assert np.linalg.norm(moved, axis=1).max() <= 4.01e-5 * wedge.diagonal
