from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import (
    Environment,
    EnvironmentContacts,
    Obstacle,
    contact_state,
    environment_contacts,
)
from gm_ompl.geometry.pose import Pose, Twist, rotation_about
from gm_ompl.geometry.solids import Body, ConvexPiece, box, hull

TALL = Body((box([-2.5, -2.5, -5], [2.5, 2.5, 5]),))
STANDING = Pose(np.eye(3), np.array([0.0, 0.0, 5.0]))


def surroundings(*pieces: ConvexPiece, floor: bool = True) -> Environment:
    obstacles = tuple(Obstacle(str(k), Body((piece,))) for k, piece in enumerate(pieces))
    return Environment(floor, obstacles, 0.5)


def rows(contacts: EnvironmentContacts, digits: int = 7) -> list[list[float]]:
    table = np.hstack([contacts.points, contacts.normals]).round(digits) + 0.0
    return sorted(table.tolist())


SLAB = box([-30, -30, -7], [30, 30, 0])


@pytest.mark.parametrize("environment", [surroundings(), surroundings(SLAB, floor=False)])
def test_tumbling_sweep_has_the_known_numbers_of_contacts(environment: Environment) -> None:
    """0 to 90 deg in 30 steps: 4 points, 29 times the 2 of the edge, 4; on floor and slab alike."""
    counts = []
    for step in range(31):
        pose = STANDING.turned([2.5, 0, 0], [0, 1, 0], np.pi / 60 * step)
        contacts = environment_contacts(TALL, environment, pose)
        np.testing.assert_allclose(contacts.normals, [[0, 0, 1]] * len(contacts.points))
        counts.append(len(contacts.points))
    assert counts == [4] + [2] * 29 + [4]


def test_floor_and_walls_each_give_their_points() -> None:
    """A box in a corner: 4 points below, 4 behind, 4 beside, normals into the object."""
    walls = (box([-9, -9, 0], [-2.5, 9, 9]), box([-9, 2.5, 0], [9, 9, 20]))
    contacts = environment_contacts(TALL, surroundings(*walls), STANDING)
    normals = contacts.normals.tolist()
    assert normals == [[0, 0, 1]] * 4 + [[1, 0, 0]] * 4 + [[0, -1, 0]] * 4
    assert contacts.points[4:8, 2].max() == 9, "the patch ends at the wall's top"


def test_equal_contacts_are_listed_once() -> None:
    """A slab level with the floor, and pieces sharing corners, add nothing twice."""
    alone = environment_contacts(TALL, surroundings(), STANDING)
    double = environment_contacts(TALL, surroundings(SLAB), STANDING)
    assert rows(alone) == rows(double)
    halves = Body((box([-2.5, -2.5, -5], [0, 2.5, 5]), box([0, -2.5, -5], [2.5, 2.5, 5])))
    split = environment_contacts(halves, surroundings(), STANDING)
    assert rows(split) == rows(alone)


def test_points_inside_the_patch_are_dropped() -> None:
    """On the floor only corners of the patch count, not vertices within it or along its sides."""
    grid = [[x, y, 0] for x in range(4) for y in range(4)]
    frustum = Body((hull([*grid, [1, 1, 2], [2, 1, 2], [1, 2, 2], [2, 2, 2]]),))
    contacts = environment_contacts(frustum, surroundings(), Pose(np.eye(3), np.zeros(3)))
    corners = [[x, y, 0, 0, 0, 1] for x in (0, 3) for y in (0, 3)]
    assert rows(contacts) == corners


@pytest.mark.parametrize("environment", [surroundings(), surroundings(SLAB, floor=False)])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
@pytest.mark.parametrize(("gap", "points"), [(0.9, 4), (-0.9, 4), (1.1, 0), (-1.1, 0)])
def test_contact_ends_at_the_tolerance(
    environment: Environment, gap: float, points: int, tolerance: float
) -> None:
    """Floor and obstacle alike touch up to a gap or depth of the tolerance, and not beyond."""
    environment = dataclasses.replace(environment, contact_tolerance=tolerance)
    rise = gap * tolerance * TALL.diagonal
    pose = Pose(np.eye(3), STANDING.position + np.array([0, 0, rise]))
    assert len(environment_contacts(TALL, environment, pose).points) == points


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([1e-3, 1e-1, 1.0, 1e2, 1e3]),
    st.sampled_from([0.0, 0.3, np.pi / 2]),
)
def test_contacts_move_along_with_the_world(seed: int, size: float, tilt: float) -> None:
    """A rigid motion of object and environment, and any change of unit, carry contacts along."""
    rng = np.random.default_rng(seed)
    ground, step = box([-9, -9, -1], [9, 9, 0]), box([2.5, -1, 0], [6, 7, 1.5])
    pose = STANDING.turned([-2.5, 0, 0], [0, 1, 0], -tilt)  # touches the step where tilt is 0
    before = environment_contacts(TALL, surroundings(ground, step, floor=False), pose)
    assert len(before.points) >= 2
    world = Pose.from_quaternion(rng.normal(size=3) * 5, rng.normal(size=4))
    moved = surroundings(
        *(hull(world.apply(piece.vertices) * size) for piece in (ground, step)), floor=False
    )
    there = Pose(world.rotation @ pose.rotation, world.apply(pose.position) * size)
    body = Body((hull(TALL.vertices * size),))
    after = environment_contacts(body, moved, there)
    back = EnvironmentContacts(world.to_object(after.points / size), after.normals @ world.rotation)
    np.testing.assert_allclose(rows(back, 5), rows(before, 5), atol=2e-5)


