"""Contact patches of bodies of several pieces, points inside patches, sliding along a wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import linprog

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, Obstacle, contact_state, environment_contacts
from gm_ompl.contact.patch import ContactPatch, joined, points_inside
from gm_ompl.contact.state import Instant
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.solids import Body, box
from gm_ompl.reference.statics import statics

UP = np.array([0.0, 0.0, 1.0])
STILL = np.zeros(3)
AHEAD = np.array([1.0, 0.0, 0.0])


def lying(*obstacles: Body, patch_points: int = 0, floor: bool = True) -> Environment:
    named = tuple(Obstacle(str(k), body) for k, body in enumerate(obstacles))
    return Environment(floor, named, 0.5, patch_points)


def corners(contacts: object) -> list[list[float]]:
    points: Array = contacts.points  # type: ignore[attr-defined]
    return sorted((points.round(9) + 0.0).tolist())


def test_an_l_on_the_floor_is_one_patch() -> None:
    """The two pieces of an L lying flat touch the floor as one patch: its hull's five corners."""
    body = Body((box([0, 0, 0], [4, 1, 1]), box([0, 1, 0], [1, 4, 1])))
    found = environment_contacts(body, lying(), Pose(np.eye(3), STILL))
    assert corners(found) == [[0, 0, 0], [0, 4, 0], [1, 4, 0], [4, 0, 0], [4, 1, 0]]


def test_legs_apart_are_patches_of_their_own() -> None:
    """Feet with a gap between them keep their own corners, which matter when the object turns."""
    legs = [box([x, y, 0], [x + 1, y + 1, 2]) for x in (0, 4) for y in (0, 4)]
    table = Body((*legs, box([0, 0, 2], [5, 5, 3])))
    found = environment_contacts(table, lying(), Pose(np.eye(3), STILL))
    assert len(found.points) == 16


def test_pieces_of_an_obstacle_have_no_seam_where_they_are_flush() -> None:
    """A box across the seam of a two-piece slab touches it as it touches the slab in one piece."""
    top = Body((box([-1, -1, 0], [1, 1, 2]),))
    slab = Body((box([-5, -5, -1], [0.25, 5, 0]), box([0.25, -5, -1], [5, 5, 0])))
    whole = Body((box([-5, -5, -1], [5, 5, 0]),))
    for pose in (Pose(np.eye(3), STILL), Pose(np.eye(3), STILL).turned([1, 0, 0], [0, 1, 0], 0.4),
                 Pose(np.eye(3), STILL).turned([0, -1, 0], [1, 0, 0], 0.4)):  # fmt: skip
        split = environment_contacts(top, lying(slab, floor=False), pose)
        plain = environment_contacts(top, lying(whole, floor=False), pose)
        assert corners(split) == corners(plain)


def test_coincident_faces_inside_a_body_carry_nothing() -> None:
    """In an L's corner lies an obstacle: it touches both outer faces, the inner wall has none."""
    body = Body((box([0, 0, 0], [1, 2, 4]), box([1, 0, 0], [4, 2, 1])))
    block = Body((box([1, 0.5, 1], [3, 1.5, 3]),))
    found = environment_contacts(body, lying(block, floor=False), Pose(np.eye(3), STILL))
    upright = np.abs(found.normals[:, 2]) > 0.5
    assert len(found.points) == 8
    assert (found.points[upright, 2] == 1).all() and (found.points[~upright, 0] == 1).all()
    assert upright.sum() == 4


