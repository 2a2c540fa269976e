"""Contact lines: what the object can slide along and turn about without losing all its contacts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from gm_ompl.arrays import Array, unit
from gm_ompl.contact.environment import EnvironmentContacts
from gm_ompl.geometry.polygon import convex_hull, plane_basis

SAME = 1e-6
"""Directions that differ by at most this [rad], and lines by this (relative to D), are one."""


class Line(NamedTuple):
    """A line through ``point`` (3,) along the unit vector ``direction`` (3,)."""

    point: Array
    direction: Array

    def moved(self, by: Array) -> Line:
        """Return the line moved by (3,)."""
        return Line(self.point + by, self.direction)

    def same(self, other: Line, near: float) -> bool:
        """Whether the two are one line, to ``SAME`` and the length ``near``."""
        if not parallel(self.direction, other.direction):
            return False
        arm = self.point - other.point
        beside = arm - (arm @ other.direction) * other.direction
        return bool(beside @ beside <= near * near)


class ContactGroup(NamedTuple):
    """Contact points (k, 3) in one plane with one unit ``normal`` (3,) into the object."""

    points: Array
    normal: Array


def parallel(a: Array, b: Array) -> bool:
    """Whether two unit vectors (3,) lie along each other, whichever way."""
    off = a - (a @ b) * b
    return bool(off @ off <= SAME * SAME)


def contact_groups(contacts: EnvironmentContacts, tolerance: float) -> list[ContactGroup]:
    """Return the corners of all contact patches, those in one plane together.

    Args:
        contacts: at one pose, world frame.
        tolerance: how far from a plane a point may be (a length).
    """
    points, normals = contacts.points[: contacts.corners], contacts.normals[: contacts.corners]
    left, groups = list(range(len(points))), list[ContactGroup]()
    while left:
        normal = normals[left[0]]
        heights = points[left] @ normal
        alike = np.abs(normals[left] - normal).max(axis=1) <= SAME
        alike &= np.abs(heights - heights[0]) <= tolerance
        rows = [i for i, one in zip(left, alike.tolist(), strict=True) if one]
        groups.append(ContactGroup(points[rows], normal))
        left = [i for i in left if i not in rows]
    return groups


def rim_lines(group: ContactGroup, axes: Sequence[Array], tolerance: float) -> Iterator[Line]:
    """Yield the contact lines of a group.

    Args:
        group: the group.
        axes: (3,) each, directions of the lines through a lone point.
        tolerance: points so near to each other, or to a line, are one, or on it (a length).
    """
    basis = plane_basis(group.normal)
    flat = [(x, y) for x, y in (group.points @ basis.T).tolist()]
    corners = group.points[convex_hull(flat, tolerance)]
    if len(corners) == 1:
        yield from (Line(corners[0], axis) for axis in axes)
        return
    ends = corners[1:] if len(corners) == 2 else np.roll(corners, -1, axis=0)
    yield from (Line(a, unit(b - a)) for a, b in zip(corners, ends, strict=False))


def distinct(lines: Iterable[Line], near: float) -> list[Line]:
    """Return the lines without those that are the same to the length ``near``."""
    found: list[Line] = []
    for line in lines:
        if not any(line.same(other, near) for other in found):
            found.append(line)
    return found
