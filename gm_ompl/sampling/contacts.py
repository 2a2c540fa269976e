"""How the object touches at a pose, as its motions there need it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.environment import Environment, environment_contacts
from gm_ompl.contact.lines import Line, contact_groups, distinct, parallel, rim_lines
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.solids import Body

NEAR: Final = 1e-6
"""Lines as near to each other as this, relative to D, are one."""

MOST_NORMALS: Final = 4
"""Of so many contact planes all subsets are kept; of more, all of them or all but one."""


class Ways(NamedTuple):
    """How the object touches at a pose, seen from its centre of mass.

    Attributes:
        normals: (k, 3), of its contacts, none twice.
        lines: about which it may turn and keep a contact, or may turn freely where none is.
        slopes: (s, 3), unit directions of contact lines.
    """

    normals: Array
    lines: tuple[Line, ...]
    slopes: Array


def touching(body: Body, environment: Environment, pose: Pose, rotate: Array | None) -> Ways:
    """Return how the object touches at a pose.

    Args:
        body: the object, object frame.
        environment: what it may touch.
        pose: where it is.
        rotate: (k, 3), unit directions about which it may turn; None: any.
    """

    def turns(direction: Array) -> bool:
        return rotate is None or any(parallel(direction, axis) for axis in rotate)

    tolerance = environment.contact_tolerance * body.diagonal
    groups = contact_groups(environment_contacts(body, environment, pose), tolerance)
    turning = [axis for axis in np.eye(3) if turns(axis)]
    lines, slopes, normals = list[Line](), list[Array](), list[Array]()
    for group in groups:
        if not any(np.abs(group.normal - other).max() <= NEAR for other in normals):
            normals.append(group.normal)
        slopes += [line.direction for line in rim_lines(group, (), tolerance)]
        lines += [line for line in rim_lines(group, turning, tolerance) if turns(line.direction)]
    lines += [Line(pose.position, group.normal) for group in groups if turns(group.normal)]
    if not groups:
        lines = [Line(pose.position, axis) for axis in turning]
    moved = (line.moved(-pose.position) for line in lines)
    found = tuple(distinct(moved, NEAR * body.diagonal))
    return Ways(np.array(normals).reshape(-1, 3), found, np.array(slopes).reshape(-1, 3))


def subsets(normals: Array) -> Iterator[Array]:
    """Yield contact planes that are kept, all of them first."""
    k = len(normals)
    sizes = range(k, -1, -1) if k <= MOST_NORMALS else (k, k - 1)
    for size in sizes:
        for chosen in itertools.combinations(range(k), size):
            yield normals[list(chosen)]
