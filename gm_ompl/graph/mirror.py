"""Mirror symmetry: of two sets of placements that are each other's images one is enough.

Where a scenario is its own image in a vertical plane through the object's centre of mass at the
start, every plan that keeps the whole hand in place has an image that costs as much. Whatever is
not looked at here, or not its own image to 1e-9, counts as no symmetry.
"""

from __future__ import annotations

import math
from typing import Final, final

import numpy as np

from gm_ompl.arrays import Array, IntArray
from gm_ompl.contact.environment import Environment
from gm_ompl.contact.lines import SAME
from gm_ompl.feasibility.keys import spots
from gm_ompl.geometry.solids import Body
from gm_ompl.holds.sets import PlacementSets
from gm_ompl.mechanics.columns import hand_columns, wrench_norm
from gm_ompl.mechanics.instant import DIRECTIONS
from gm_ompl.motion.free import FreeMotion, PoseGoal
from gm_ompl.problem import Problem

NEAR: Final = 1e-9
"""How far an image may be off, lengths over D."""

NUMBERS: Final = 2**62
"""Sets are told apart by whole numbers below this."""


@final
class Orbits:
    """Sets of placements, and those that are their images.

    Args:
        problem: of free motion.
        rows: (S, n), sets in canonical order.

    Attributes:
        first: the sets that are as good as all, increasing: the first of each orbit.
    """

    def __init__(self, problem: Problem, rows: IntArray) -> None:
        self._images = _images(problem, rows)
        own = np.arange(len(rows))
        self.first = np.flatnonzero(self._images.min(axis=1, initial=len(rows)) >= own)
        self._taken = np.zeros(len(rows), dtype=bool)
        self._taken[self.first] = True

    def take(self, number: int) -> IntArray:
        """Return the images of a set that were in no answer yet, nor in ``first``."""
        images = np.unique(self._images[number])
        new: IntArray = images[~self._taken[images]]
        self._taken[new] = True
        return new


def _images(problem: Problem, rows: IntArray) -> IntArray:
    """Return the numbers of sets' images, (S, k); a set's own where there is no such set."""
    count = len(problem.fingers.placements)
    planes = list(mirrors(problem).values()) if len(rows) else []
    if not planes or count ** rows.shape[1] > NUMBERS:
        return np.zeros((len(rows), 0), dtype=np.int64)
    if len(planes) == 2:
        planes.append(planes[0][planes[1]])
    sets, radix = PlacementSets(problem.fingers.groups()), count ** np.arange(rows.shape[1])
    names = rows @ radix
    order = np.argsort(names)
    found = []
    for image in planes:
        wanted = sets.canonical_rows(image[rows]) @ radix
        places = np.searchsorted(names[order], wanted).clip(max=len(rows) - 1)
        numbers = order[places]
        found.append(np.where(names[numbers] == wanted, numbers, np.arange(len(rows))))
    return np.stack(found, axis=1)


def mirrors(problem: Problem) -> dict[int, IntArray]:
    """Return the planes in which a problem is its own image, and what they do to placements.

    The planes are at right angles to the world's x (0) or y (1), through the centre of mass at the
    start. With each comes the permutation (P,) of placements.
    """
    motion, settings, environment = problem.motion, problem.mechanics, problem.environment
    plain = (
        isinstance(motion, FreeMotion)
        # Half turns lead to one pose either way, and the lattice has the first of them alone.
        and motion.steps.rotation < math.pi - SAME
        and problem.hand is None
        and not (problem.uncertainty or settings.strong)
        # A contact's cone begins at an axis that may come out turned by half a turn.
        and settings.cone_edges % 2 == 0
        and not (environment.patch_points or environment.by_surface)
    )
    images = {axis: _image(problem, axis) for axis in (0, 1)} if plain else {}
    return {axis: image for axis, image in images.items() if image is not None}


def _image(problem: Problem, axis: int) -> IntArray | None:
    """Return what a mirror does to placements (P,); None where the problem is not its own image."""
    motion, D = problem.motion, problem.body.diagonal
    assert isinstance(motion, FreeMotion)
    world, R = np.eye(3), motion.start.rotation
    world[axis, axis] = -1.0
    own = R.T @ world @ R  # as the object sees it
    shift = (motion.start.position - world @ motion.start.position)[axis] * np.eye(3)[axis]
    pieces = _pieces_onto(problem.body, problem.body, own, np.zeros(3), NEAR * D)
    alike = _goes_alike(motion, world, own, shift, NEAR * D)
    alike = alike and _stands_alike(problem.environment, world, shift, NEAR * D)
    image = _placements_onto(problem, own, pieces) if alike and pieces is not None else None
    return image if image is not None and _holds_alike(problem, own, image) else None


