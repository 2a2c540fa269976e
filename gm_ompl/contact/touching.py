"""Contacts of the object with its environment, compiled: what ``environment_contacts`` finds."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.compilation import compiled_as_written, inlined
from gm_ompl.contact.environment import Environment, environment_contacts
from gm_ompl.contact.patch import SAME_NORMAL
from gm_ompl.contact.patching import EDGES, Shapes, patch_of, placed_at, shapes
from gm_ompl.geometry.flat import outline
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body

NO_ROOM: Final = -1
"""There are more contacts than there is room for."""

UNTOLD: Final = -2
"""Several pieces touch one body, whose patches may be one, or edges may cross: rare, and left to
``environment_contacts``."""


class Solids(NamedTuple):
    """The object and what it may touch.

    Attributes:
        body: the object, object frame.
        obstacles: world frame.
        owners: (k,), the number of the obstacle that each of their pieces is part of, from 1.
        floor: whether there is one.
        tolerance: a gap or overlap of at most this is a contact.
        by_surface: whether contacts tell which surface they are on.
    """

    body: Shapes
    obstacles: Shapes
    owners: IntArray
    floor: bool
    tolerance: float
    by_surface: bool


def solids(body: Body, environment: Environment) -> Solids:
    """Return a body and its environment as compiled code reads them."""
    pieces = [(k, piece) for k, o in enumerate(environment.obstacles, 1) for piece in o.body.pieces]
    owners = np.array([k for k, _ in pieces], dtype=np.int64)
    tolerance = environment.contact_tolerance * body.diagonal
    fixed = shapes([piece for _, piece in pieces])
    kind = environment.floor, tolerance, environment.by_surface
    return Solids(shapes(body.pieces), fixed, owners, *kind)


class Sheet(NamedTuple):
    """Room for contacts.

    Attributes:
        points: (room, 3), world frame.
        normals: (room, 3), unit, into the object.
        surfaces: (room,), what each is on: 0 the floor, i + 1 obstacle i.
    """

    points: Array
    normals: Array
    surfaces: IntArray


def sheet(room: int) -> Sheet:
    """Return room for so many contacts."""
    return Sheet(np.empty((room, 3)), np.empty((room, 3)), np.empty(room, dtype=np.int64))


@compiled_as_written
def touched(R: Array, p: Array, world: Solids, onto: Sheet, first: int) -> int:
    """Write the contacts at a pose (3, 3), (3,) from row ``first`` on.

    Returns:
        The row past them, or ``NO_ROOM`` or ``UNTOLD``.
    """
    here, tolerance, normal = placed_at(world.body, R, p), world.tolerance, np.zeros(3)
    past, owner, patches, several, normal[2] = first, 0, 0, False, 1.0
    for k in range(len(here.ends) if world.floor else 0):
        if abs(here.boxes[k, 0, 2]) <= tolerance:
            past = _add(onto, first, past, _feet(here, k, tolerance), normal, (0, tolerance))
            patches += 1
    for j in range(len(world.obstacles.ends)):
        if owner != world.owners[j]:
            several |= patches > 1
            owner, patches = world.owners[j], 0
        for k in range(len(here.ends)):
            apart = False
            for c in range(3):
                apart |= here.boxes[k, 1, c] + tolerance < world.obstacles.boxes[j, 0, c]
                apart |= world.obstacles.boxes[j, 1, c] + tolerance < here.boxes[k, 0, c]
            if not apart:
                points = patch_of(here, k, world.obstacles, j, tolerance, normal)
                if len(points) == EDGES:
                    return UNTOLD
                on = owner if world.by_surface else 0
                past = _add(onto, first, past, points, normal, (on, tolerance))
                patches += len(points) > 0
    return UNTOLD if several or patches > 1 else past


@inlined
def _feet(here: Shapes, k: int, tolerance: float) -> Array:
    """Return the corners (k, 3) of the hull of what is on the floor, in the vertices' order."""
    start, count = here.ends[k, 0], 0
    n = here.ends[k, 1] - start
    which, flat = np.empty(n, dtype=np.int64), np.empty((n, 2))
    for i in range(start, start + n):
        if abs(here.rows[i, 2]) <= tolerance:
            which[count], flat[count, 0], flat[count, 1] = i, here.rows[i, 0], here.rows[i, 1]
            count += 1
    corners, feet = outline(flat[:count], tolerance), np.empty((count, 3))
    row = 0
    for i in range(count):
        for corner in corners:
            if corner == i:
                for c in range(3):
                    feet[row, c] = here.rows[which[i], c]
                row += 1
    return feet[:row]


@compiled_as_written
def _add(
    onto: Sheet, first: int, past: int, points: Array, normal: Array, kind: tuple[int, float]
) -> int:
    """Write contacts (k, 3) of a normal that differ from every earlier one; return what is past.

    Of what ``kind`` they are: what they are on, and the contact tolerance.
    """
    near = 2.0 * kind[1]
    for i in range(len(points)):
        known = False
        for j in range(first, past):
            alike = True
            for c in range(3):
                alike &= abs(points[i, c] - onto.points[j, c]) <= near
                alike &= abs(normal[c] - onto.normals[j, c]) <= SAME_NORMAL
            known |= alike
        if not known and past != NO_ROOM:
            if past == len(onto.points):
                past = NO_ROOM
            else:
                onto.surfaces[past] = kind[0]
                for c in range(3):
                    onto.points[past, c], onto.normals[past, c] = points[i, c], normal[c]
                past += 1
    return past


@final
class Toucher:
    """Finds the corners of contact patches.

    Args:
        body: the object, object frame.
        environment: what it may touch.

    Attributes:
        world: both, as compiled code reads them.
        floor: the same without obstacles.
    """

    def __init__(self, body: Body, environment: Environment) -> None:
        self._body, self._environment = body, replace(environment, patch_points=0)
        self.world = solids(body, self._environment)
        none = solids(body, replace(environment, obstacles=()))
        self.floor = self.world._replace(obstacles=none.obstacles, owners=none.owners)
        self._onto = sheet(64)

    def corners(self, R: Array, p: Array, *, with_obstacles: bool) -> tuple[Array, Array]:
        """Return points and normals (m, 3) at a pose (3, 3), (3,), world frame."""
        world = self.world if with_obstacles else self.floor
        past = touched(R, p, world, self._onto, 0)
        while past == NO_ROOM:
            self._onto = sheet(2 * len(self._onto.points))
            past = touched(R, p, world, self._onto, 0)
        if past >= 0:
            return self._onto.points[:past], self._onto.normals[:past]
        environment = self._environment
        if not with_obstacles:
            environment = replace(environment, obstacles=())
        found = environment_contacts(self._body, environment, Pose(R, p))
        return np.array(found.points), np.array(found.normals)
