"""Contact lines and turning lines of a pose, stated plainly: what an object may turn about."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gm_ompl.arrays import Array, cross, fix, unit
from gm_ompl.contact.environment import EnvironmentContacts

SAME = 1e-6
"""Lengths relative to D, directions and angles [rad] that differ by at most this are equal."""


@dataclass(frozen=True, eq=False)
class PlainLine:
    """A line in the world, without a sense.

    Attributes:
        point: (3,), a point of it.
        direction: (3,), unit.
    """

    point: Array
    direction: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", unit(self.direction))
        fix(self, point=(3,), direction=(3,))

    def off(self, point: Array) -> float:
        """Return how far ``point`` (3,) is from the line."""
        arm = point - self.point
        return float(np.linalg.norm(arm - (arm @ self.direction) * self.direction))

    def equals(self, other: PlainLine, diagonal: float) -> bool:
        """Whether two lines count as one; ``diagonal`` is D."""
        near = self.off(other.point) <= SAME * diagonal
        return near and parallel(self.direction, other.direction)


def parallel(a: Array, b: Array) -> bool:
    """Whether two unit vectors (3,) have one direction or opposite ones."""
    return float(np.linalg.norm(cross(a, b))) <= SAME


@dataclass(frozen=True, eq=False)
class Group:
    """Contacts with a common normal and plane.

    Attributes:
        points: (k, 3), world frame.
        normal: (3,), unit.
    """

    points: Array
    normal: Array


def groups(contacts: EnvironmentContacts, tolerance: float) -> list[Group]:
    """Return contacts by common normal and plane, whatever bodies they belong to.

    Args:
        contacts: of one pose, world frame.
        tolerance: the contact tolerance, a length.
    """
    members: list[tuple[Array, Array, list[Array]]] = []
    corners = len(contacts.points) if contacts.corners is None else contacts.corners
    for point, normal in zip(contacts.points[:corners], contacts.normals[:corners], strict=True):
        for first, common, points in members:
            level = abs(float(common @ (point - first)))
            if np.abs(common - normal).max() <= SAME and level <= tolerance:
                points.append(point)
                break
        else:
            members.append((point, normal, [point]))
    return [Group(np.array(points), normal) for _, normal, points in members]


def contact_lines(group: Group, tolerance: float) -> list[PlainLine]:
    """Return the lines along the edges of a group's hull in its plane.

    Any two points that leave all others on one side are an edge. The longest edge along a line
    names it. Of a single point: the lines through it along the world's axes.
    """
    points = group.points
    if len(points) == 1:
        return [PlainLine(points[0], axis) for axis in np.eye(3)]
    pairs = sorted(
        itertools.combinations(range(len(points)), 2),
        key=lambda pair: -float(np.linalg.norm(points[pair[1]] - points[pair[0]])),
    )
    lines: list[PlainLine] = []
    for i, j in pairs:
        if not np.linalg.norm(points[j] - points[i]) > tolerance:
            continue
        line = PlainLine(points[i], points[j] - points[i])
        heights = (points - points[i]) @ cross(group.normal, line.direction)
        if heights.min() < -tolerance and heights.max() > tolerance:
            continue
        if not any(max(known.off(points[i]), known.off(points[j])) <= tolerance for known in lines):
            lines.append(line)
    return lines or [PlainLine(points[0], axis) for axis in np.eye(3)]


def distinct(lines: Sequence[PlainLine], diagonal: float) -> Iterator[PlainLine]:
    """Yield lines that are equal once, the first of them."""
    kept: list[PlainLine] = []
    for line in lines:
        if not any(line.equals(other, diagonal) for other in kept):
            kept.append(line)
            yield line