def _goes_alike(motion: FreeMotion, world: Array, own: Array, shift: Array, near: float) -> bool:
    """Whether region, goal and the directions of rotations are their own images."""
    goal, low, high = motion.goal, *motion.region
    alike = _between(low, high, world, shift, near) and _turned_alike(goal, world, own)
    alike &= _between(goal.low, goal.high, world, shift, near)
    if motion.steps.rotate is not None:
        either = np.concatenate([motion.steps.rotate, -motion.steps.rotate])
        alike &= _alike(either @ world, either, NEAR)
    return alike


def _between(low: Array, high: Array, world: Array, shift: Array, near: float) -> bool:
    """Whether a box (3,), (3,) is its own image."""
    ends = np.sort(np.stack([low, high]) @ world + shift, axis=0)
    return bool(np.abs(ends - np.stack([low, high])).max() <= near)


def _turned_alike(goal: PoseGoal, world: Array, own: Array) -> bool:
    """Whether what a goal says of rotations is its own image."""
    off = 0.0
    if goal.rotation is not None:
        off = float(np.abs(world @ goal.rotation @ own - goal.rotation).max())
    if goal.up is not None:
        off = max(off, float(np.abs(own @ goal.up - goal.up).max()))
    return off <= NEAR


def _stands_alike(environment: Environment, world: Array, shift: Array, near: float) -> bool:
    """Whether every obstacle is the image of one."""
    bodies = [obstacle.body for obstacle in environment.obstacles]
    return all(
        any(_pieces_onto(body, other, world, shift, near) is not None for other in bodies)
        for body in bodies
    )


def _pieces_onto(
    body: Body, other: Body, mirror: Array, shift: Array, near: float
) -> IntArray | None:
    """Return which pieces of a body those of another are mirrored onto; None: they are not."""
    onto: list[int] = []
    for piece in other.pieces:
        vertices, normals = piece.vertices @ mirror.T + shift, piece.face_normals @ mirror.T
        images = [
            number
            for number, own in enumerate(body.pieces)
            if number not in onto
            and _alike(vertices, own.vertices, near)
            and _alike(normals, own.face_normals, NEAR)
        ]
        if not images:
            return None
        onto.append(images[0])
    return np.array(onto) if len(onto) == len(body.pieces) else None


def _placements_onto(problem: Problem, own: Array, pieces: IntArray) -> IntArray | None:
    """Return the placements' images (P,); None where some have none, or hands are restricted."""
    from scipy.spatial import cKDTree  # takes long to load

    hand, D = problem.fingers, problem.body.diagonal
    table = hand.placements
    if not len(table):
        return None
    places = np.concatenate([table.points / D, table.normals], axis=1)
    images = np.concatenate([table.points @ own.T / D, table.normals @ own.T], axis=1)
    off, numbers = cKDTree(places).query(images)
    image: IntArray = np.asarray(numbers, dtype=np.int64)
    wanted = [row for row in (*hand.start, *hand.goal) if row is not None]
    fits = (
        off.max() <= NEAR
        and (image[image] == np.arange(len(table))).all()
        and (table.piece[image] == pieces[table.piece]).all()
        and (image[wanted] == wanted).all()
    )
    return image if fits else None


def _holds_alike(problem: Problem, own: Array, image: IntArray) -> bool:
    """Whether disturbances, so the inertia, and all fingertips' columns are their own images."""
    hand, U = problem.fingers, wrench_norm(problem.mass, problem.inertia)
    mirror = np.zeros((6, 6))  # of wrenches: moments turn the other way
    mirror[:3, :3], mirror[3:, 3:] = own, -own
    scaled = U @ mirror @ np.linalg.inv(U)
    edges = problem.mechanics.cone_edges
    tips = hand_columns(*spots(problem), hand.friction, hand.soft, edges, U)
    near = NEAR * max(1.0, float(np.abs(tips).max(initial=0.0)))
    return _alike(DIRECTIONS @ scaled.T, DIRECTIONS, NEAR) and all(
        _alike(own_columns[row] @ scaled.T, own_columns[other], near)
        for own_columns in tips
        for row, other in enumerate(image.tolist())
    )


def _alike(a: Array, b: Array, near: float) -> bool:
    """Whether rows (m, k) and (m, k) are the same in some order."""
    if a.shape != b.shape:
        return False
    same = np.abs(a[:, None] - b).max(axis=2, initial=0.0) <= near
    return bool(same.any(axis=0).all() and same.any(axis=1).all())