def test_patches_of_other_planes_are_not_joined() -> None:
    """Neither parallel planes nor tilted ones make one patch, nor do sides with a gap."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    tilted = np.array([0.0, math.sin(0.1), math.cos(0.1)])
    above, beside = square + np.array([0, 0, 0.1]), square + np.array([1.1, 0, 0])
    others = [ContactPatch(above, UP), ContactPatch(square, tilted), ContactPatch(beside, UP)]
    for other in others:
        assert len(list(joined([ContactPatch(square, UP), other], 1e-7))) == 2
    shifted = ContactPatch(square + np.array([1, 0.5, 0]), UP)
    assert len(list(joined([ContactPatch(square, UP), shifted], 1e-7))) == 1


@pytest.mark.parametrize("fineness", [1, 2, 3, 5])
def test_points_inside_divide_the_patch_evenly(fineness: int) -> None:
    """n sides, fineness k: n k^2 equal triangles, so 1 + n k (k + 1) / 2 - n points besides n."""
    for n in (3, 4, 7):
        angle = 2 * np.pi * np.arange(n) / n
        ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
        inner = points_inside(ContactPatch(ring, UP), fineness)
        assert len(inner) == 1 + n * fineness * (fineness + 1) // 2 - n
        every = np.concatenate([ring, inner])
        assert len(np.unique(every.round(9), axis=0)) == len(every)
        np.testing.assert_allclose(inner.mean(axis=0), 0, atol=1e-12)
        assert np.linalg.norm(inner, axis=1).max() <= 1.0 + 1e-12
    segment = points_inside(ContactPatch(ring[:2], UP), fineness)
    assert len(segment) == 2 * fineness - 1
    assert len(points_inside(ContactPatch(ring[:1], UP), fineness)) == 0


def test_points_inside_count_only_while_the_object_turns_on_them() -> None:
    """At rest and in translation the corners carry everything; under yaw all points slide."""
    body = Body((box([-2, -1, -1], [2, 1, 1]),))
    pose = Pose(np.eye(3), UP)
    contacts = environment_contacts(body, lying(patch_points=2), pose)
    slide, spin = Twist(AHEAD, STILL), Twist(STILL, 2.0 * UP)
    counts = [len(contact_state(contacts, pose, t, body).points) for t in (None, slide, spin)]
    assert counts == [4, 4, 4 + 1 + 4 * 3 - 4]
    turning = contact_state(contacts, pose, spin, body)
    arms = turning.points[:, :2]
    speed = np.linalg.norm(arms, axis=1)
    moving = speed > 1e-9
    assert moving.sum() == len(arms) - 1  # the middle rests
    want = np.stack([-arms[:, 1], arms[:, 0]], axis=1)[moving] / speed[moving, None]
    np.testing.assert_allclose(turning.slip[moving, :2], want, atol=1e-12)
    assert not turning.slip[~moving].any()


def test_sliding_along_a_wall_by_hand() -> None:
    """Floor and wall contacts slide along the motion; what the wall carries costs friction.

    A box of weight W is pushed along +x by a frictionless finger of limit F; a wall stands on its
    +y side. Pulled towards the wall by a force P, the wall answers P and drags mu P, so
    mu W + mu P <= F: the greatest P is F / mu - W. Without the wall no P > 0 can be held.
    """
    mu, F, mass, g = 0.3, 6.0, 1.0, 9.8
    body = Body((box([-4, -2, -1], [4, 2, 1]),))
    wall = Body((box([-20, 2, 0], [20, 3, 9]),))
    pose, along = Pose(np.eye(3), UP), Twist(AHEAD, STILL)
    for walls, want in (((wall,), F / mu - mass * g), ((), 0.0)):
        contacts = environment_contacts(body, lying(*walls), pose)
        state = contact_state(contacts, pose, along, body)
        sideways = state.normals[:, 1] < -0.5
        assert sideways.sum() == 4 * len(walls)
        np.testing.assert_allclose(state.points[sideways, 1], 2.0)
        np.testing.assert_array_equal(state.slip, np.tile([1.0, 0, 0], (len(state.slip), 1)))
        instant = Instant(
            contacts=state, points=np.array([[-4.0, 0, -0.5]]), normals=np.array([[1.0, 0, 0]]),
            friction=np.array([0.0]), max_normal_force=np.array([F]), environment_friction=mu,
            mass=mass, inertia=np.eye(3), gravity=g,
        )  # fmt: skip
        assert _greatest_force(instant, np.array([0, 1.0, 0, 0, 0, 0])) == pytest.approx(want)


def _greatest_force(instant: Instant, direction: Array) -> float:
    """The greatest disturbance along ``direction`` that the contacts and the finger balance."""
    model = statics(instant)
    env, rob = model.W_env @ model.C_env, model.W_rob @ model.C_rob
    columns = np.hstack([env, rob, direction[:, None]])
    limits = np.hstack([np.zeros((1, env.shape[1])), model.normal_parts, np.zeros((1, 1))])
    best = linprog(
        np.append(np.zeros(columns.shape[1] - 1), -1.0), A_ub=limits, b_ub=model.f_max,
        A_eq=columns, b_eq=-model.Q_known,
    )  # fmt: skip
    assert best.status == 0
    return float(-best.fun * model.scale)
