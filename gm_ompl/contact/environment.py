"""Contacts between the object and its environment, from geometry alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gm_ompl.arrays import Array, read_only
from gm_ompl.contact.patch import Patch, contact_patch
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.polygon import convex_hull
from gm_ompl.geometry.pose import Pose, Twist
from gm_ompl.geometry.separation import PlacedPiece, placed
from gm_ompl.geometry.solids import Body, ConvexPiece

TOUCHING = 1e-7
"""A gap of at most this, relative to D, is a contact."""

AT_REST = 1e-9
"""A velocity of at most this, relative to V, counts as none."""

SAME_NORMAL = 1e-6
"""Normals of one point that differ by less are one contact."""

UP = np.array([0.0, 0.0, 1.0])


class SolidBody(Protocol):
    """Whatever has a body; an ``Obstacle``."""

    @property
    def body(self) -> Body:
        """Its shape, world frame."""


class Surroundings(Protocol):
    """What the object can touch; an ``Environment``."""

    @property
    def floor(self) -> bool:
        """Whether the half space z < 0 is solid."""

    @property
    def obstacles(self) -> Sequence[SolidBody]:
        """Fixed bodies, world frame."""


@dataclass(frozen=True, eq=False)
class EnvironmentContacts:
    """Contact points of the object with its environment at one pose, world frame.

    Attributes:
        points: (m, 3).
        normals: (m, 3), unit, pointing into the object.
    """

    points: Array
    normals: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", read_only(self.points, (None, 3), "points"))
        shape = (len(self.points), 3)
        object.__setattr__(self, "normals", read_only(self.normals, shape, "normals"))


def environment_contacts(body: Body, environment: Surroundings, pose: Pose) -> EnvironmentContacts:
    """Return the vertices of every contact patch between the object and its environment.

    The floor's come first, then each obstacle's in turn; per patch in cyclic order. Contacts with
    equal point and normal are listed once. Each pair of convex pieces is looked at by itself: a
    corner or edge of the object exactly on the seam of two obstacles lies on the rim of both and
    so carries no force; one obstacle in their place has no seam.

    Args:
        body: the object, object frame.
        environment: floor and obstacles, world frame.
        pose: where the object is.
    """
    tolerance = TOUCHING * body.diagonal
    points: list[Array] = []
    normals: list[Array] = []
    for patch in _patches(body, environment, pose, tolerance):
        points.extend(patch.points)
        normals.extend([patch.normal] * len(patch.points))
    if not points:
        return EnvironmentContacts(np.zeros((0, 3)), np.zeros((0, 3)))
    kept = _distinct(np.array(points), np.array(normals), 2.0 * tolerance)
    return EnvironmentContacts(np.array(points)[kept], np.array(normals)[kept])


def _patches(
    body: Body, environment: Surroundings, pose: Pose, tolerance: float
) -> Iterator[Patch]:
    pieces = [placed(piece, pose) for piece in body.pieces]
    if environment.floor:
        for piece in pieces:
            patch = _floor_patch(piece, tolerance)
            if patch is not None:
                yield patch
    reaches = [[side.tolist() for side in piece.bounds] for piece in pieces]
    for obstacle in environment.obstacles:
        for other in obstacle.body.pieces:
            for piece, (low, high) in zip(pieces, reaches, strict=True):
                if _apart(other, low, high, tolerance):
                    continue
                patch = contact_patch(piece, placed(other), tolerance)
                if patch is not None:
                    yield patch


def _floor_patch(piece: PlacedPiece, tolerance: float) -> Patch | None:
    heights = piece.vertices[:, 2]
    if abs(heights.min()) > tolerance:
        return None
    feet = piece.vertices[np.abs(heights) <= tolerance]
    corners = convex_hull([(x, y) for x, y, _ in feet.tolist()], tolerance)
    # In the order of the vertices: where the cycle begins would hang on rounding.
    return Patch(feet[sorted(corners)], UP)


def _apart(other: ConvexPiece, low: list[float], high: list[float], tolerance: float) -> bool:
    """Whether bounding boxes alone show a gap wider than ``tolerance``."""
    least, greatest = other.bounds
    return any(high[k] + tolerance < least[k] or greatest[k] + tolerance < low[k] for k in range(3))


def _distinct(points: Array, normals: Array, tolerance: float) -> list[int]:
    """Return the rows whose point or normal differs from every earlier row's."""
    kept: list[int] = []
    for i in range(len(points)):
        near = np.abs(points[kept] - points[i]).max(axis=1, initial=0.0) <= tolerance
        alike = np.abs(normals[kept] - normals[i]).max(axis=1, initial=0.0) <= SAME_NORMAL
        if not (near & alike).any():
            kept.append(i)
    return kept


def contact_state(
    contacts: EnvironmentContacts, pose: Pose, twist: Twist | None, body: Body
) -> ContactState:
    """Return which contacts are static, slide or separate when the object moves by ``twist``.

    A contact whose point of the object leaves along the normal is left out; one that would move
    into the environment is kept: that such a motion penetrates is geometry's to refuse.

    Args:
        contacts: the contacts at ``pose``, world frame.
        pose: where the object is.
        twist: its velocity; None at rest, where every contact is static.
        body: the object, object frame.
    """
    points = pose.to_object(contacts.points)
    normals = contacts.normals @ pose.rotation
    slip = np.zeros_like(points)
    if twist is not None:
        velocity = twist.at(contacts.points - pose.position)
        fastest = np.linalg.norm(twist.at(body.vertices @ pose.rotation.T), axis=1).max()
        leaving = np.einsum("ij,ij->i", velocity, contacts.normals)
        tangential = velocity - leaving[:, None] * contacts.normals
        speed = np.linalg.norm(tangential, axis=1)
        slides = speed > AT_REST * fastest
        slip[slides] = (tangential[slides] / speed[slides, None]) @ pose.rotation
        stays = leaving <= AT_REST * fastest
        points, normals, slip = points[stays], normals[stays], slip[stays]
    return ContactState(points, normals, slip, pose.rotation)
