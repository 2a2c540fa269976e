"""Contacts between the object and its environment, from geometry alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, fix
from gm_ompl.contact.patch import SAME_NORMAL, Patch, contact_patch, joined, points_inside
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.polygon import convex_hull
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.separation import TOUCHING, PlacedPiece
from gm_ompl.geometry.solids import Body
from gm_ompl.motion.arc import Moment

AT_REST = 1e-9
"""A velocity of at most this, relative to V, counts as none."""

FEW = 32
"""Contacts of which all pairs are compared at once."""

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Obstacle:
    """A fixed body of the environment, world frame."""

    name: str
    body: Body


@dataclass(frozen=True)
class Environment:
    """What carries part of the object's weight and stands in the way.

    Attributes:
        floor: whether the half space z < 0 is solid.
        obstacles: fixed bodies, world frame.
        friction: Coulomb coefficient of every environment contact.
        patch_points: how finely a contact patch is filled with points while the object turns.
        contact_tolerance: a gap or overlap with the object of at most this, relative to D, is a
            contact.
    """

    floor: bool
    obstacles: tuple[Obstacle, ...]
    friction: float
    patch_points: int = 0
    contact_tolerance: float = TOUCHING


@dataclass(frozen=True, eq=False)
class EnvironmentContacts:
    """Contact points of the object with its environment at one pose, world frame.

    Attributes:
        points: (m, 3).
        normals: (m, 3), unit, pointing into the object.
        corners: how many of them, the first, are vertices of patches; the rest lie inside.
    """

    points: Array
    normals: Array
    corners: int | None = None

    def __post_init__(self) -> None:
        fix(self, points=(None, 3))
        fix(self, normals=(len(self.points), 3))


def environment_contacts(body: Body, environment: Environment, pose: Pose) -> EnvironmentContacts:
    """Return the vertices of every contact patch between the object and its environment.

    The floor's come first, then each obstacle's in turn; per patch in cyclic order; then the
    points inside patches. Contacts with equal point and normal are listed once. What the pieces
    of one body touch in one plane without a gap is one patch. Different obstacles are looked at
    by themselves: a corner or edge of the object exactly on the seam of two obstacles lies on the
    rim of both and so carries no force; one obstacle in their place has no seam.

    Args:
        body: the object, object frame.
        environment: floor and obstacles, world frame.
        pose: where the object is.
    """
    tolerance = environment.contact_tolerance * body.diagonal
    patches = list(_patches(body, environment, pose, tolerance))
    if not patches:
        return EnvironmentContacts(np.zeros((0, 3)), np.zeros((0, 3)))
    points, normals = _distinct(*_listed([patch.points for patch in patches], patches), tolerance)
    if environment.patch_points:
        inner = [points_inside(patch, environment.patch_points) for patch in patches]
        inside, upright = _listed(inner, patches)
        every, all_normals = np.concatenate([points, inside]), np.concatenate([normals, upright])
        return EnvironmentContacts(*_distinct(every, all_normals, tolerance), len(points))
    return EnvironmentContacts(points, normals)


def _listed(points: list[Array], patches: list[Patch]) -> tuple[Array, Array]:
    """Return points (m, 3) of several patches one after the other, and their normals (m, 3)."""
    normals = np.array([patch.normal for patch in patches])
    return np.concatenate(points), normals.repeat([len(own) for own in points], axis=0)


def _patches(body: Body, environment: Environment, pose: Pose, tolerance: float) -> Iterator[Patch]:
    pieces = [PlacedPiece(piece, pose) for piece in body.pieces]
    if environment.floor:
        feet = [_floor_patch(piece, tolerance) for piece in pieces]
        yield from joined([patch for patch in feet if patch is not None], tolerance)
    reaches = []
    if environment.obstacles:
        reaches = [[side.tolist() for side in piece.bounds] for piece in pieces]
    for obstacle in environment.obstacles:
        found = []
        for other in obstacle.body.pieces:
            for piece, (low, high) in zip(pieces, reaches, strict=True):
                least, most = other.bounds
                if any(
                    high[k] + tolerance < least[k] or most[k] + tolerance < low[k] for k in range(3)
                ):
                    continue
                patch = contact_patch(piece, PlacedPiece(other), tolerance)
                if patch is not None:
                    found.append(patch)
        yield from joined(found, tolerance)


def _floor_patch(piece: PlacedPiece, tolerance: float) -> Patch | None:
    heights = piece.vertices[:, 2]
    if abs(heights.min()) > tolerance:
        return None
    feet = piece.vertices[np.abs(heights) <= tolerance]
    corners = convex_hull([(x, y) for x, y, _ in feet.tolist()], tolerance)
    # In the order of the vertices: where the cycle begins would hang on rounding.
    return Patch(feet[sorted(corners)], UP)


def _distinct(points: Array, normals: Array, tolerance: float) -> tuple[Array, Array]:
    """Return the contacts whose point or normal differs from every earlier one's."""
    near = 2.0 * tolerance
    if len(points) <= FEW:  # mostly no two are alike, and one look at all pairs says so
        alike = (np.abs(points[:, None] - points) <= near).all(axis=2)
        alike &= (np.abs(normals[:, None] - normals) <= SAME_NORMAL).all(axis=2)
        if np.count_nonzero(alike) == len(points):
            return points, normals
    kept: list[int] = []
    for i in range(len(points)):
        alike = np.abs(points[kept] - points[i]).max(axis=1, initial=0.0) <= near
        alike &= np.abs(normals[kept] - normals[i]).max(axis=1, initial=0.0) <= SAME_NORMAL
        if not alike.any():
            kept.append(i)
    return points[kept], normals[kept]


