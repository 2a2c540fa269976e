"""Arcs of the contact lattice without the place where they begin."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import Final, NamedTuple

import numpy as np

from gm_ompl.arrays import Array, cross
from gm_ompl.contact.lines import Line
from gm_ompl.geometry.pose import rotation_about
from gm_ompl.motion.screw import Piece, Slide, Tumble

DECIMALS: Final = 8
"""Heights and forms (over D), and places between the grid's (in steps), equal to so many decimals
are one."""


class Template(NamedTuple):
    """An arc without the place where it begins.

    Attributes:
        piece: the motion; a pivot is seen from the centre of mass.
        line: about which it turns, likewise; None for translations.
        by: (3,), the way of the centre of mass.
        extent: (2, 3), the least and greatest of its coordinates on that way, from where it begins.
        box: (2, 3), likewise of the whole object.
        rotation: (3, 3), of the object at the end.
        steps: how many steps of the lattice it is long.
        parts: number of segments.
        pitch: as ``Arc`` has it.
        goes_on: whether the rotation is under way at the end.
        kind: equal for the same motion of an object that stands alike where nothing but the floor
            is near.
    """

    piece: Piece
    line: Line | None
    by: Array
    extent: Array
    box: Array
    rotation: Array
    steps: float
    parts: int
    pitch: float | None
    goes_on: bool
    kind: Hashable


def form(piece: Piece, diagonal: float) -> Hashable:
    """Return what is equal for motions that are one, seen from the centre of mass."""
    if isinstance(piece, Slide):
        return (*(np.round(piece.by / diagonal, DECIMALS) + 0.0).tolist(),)
    beside = (piece.pivot - (piece.pivot @ piece.axis) * piece.axis) / diagonal
    numbers = np.round([*beside, *piece.axis, piece.angle], DECIMALS) + 0.0
    return (*numbers.tolist(),)


def extremes(turn: Tumble) -> Iterator[Array]:
    """Yield where a point that begins at the origin is while a coordinate is least or greatest."""
    arm = -turn.pivot
    still = (arm @ turn.axis) * turn.axis
    ahead = cross(turn.axis, arm)
    for k in range(3):
        highest = math.atan2(float(ahead[k]), float((arm - still)[k]))
        for angle in (highest, highest + math.pi):
            way = angle % math.tau if turn.angle > 0.0 else angle % math.tau - math.tau
            if 0.0 < way / turn.angle < 1.0:
                yield rotation_about(turn.axis, way) @ arm - arm