def twist(linear: Sequence[float], angular: Sequence[float] = (0, 0, 0)) -> Twist:
    return Twist(np.array(linear, dtype=float), np.array(angular, dtype=float))


def state(pose: Pose, motion: Twist | None, *walls: ConvexPiece) -> Any:
    contacts = environment_contacts(TALL, surroundings(*walls), pose)
    return contact_state(contacts, pose, motion, TALL)


WALL = box([-9, -9, 0], [-2.5, 9, 20])


def test_at_rest_all_contacts_are_static() -> None:
    """Without motion nothing slides or separates; points come in the object frame."""
    rest = state(STANDING, None, WALL)
    assert rest.points.shape == (8, 3)
    assert (rest.slip == 0).all()
    assert rest.points[:4, 2].tolist() == [-5] * 4


@pytest.mark.parametrize("speed", [1e-6, 1.0, 1e6])
def test_sliding_away_from_a_wall(speed: float) -> None:
    """Sliding along x at any speed: the floor's contacts slip along x, the wall's separate."""
    found = state(STANDING, twist([speed, 0, 0]), WALL)
    assert found.slip.tolist() == [[1, 0, 0]] * 4
    along = state(STANDING, twist([0, -speed, 0]), WALL)
    assert along.slip.tolist() == [[0, -1, 0]] * 8


def test_slip_is_in_the_object_frame() -> None:
    """A box turned by 90 deg about z that slides along the world's x slips along its own -y."""
    pose = Pose.from_yaw([0, 0, 5], np.pi / 2)
    found = state(pose, twist([3, 0, 0]))
    np.testing.assert_allclose(found.slip, [[0, -1, 0]] * 4, atol=1e-12)
    np.testing.assert_allclose(found.rotation, pose.rotation)


def tumbling(pose: Pose, pivot: Array, rate: float) -> Twist:
    omega = np.array([0, rate, 0])
    return Twist(np.cross(omega, pose.position - pivot), omega)


@pytest.mark.parametrize("angle", [0.0, 0.01, 0.7, 1.5])
@pytest.mark.parametrize("rate", [1e-3, 1.0, -1.0])
def test_tumbling_keeps_its_edge_static(angle: float, rate: float) -> None:
    """While tumbling either way about its edge, the two points of the edge are static."""
    pivot = np.array([2.5, 0, 0])
    pose = STANDING.turned(pivot, [0, 1, 0], angle)
    found = state(pose, tumbling(pose, pivot, rate))
    if angle == 0.0 and rate < 0:
        assert len(found.points) == 4, "pressing down into the floor separates nothing"
        return
    assert len(found.points) == 2
    assert (found.slip == 0).all()
    np.testing.assert_allclose(found.points[:, [0, 2]], [[2.5, -5]] * 2, atol=1e-9)


def test_yaw_slips_each_point_its_own_way() -> None:
    """Turning about the vertical, every contact slips across its own arm."""
    found = state(STANDING, twist([0, 0, 0], [0, 0, 2]))
    arms = found.points.copy()
    arms[:, 2] = 0
    want = np.cross([0, 0, 1], arms)
    np.testing.assert_allclose(
        found.slip, want / np.linalg.norm(want, axis=1, keepdims=True), atol=1e-12
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([1e-3, 1.0, 1e3]))
def test_classes_agree_with_finite_differences(seed: int, size: float) -> None:
    """Moved a little along its twist, a separating point has risen and a slipping one shifted."""
    rng = np.random.default_rng(seed)
    body = Body((box(np.array([-2.5, -2.5, -5]) * size, np.array([2.5, 2.5, 5]) * size),))
    pose = Pose(rotation_about([0, 0, 1], rng.uniform(0, 6)), np.array([0, 0, 5]) * size)
    up = rng.choice([0.0, 0.0, 0.5])
    motion = Twist(np.array([*rng.normal(size=2), up]) * size, np.array([0, 0, rng.normal()]))
    found = contact_state(environment_contacts(body, surroundings(), pose), pose, motion, body)
    h = 1e-6
    turn = rotation_about([0, 0, 1], float(motion.angular[2]) * h)
    later = Pose(turn @ pose.rotation, pose.position + h * motion.linear)
    if up:
        assert len(found.points) == 0
        return
    assert len(found.points) == 4
    steps = (later.apply(found.points) - pose.apply(found.points)) @ pose.rotation
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    np.testing.assert_allclose(found.slip, steps, atol=1e-4)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("fraction", "moves"), [(0.5e-9, False), (3e-9, True)])
def test_speeds_below_1e_9_of_the_fastest_vertex_count_as_none(
    size: float, fraction: float, moves: bool
) -> None:
    """While tumbling, an edge that creeps by 3e-9 V slides or lifts off; by 0.5e-9 V it rests."""
    body = Body((box(np.array([-2.5, -2.5, -5]) * size, np.array([2.5, 2.5, 5]) * size),))
    pivot = np.array([2.5, 0, 0]) * size
    pose = Pose(np.eye(3), np.array([0, 0, 5]) * size).turned(pivot, [0, 1, 0], 0.7)
    turn = tumbling(pose, pivot, 1.0)
    fastest = np.hypot(5, 10) * size  # the vertex across
    contacts = environment_contacts(body, surroundings(), pose)
    creeping, lifting = (
        contact_state(
            contacts, pose, Twist(turn.linear + fraction * fastest * np.eye(3)[k], turn.angular),
            body,
        )
        for k in (0, 2)
    )  # fmt: skip
    assert len(creeping.points) == 2
    assert (np.linalg.norm(creeping.slip, axis=1) > 0.5).all() == moves
    assert len(lifting.points) == (0 if moves else 2)
