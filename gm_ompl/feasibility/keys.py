"""What two questions must have in common to have the same answer: in mechanics, in geometry."""

from __future__ import annotations

from typing import TypeAlias, final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.contact.state import ContactState
from gm_ompl.geometry.pose import Pose
from gm_ompl.geometry.sweep import Sweep
from gm_ompl.problem import Problem

DECIMALS = 9
"""Contact states equal to so many decimals (lengths over D) share their decisions."""


def finger_kinds(problem: Problem) -> tuple[int, ...]:
    """Return per finger the first finger that is like it to the mechanics."""
    hand = problem.fingers
    limits, friction, soft = (a.tolist() for a in (hand.max_normal_force, hand.friction, hand.soft))
    traits = list(zip(limits, friction, soft, strict=True))
    return tuple(traits.index(trait) for trait in traits)


def spots(problem: Problem) -> tuple[Array, Array]:
    """Return where each finger may touch, and the normals there, (n, P, 3) each."""
    hand = problem.fingers
    shape = (hand.count, len(hand.placements), 3)
    points = np.broadcast_to(hand.placements.points, shape)
    return points, np.broadcast_to(hand.placements.normals, shape)


def contact_key(contacts: ContactState, diagonal: float) -> bytes:
    """Return what a mode decision depends on in ``contacts``, rounded relative to D.

    The order of the contacts does not matter.
    """
    columns: list[Array] = [contacts.points / diagonal, contacts.normals, contacts.slip]
    # Adding zero turns -0.0 into 0.0: they are different bytes.
    if contacts.surfaces.any():
        columns.append(contacts.surfaces[:, None].astype(np.float64))
    rows = np.round(np.concatenate(columns, axis=1), DECIMALS) + 0.0
    rotation = np.round(contacts.rotation, DECIMALS) + 0.0
    return rows[np.lexsort(rows.T)].tobytes() + rotation.tobytes()


PoseClass: TypeAlias = tuple[bytes, float]
"""How the object is turned, and its height over the floor."""

CLEARANCE = 1e-6
"""Added to the reach, relative to it, beside the gap that counts as a contact."""


@final
class PoseClasses:
    """Tells which poses are the same to geometry.

    Where object and hand reach no obstacle, only the floor is left, and moving along the floor
    changes nothing: contacts and free placements in the object frame are those of any other pose
    with the same rotation and height. A hand's base stands somewhere: there are no classes then.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: Problem) -> None:
        hand, body = problem.fingers, problem.body
        reach = float(np.linalg.norm(body.vertices, axis=1).max())
        for radius in set(hand.radius.tolist()):
            centres = np.linalg.norm(hand.placements.centres(radius), axis=1)
            reach = max(reach, float(centres.max(initial=0.0)) + radius)
        touching = problem.environment.contact_tolerance * body.diagonal
        self._square = ((1.0 + CLEARANCE) * reach + touching) ** 2
        self._corners, self._touching = body.vertices, (1.0 + CLEARANCE) * touching
        pieces = [piece for other in problem.environment.obstacles for piece in other.body.pieces]
        self._low = np.array([piece.bounds[0] for piece in pieces]).reshape(-1, 3)
        self._high = np.array([piece.bounds[1] for piece in pieces]).reshape(-1, 3)
        self._floor, self._anywhere = problem.environment.floor, problem.hand is None

    def of(self, pose: Pose) -> PoseClass | None:
        """Return the pose class at ``pose``; None where an obstacle, or a hand, may matter."""
        if not self._anywhere:
            return None
        if len(self._low):
            nearest = np.minimum(np.maximum(pose.position, self._low), self._high) - pose.position
            if (np.einsum("ij,ij->i", nearest, nearest) <= self._square).any():
                return None
        return pose.rotation.tobytes(), float(pose.position[2]) if self._floor else 0.0

    def of_contacts(self, pose: Pose) -> PoseClass | None:
        """Return the pose class as far as contacts go; None where an obstacle may be touched."""
        if len(self._low):
            corners = self._corners @ pose.rotation.T + pose.position
            apart = np.maximum(self._low - corners.max(axis=0), corners.min(axis=0) - self._high)
            if (apart.max(axis=1) <= self._touching).any():
                return None
        return pose.rotation.tobytes(), float(pose.position[2]) if self._floor else 0.0

    def alone(self, sweep: Sweep) -> bool:
        """Whether no obstacle may matter anywhere along ``sweep``."""
        if not len(self._low):
            return self._anywhere
        arms = sweep.arms(np.zeros((1, 3)))
        ends, wide = [sweep.moved(arms, t)[0] for t in (0.0, 1.0)], sweep.sagitta(arms)
        low, high = np.minimum(*ends) - wide, np.maximum(*ends) + wide
        gaps = np.maximum(np.maximum(self._low - high, low - self._high), 0.0)
        clear = (np.einsum("ij,ij->i", gaps, gaps) > self._square).all()
        return self._anywhere and bool(clear)
