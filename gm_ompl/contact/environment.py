"""Contacts between the object and its environment, from geometry alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from gm_ompl.arrays import Array, IntArray, fix, surfaces_of
from gm_ompl.contact.patch import SAME_NORMAL, ContactPatch, contact_patch, joined, points_inside
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
        by_surface: whether contacts tell which surface they are on; it costs a little.
    """

    floor: bool
    obstacles: tuple[Obstacle, ...]
    friction: float
    patch_points: int = 0
    contact_tolerance: float = TOUCHING
    by_surface: bool = False


@dataclass(frozen=True, eq=False)
class EnvironmentContacts:
    """Contact points of the object with its environment at one pose, world frame.

    Attributes:
        points: (m, 3).
        normals: (m, 3), unit, pointing into the object.
        corners: how many of them, the first, are vertices of patches; the rest lie inside.
        surfaces: (m,), see ``ContactState``; empty where nobody asks.
    """

    points: Array
    normals: Array
    corners: int | None = None
    surfaces: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        fix(self, points=(None, 3))
        m = len(self.points)
        fix(self, normals=(m, 3))
        object.__setattr__(self, "surfaces", surfaces_of(self.surfaces, m))


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
    owned = list(_patches(body, environment, pose, tolerance))
    patches = [patch for _, patch in owned]
    if not patches:
        return EnvironmentContacts(np.zeros((0, 3)), np.zeros((0, 3)))
    corners = [patch.points for patch in patches]
    points, normals = _distinct(*_listed(corners, patches), tolerance)
    count = None
    if environment.patch_points:
        inner = [points_inside(patch, environment.patch_points) for patch in patches]
        inside, upright = _listed(inner, patches)
        every, all_normals = np.concatenate([points, inside]), np.concatenate([normals, upright])
        count, corners = len(points), corners + inner
        points, normals = _distinct(every, all_normals, tolerance)
    found = EnvironmentContacts(points, normals, count)
    if not environment.by_surface:
        return found
    owners = [k for k, _ in owned] * (len(corners) // len(patches))
    return replace(found, surfaces=_owners(found, corners, patches, owners))


def _owners(
    found: EnvironmentContacts, points: list[Array], patches: list[ContactPatch], owners: list[int]
) -> IntArray:
    """Return which surface each contact is on; the first of several at one place."""
    normals = [patch.normal for patch in patches] * (len(points) // len(patches))
    every = np.concatenate(points)
    upright = np.repeat(np.array(normals), [len(own) for own in points], axis=0)
    surface = np.repeat(np.array(owners), [len(own) for own in points])
    off = np.abs(found.points[:, None] - every).max(axis=2)
    off += np.abs(found.normals[:, None] - upright).max(axis=2)
    nearest: IntArray = surface[off.argmin(axis=1)]
    return nearest


def _listed(points: list[Array], patches: list[ContactPatch]) -> tuple[Array, Array]:
    """Return points (m, 3) of several patches one after the other, and their normals (m, 3)."""
    if len(patches) == 1:  # mostly, and quicker
        return points[0], np.full((len(points[0]), 3), patches[0].normal)
    normals = np.array([patch.normal for patch in patches])
    return np.concatenate(points), normals.repeat([len(own) for own in points], axis=0)


def _patches(
    body: Body, environment: Environment, pose: Pose, tolerance: float
) -> Iterator[tuple[int, ContactPatch]]:
    """Yield the patches with the number of what they are on: 0 the floor, i + 1 obstacle i."""
    pieces = [PlacedPiece(piece, pose) for piece in body.pieces]
    if environment.floor:
        feet = [_floor_patch(piece, tolerance) for piece in pieces]
        for foot in joined([foot for foot in feet if foot is not None], tolerance):
            yield 0, foot
    reaches = []
    if environment.obstacles:
        reaches = [[side.tolist() for side in piece.bounds] for piece in pieces]
    for number, obstacle in enumerate(environment.obstacles, 1):
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
        for patch in joined(found, tolerance):
            yield number, patch


def _floor_patch(piece: PlacedPiece, tolerance: float) -> ContactPatch | None:
    heights = piece.vertices[:, 2]
    if abs(heights.min()) > tolerance:
        return None
    feet = piece.vertices[np.abs(heights) <= tolerance]
    corners = convex_hull([(x, y) for x, y, _ in feet.tolist()], tolerance)
    # In the order of the vertices: where the cycle begins would hang on rounding.
    return ContactPatch(feet[sorted(corners)], UP)


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
    world, upright, surfaces = _needed(contacts, twist)
    if twist is None:
        slip = np.zeros(world.shape)
    else:
        arms = world - pose.position
        velocity = twist.at(arms)
        slow = AT_REST * twist.fastest(body.vertices @ pose.rotation.T)
        leaving = np.einsum("ij,ij->i", velocity, upright)
        stays = leaving <= slow
        if not stays.all():
            world, upright, surfaces = world[stays], upright[stays], surfaces[stays]
            velocity, leaving = velocity[stays], leaving[stays]
        tangential = velocity - leaving[:, None] * upright
        speed = np.sqrt(np.einsum("ij,ij->i", tangential, tangential))
        speed[speed <= slow] = np.inf  # at rest: no direction
        slip = (tangential / speed[:, None]) @ pose.rotation
    return ContactState(
        pose.to_object(world), upright @ pose.rotation, slip, pose.rotation, surfaces
    )


def contacts_at(moment: Moment, body: Body, environment: Environment) -> ContactState:
    """Return the contacts of the object with its environment at one instant of its motion."""
    touching = environment_contacts(body, environment, moment.pose)
    return contact_state(touching, moment.pose, moment.twist, body)


def _needed(contacts: EnvironmentContacts, twist: Twist | None) -> tuple[Array, Array, IntArray]:
    """Return points and normals (m, 3) and surfaces (m,) of the contacts the motion asks for."""
    points, normals, corners = contacts.points, contacts.normals, contacts.corners
    if corners is None:
        return points, normals, contacts.surfaces
    turns = np.zeros(len(points), dtype=bool)
    if twist is not None:
        turns = np.abs(normals @ twist.angular) > AT_REST * np.linalg.norm(twist.angular)
    turns[:corners] = True
    return points[turns], normals[turns], contacts.surfaces[turns]