def contact_state(
    contacts: EnvironmentContacts, pose: Pose, twist: Twist | None, body: Body
) -> ContactState:
    """Return which contacts are static, slide or separate when the object moves by ``twist``.

    A contact whose point of the object leaves along the normal is left out; one that would move
    into the environment is kept: that such a motion penetrates is geometry's to refuse. Points
    inside patches count only while the object turns about their normal: else the patch's vertices
    carry everything.

    Args:
        contacts: the contacts at ``pose``, world frame.
        pose: where the object is.
        twist: its velocity; None at rest, where every contact is static.
        body: the object, object frame.
    """
    world, upright = _needed(contacts, twist)
    if twist is None:
        slip = np.zeros(world.shape)
    else:
        arms = world - pose.position
        velocity = twist.at(arms)
        slow = AT_REST * twist.fastest(body.vertices @ pose.rotation.T)
        leaving = np.einsum("ij,ij->i", velocity, upright)
        stays = leaving <= slow
        if not stays.all():
            world, upright = world[stays], upright[stays]
            velocity, leaving = velocity[stays], leaving[stays]
        tangential = velocity - leaving[:, None] * upright
        speed = np.sqrt(np.einsum("ij,ij->i", tangential, tangential))
        speed[speed <= slow] = np.inf  # at rest: no direction
        slip = (tangential / speed[:, None]) @ pose.rotation
    return ContactState(pose.to_object(world), upright @ pose.rotation, slip, pose.rotation)


def contacts_at(moment: Moment, body: Body, environment: Environment) -> ContactState:
    """Return the contacts of the object with its environment at one instant of its motion."""
    touching = environment_contacts(body, environment, moment.pose)
    return contact_state(touching, moment.pose, moment.twist, body)


def _needed(contacts: EnvironmentContacts, twist: Twist | None) -> tuple[Array, Array]:
    """Return points and normals (m, 3) of the contacts that the motion asks for."""
    points, normals, corners = contacts.points, contacts.normals, contacts.corners
    if corners is None:
        return points, normals
    turns = np.zeros(len(points), dtype=bool)
    if twist is not None:
        turns = np.abs(normals @ twist.angular) > AT_REST * np.linalg.norm(twist.angular)
    turns[:corners] = True
    return points[turns], normals[turns]
